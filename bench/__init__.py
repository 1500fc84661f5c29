"""Measurements: run time against error, stability, skipping, activity, speed of simulation."""
