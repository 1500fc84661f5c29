"""Benchmark of programs of moves."""
