"""The reference: exact verdicts with certificates, STL reading, quantising, broad phase.

Nothing here imports from the RTL's or the environment's packages, and nothing shares an algorithm
with the RTL.
"""
