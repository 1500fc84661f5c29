"""Proofs: what is proved of the core for all inputs."""
