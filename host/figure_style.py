"""How A and B look in every view: told apart by colour, marker and line, for colour-blind eyes too."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Style:
    """The look of one triangle."""

    name: str
    colour: str
    marker: str
    marker_size: float
    hollow: bool
    line: str


# Colours of M. Okabe and K. Ito, "Color Universal Design", 2008. A's hollow markers go around B's.
A = Style("A", "#0072B2", "o", 11, True, "-")
B = Style("B", "#D55E00", "s", 6, False, "--")
STYLES = (A, B)
WITNESS = "#000000"
GAP = "#009E73"
MARGIN = "#6E6E6E"
SMALL, NORMAL, LARGE = 8.5, 10, 13
