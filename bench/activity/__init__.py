"""Switching activity of the multipliers and of the whole top, counted in simulation."""
