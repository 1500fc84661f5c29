"""The parameters with which the mesh engine is built."""

import re
from dataclasses import dataclass

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import check_width
from triaxis.sim.configuration import Configuration

# All that is simulated, and all that the RTL takes.
MOST_DEPTH, MOST_GROUP, MOST_LANES = 65536, 64, 32
LEAST_CYCLE_BITS, MOST_CYCLE_BITS = 2, 64


def _is_power_of_two(number: int) -> bool:
    return number > 0 and number & (number - 1) == 0


@dataclass(frozen=True)
class MeshConfiguration:
    """Parameters of triaxis_mesh; see its header. Raises InputError where they are out of range."""

    width: int = 16
    margin_bits: int = 16
    depth: int = 4096
    group: int = 8
    lanes: int = 8
    cycle_bits: int = 32
    gating: bool = True
    certified: bool = False

    def __post_init__(self) -> None:
        """Check the limits that the RTL checks at elaboration."""
        check_width(self.width)
        if not 0 <= self.margin_bits <= self.width:
            raise InputError(
                f"margin bits {self.margin_bits}: must be 0..{self.width} for width {self.width}"
            )
        for name in ("depth", "group", "lanes"):
            if not _is_power_of_two(getattr(self, name)):
                raise InputError(f"{name} {getattr(self, name)}: must be a power of two")
        for name, least, most in (
            ("depth", 2, MOST_DEPTH),
            ("group", 1, MOST_GROUP),
            ("lanes", 1, MOST_LANES),
            ("cycle_bits", LEAST_CYCLE_BITS, MOST_CYCLE_BITS),
        ):
            if not least <= getattr(self, name) <= most:
                raise InputError(f"{name.replace('_', ' ')} {getattr(self, name)}: must be {least}..{most}")
        if self.lanes > self.group or self.group * self.lanes > self.depth:
            raise InputError(
                f"lanes {self.lanes}, group {self.group}, depth {self.depth}: lanes must be at most the "
                "group, and group * lanes at most the depth"
            )

    @property
    def name(self) -> str:
        """Return a short name, for folders and tables: w16_m16_d4096_g8_l8, .."""
        parts = [
            f"w{self.width}",
            f"m{self.margin_bits}",
            f"d{self.depth}",
            f"g{self.group}",
            f"l{self.lanes}",
        ]
        if self.cycle_bits != 32:
            parts.append(f"c{self.cycle_bits}")
        if not self.gating:
            parts.append("ungated")
        if self.certified:
            parts.append("certified")
        return "_".join(parts)

    @property
    def index_bits(self) -> int:
        """Return the bits of a triangle's number."""
        return self.depth.bit_length() - 1

    @property
    def max_margin(self) -> int:
        """Return the largest margin that the engine can be given."""
        return (1 << self.margin_bits) - 1

    @property
    def max_cycles(self) -> int:
        """Return the number at which the count of clocks stays."""
        return (1 << self.cycle_bits) - 1

    @property
    def most_in_flight(self) -> int:
        """Return how many pairs may be in the core, or on their way to it: InFlight of triaxis_mesh."""
        core = Configuration(self.width, self.margin_bits, certified=self.certified)
        return core.queue_depth + 2

    @property
    def parameters(self) -> dict[str, int]:
        """Return the RTL's parameters."""
        return {
            "W": self.width,
            "M": self.margin_bits,
            "Depth": self.depth,
            "Group": self.group,
            "Lanes": self.lanes,
            "CycleBits": self.cycle_bits,
            "Gating": int(self.gating),
            "Certify": int(self.certified),
        }


_NAME = re.compile(r"mesh_w(\d+)_m(\d+)_d(\d+)_g(\d+)_l(\d+)(?:_c(\d+))?(_ungated)?(_certified)?")


def is_mesh_configuration(name: str) -> bool:
    """Return whether the name is one of the engine's configurations, and not of the core's."""
    return name.startswith("mesh_")


def parse_mesh_configuration(name: str) -> MeshConfiguration:
    """Return the configuration named mesh_ and its `MeshConfiguration.name`."""
    match = _NAME.fullmatch(name)
    if match is None:
        raise InputError(
            f"configuration {name}: must read mesh_w<width>_m<margin bits>_d<depth>_g<group>_l<lanes>"
            "[_c<cycle bits>][_ungated][_certified], as in mesh_w16_m16_d64_g8_l8"
        )
    numbers = [int(match[n]) for n in range(1, 6)]
    return MeshConfiguration(
        *numbers, cycle_bits=int(match[6] or 32), gating=not match[7], certified=bool(match[8])
    )
