"""Stimulus: families of pairs as arrays, and the sequences that send them."""
