"""What became of all runs, over time: one database, and the pages that are made of it."""
