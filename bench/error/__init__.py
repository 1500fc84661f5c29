"""Run time against error: the core, its reference and other packages on the same pairs."""
