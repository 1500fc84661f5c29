"""The parameters with which the mesh engine is built."""

from dataclasses import dataclass

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import check_width


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
        if not 2 <= self.depth <= 65536:
            raise InputError(f"depth {self.depth}: must be 2..65536")
        if self.lanes > self.group or self.group * self.lanes > self.depth:
            raise InputError(
                f"lanes {self.lanes}, group {self.group}, depth {self.depth}: lanes must be at most the "
                "group, and group * lanes at most the depth"
            )
        if not 2 <= self.cycle_bits <= 64:
            raise InputError(f"cycle bits {self.cycle_bits}: must be 2..64")

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
        }
