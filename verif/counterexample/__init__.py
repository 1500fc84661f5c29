"""Counterexamples: made small, drawn, and kept as regression cases."""
