"""Numerical stability: the core and published floating-point methods on ever harder pairs of triangles."""
