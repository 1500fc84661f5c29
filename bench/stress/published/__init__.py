"""Published triangle tests that floating-point programs use, written anew in NumPy from their papers.

Each is a function of two arrays of triangles, (3, 3, N) each: vertex, coordinate, pair; it says which pairs
it takes for touching or overlapping, (N,). It computes in the type of its input and in the order that its
paper gives, without tolerances. In exact arithmetic (arrays of Python's integers or Fractions) each is right
for every pair of proper triangles: what it gets wrong there on floats is rounding.
"""
