"""Proofs of the core, the mesh engine and the board's go, for all inputs, and of the theory behind them.

By assertions in the harnesses of rtl/, by algebra on netlists, by Coq; and which registers they look at.
"""
