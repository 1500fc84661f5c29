"""Synthesis estimates for the board's part."""
