"""Exhaustive runs: every ordered pair of triangles on a small grid, degenerate ones included."""
