"""The parameters with which the board is built."""

import re
from dataclasses import dataclass

from triaxis.golden.errors import InputError
from triaxis.sim.mesh_configuration import MeshConfiguration

# Counts of triangles have 16 bits on the line.
MOST_BOARD_DEPTH = 32768


# The top's own times, with which the board ships: its header says what they are.
TOP_TIMES = {
    "clocks_per_three_bits": 25,
    "watchdog_clocks": 10_000_000,
    "hold_clocks": 100_000,
    "digit_clocks": 12_500,
    "beat_clocks": 50_000,
}
_PLAIN, _REAL = "_plain", "_real"


@dataclass(frozen=True)
class BoardParameters:
    """Parameters of nexys4ddr_top; see its header. The defaults suit simulation: a small, fast board.

    Times are in clocks of 10 ns; ``hold_clocks``: the unit of a run's hold. ``certify``: each "clear" of the
    core is shown again. Raises InputError where they are out of range.
    """

    width: int = 16
    margin_bits: int = 16
    depth: int = 64
    group: int = 8
    lanes: int = 8
    clocks_per_three_bits: int = 12
    watchdog_clocks: int = 10_000_000
    hold_clocks: int = 100_000
    build_id: int = 0
    digit_clocks: int = 16
    beat_clocks: int = 50
    certify: bool = True

    def __post_init__(self) -> None:
        """Check the limits that the RTL checks at elaboration."""
        if self.engine.depth > MOST_BOARD_DEPTH:
            raise InputError(f"depth {self.depth}: must be at most {MOST_BOARD_DEPTH} on the board")
        if self.clocks_per_three_bits < 12:
            raise InputError(f"clocks per three bits {self.clocks_per_three_bits}: must be at least 12")

    @property
    def name(self) -> str:
        """Return a short name, for folders; of times it tells whether they are the top's own."""
        real = _REAL if all(getattr(self, name) == clocks for name, clocks in TOP_TIMES.items()) else ""
        sizes = f"w{self.width}_m{self.margin_bits}_d{self.depth}_g{self.group}_l{self.lanes}"
        return f"board_{sizes}{'' if self.certify else _PLAIN}{real}"

    @property
    def engine(self) -> MeshConfiguration:
        """Return the configuration of the engine on it; raise InputError where there is none."""
        return MeshConfiguration(
            self.width, self.margin_bits, self.depth, self.group, self.lanes, certified=self.certify
        )

    @property
    def max_margin(self) -> int:
        """Return the largest margin that a run can be given."""
        return (1 << self.margin_bits) - 1

    @property
    def sizes(self) -> dict[str, int]:
        """Return the RTL's parameters but for times and the build's number."""
        return {
            "W": self.width,
            "M": self.margin_bits,
            "Depth": self.depth,
            "Group": self.group,
            "Lanes": self.lanes,
        }

    @property
    def rtl(self) -> dict[str, int]:
        """Return the RTL's parameters."""
        return {
            **self.sizes,
            "Certify": int(self.certify),
            "ClocksPerThreeBits": self.clocks_per_three_bits,
            "WatchdogClocks": self.watchdog_clocks,
            "HoldClocks": self.hold_clocks,
            "BuildId": self.build_id,
            "DigitClocks": self.digit_clocks,
            "BeatClocks": self.beat_clocks,
        }


_NAME = re.compile(r"board_w(\d+)_m(\d+)_d(\d+)_g(\d+)_l(\d+)(_plain)?(_real)?")
# In which times are short enough to be waited for again and again, and no powers of two, by which a counter
# could be right without being asked; the number has bytes that framing escapes.
_TIMES = {"watchdog_clocks": 60_000, "hold_clocks": 1_700, "clocks_per_three_bits": 17, "digit_clocks": 15}
_BUILD_ID = 0xC0DBDCDD


def is_board_configuration(name: str) -> bool:
    """Return whether the name is one of the board's configurations."""
    return name.startswith("board_")


def parse_board_configuration(name: str) -> BoardParameters:
    """Return the board of that `BoardParameters.name` as its environment builds it: times short, or real."""
    match = _NAME.fullmatch(name)
    if match is None:
        raise InputError(
            f"configuration {name}: must read board_w<width>_m<margin bits>_d<depth>_g<group>_l<lanes>, "
            f"as in board_w12_m5_d128_g8_l4; behind it {_PLAIN} for a core that certifies nothing, and then "
            f"{_REAL} for the top's own times"
        )
    *sizes, plain, real = match.groups()
    times = TOP_TIMES if real else _TIMES
    return BoardParameters(*map(int, sizes), **times, build_id=_BUILD_ID, certify=not plain)
