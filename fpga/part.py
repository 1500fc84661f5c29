"""What the board's part offers, and what the core may take of it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Resources:
    """DSP blocks, look-up tables and flip-flops."""

    dsps: int
    luts: int
    ffs: int


# XC7A100T, from the 7 Series FPGAs Overview (DS180).
XC7A100T = Resources(dsps=240, luts=63_400, ffs=126_800)
