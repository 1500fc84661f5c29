"""Upsets: bits of registers and memories inverted while the board runs, and what comes of it."""
