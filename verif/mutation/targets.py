"""The models in which mutants are looked for: chosen so that every generate branch is in one of them."""

from collections.abc import Mapping
from dataclasses import dataclass

from triaxis.verif.configuration import Configuration, parse_configuration


@dataclass(frozen=True)
class Target:
    """A top module in one configuration. ``latency``: clocks, as the README's table has them."""

    name: str
    top: str
    configuration: Configuration
    latency: int

    @property
    def combinational(self) -> bool:
        """Return whether this is the wrapper, which has no clock."""
        return self.top == "CollisionDetector"

    @property
    def asserted(self) -> bool:
        """Return whether the assertions of verif/sva/ go with it."""
        return not self.combinational

    @property
    def harness(self) -> str:
        """Return the file of the harness."""
        return "detector.cpp" if self.combinational else "core.cpp"

    @property
    def parameters(self) -> Mapping[str, int]:
        """Return the parameters of the top module."""
        return {"W": self.configuration.width} if self.combinational else self.configuration.parameters


def _core(name: str, latency: int) -> Target:
    return Target(name, "triaxis_core", parse_configuration(name), latency)


# Narrow where possible: extremes are as likely as anything else, and a simulation is fast.
MAIN = _core("w8_m8", 22)
# Without margins; multipliers that are split and swapped; padding above the coordinates.
PLAIN = _core("w18_m0_t1", 24)
# Both operands of multipliers split; no edge x box axes, no gating.
WIDE = _core("w32_m0_no_edge_box_ungated", 26)
WRAPPER = Target("detector_w8", "CollisionDetector", Configuration(8, 0), 0)

# The smallest: what a mutant that needs a build of its own is built as first.
SMALLEST = _core("w8_m0_no_edge_box", 21)

# Where the top piece of a multiplier's operand fills the 25-bit port, and the 18-bit one. For what survives
# everywhere else.
FULL_PIECES = (_core("w23_m17_t1", 25), _core("w24_m24_t1", 25))

TARGETS = (MAIN, PLAIN, WIDE, WRAPPER)
