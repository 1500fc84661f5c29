"""What every environment stands on: runs of tests, each in a process of its own."""
