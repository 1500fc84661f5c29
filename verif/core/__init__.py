"""The pyuvm environment of the core: agents, sequences, scoreboard, tests."""
