"""The reference: exact verdicts with certificates, bulk checker, scenes; reading inputs, writing outputs.

Nothing here imports from the RTL's or the environment's packages, and nothing shares an algorithm
with the RTL.
"""
