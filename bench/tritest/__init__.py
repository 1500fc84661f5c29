"""TriTest: pairs of triangles with proofs of what is right, and what other programs make of them."""
