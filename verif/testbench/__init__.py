"""What every environment stands on: one run of one test in its own simulator process."""
