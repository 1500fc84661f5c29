"""The board's whole design, simulated: from the pins of its serial line to its outputs."""
