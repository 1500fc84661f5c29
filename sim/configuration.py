"""The parameters with which the core is built, plain or certified."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import check_width

# The core's latency in clocks without margins, from the first width that has it; one more with margins. What
# docs/interface.md promises, and what the RTL is held against.
FIRST_WIDTHS = {8: 24, 13: 25, 18: 27, 25: 29}
# What the certified core takes longer, with margins or without.
CERTIFIED_FIRST_WIDTHS = {8: 17, 12: 18, 18: 20, 25: 22}
MOST_TAG_BITS = 64
# What a pair of the certified core tries, above its tag: try_t of triaxis_pkg.
TRY_BITS = 7
CORE_TOP, CERTIFIED_TOP = "triaxis_core", "triaxis_certified_core"


def _from(first_widths: Mapping[int, int], width: int) -> int:
    return first_widths[max(first for first in first_widths if first <= width)]


@dataclass(frozen=True)
class Configuration:
    """Parameters of triaxis_core; see its header. Raises InputError where they are out of range.

    ``certified``: of triaxis_certified_core, which has the same.
    """

    width: int = 16
    margin_bits: int = 0
    tag_bits: int = 16
    edge_box: bool = True
    gating: bool = True
    certified: bool = False

    def __post_init__(self) -> None:
        """Check the limits that the RTL checks at elaboration."""
        check_width(self.width)
        if not 0 <= self.margin_bits <= self.width:
            raise InputError(
                f"margin bits {self.margin_bits}: must be 0..{self.width} for width {self.width}"
            )
        # The environment keeps all that is sent with a pair in as many bits.
        most = MOST_TAG_BITS - (self.sent_bits - self.tag_bits)
        if not 1 <= self.tag_bits <= most:
            raise InputError(f"tag bits {self.tag_bits}: must be 1..{most}")
        if not self.edge_box and self.margin_bits:
            raise InputError("a core without the edge x box axes needs 0 margin bits")

    @property
    def name(self) -> str:
        """Return a short name, for folders and tables: w16_m0, w16_m0_no_edge_box, .."""
        parts = [f"w{self.width}", f"m{self.margin_bits}"]
        if self.tag_bits != 16:
            parts.append(f"t{self.tag_bits}")
        if not self.edge_box:
            parts.append("no_edge_box")
        if not self.gating:
            parts.append("ungated")
        if self.certified:
            parts.append("certified")
        return "_".join(parts)

    @property
    def max_margin(self) -> int:
        """Return the largest margin that the core can be given."""
        return (1 << self.margin_bits) - 1

    @property
    def top(self) -> str:
        """Return the name of the module."""
        return CERTIFIED_TOP if self.certified else CORE_TOP

    @property
    def sent_bits(self) -> int:
        """Return the bits of TUSER above the margin: the tag, and what the pair tries."""
        return self.tag_bits + TRY_BITS * self.certified

    @property
    def latency(self) -> int:
        """Return core_latency(W, M), or certified_latency(W, M), as it is signed off, in clocks."""
        plain = _from(FIRST_WIDTHS, self.width) + (self.margin_bits > 0)
        return plain + self.certified * _from(CERTIFIED_FIRST_WIDTHS, self.width)

    @property
    def queue_depth(self) -> int:
        """Return how many pairs can be in flight: Depth of triaxis_core, the next power of two."""
        return 1 << (self.latency - 1).bit_length()

    @property
    def parameters(self) -> dict[str, int]:
        """Return the RTL's parameters."""
        return {
            "W": self.width,
            "M": self.margin_bits,
            "TAG": self.tag_bits,
            "EdgeBox": int(self.edge_box),
            "Gating": int(self.gating),
        }


_NAME = re.compile(r"w(\d+)_m(\d+)(?:_t(\d+))?(_no_edge_box)?(_ungated)?(_certified)?")


def parse_configuration(name: str) -> Configuration:
    """Return the configuration of that name: the inverse of `Configuration.name`."""
    match = _NAME.fullmatch(name)
    if match is None:
        raise InputError(
            f"configuration {name}: must read w<width>_m<margin bits>[_t<tag bits>][_no_edge_box]"
            "[_ungated][_certified], as in w16_m0"
        )
    numbers = int(match[1]), int(match[2]), int(match[3] or 16)
    return Configuration(*numbers, not match[4], not match[5], bool(match[6]))
