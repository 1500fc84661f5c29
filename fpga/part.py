"""What the board's part offers, and what a build may take of it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Resources:
    """DSP blocks, look-up tables, flip-flops, and block RAMs of 36 kbit; one of 18 kbit counts as half."""

    dsps: int
    luts: int
    ffs: int
    brams: float = 0


@dataclass(frozen=True)
class Limits:
    """The most that a build may take of each; None: no limit of its own."""

    dsps: int | None = None
    luts: int | None = None
    ffs: int | None = None
    brams: float | None = None

    def exceeded(self, used: Resources) -> list[str]:
        """Return the names of the resources of which more is used."""
        bounds = vars(self)
        return [name for name, bound in bounds.items() if bound is not None and getattr(used, name) > bound]


# XC7A100T, from the 7 Series FPGAs Overview (DS180).
XC7A100T = Resources(dsps=240, luts=63_400, ffs=126_800, brams=135)

NO_LIMITS = Limits()
# Room for routing, and for what comes later.
BOARD_LIMITS = Limits(dsps=200, luts=XC7A100T.luts * 70 // 100, brams=XC7A100T.brams * 0.8)
WHOLE_PART = Limits(**vars(XC7A100T))
