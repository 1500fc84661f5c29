"""The environment that signs the core off: agents, sequences, scoreboard, tests, builds."""
