"""The sign-off run: every test in every configuration, scenes end to end, one result."""
