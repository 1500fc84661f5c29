"""Regressions on dvsim: its configuration, and what goes around it."""
