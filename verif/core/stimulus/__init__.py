"""Stimulus: families of pairs as arrays, with the margins at which they are asked."""
