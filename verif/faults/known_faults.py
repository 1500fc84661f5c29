"""The catalogue of faults: those of the design that this core replaces, those of the board, further ones.

Each fault of the core, the mesh engine or the board is a diff in patches/, by the fault's name. F9 and F10
were no faults of the design but of its testbench: they are tried on our own environment.
"""

from dataclasses import dataclass
from enum import Enum
from functools import partial
from pathlib import Path

from triaxis.golden.errors import InputError

PATCHES = Path(__file__).with_name("patches")


class Kind(Enum):
    """Where a fault sits, and so what must catch it."""

    CORE = "the core"
    ENGINE = "the mesh engine"
    BOARD = "the board"
    WRAPPER = "the wrapper CollisionDetector"
    ENVIRONMENT = "the environment"


@dataclass(frozen=True)
class Fault:
    """A fault; ``story`` says what it does, ``config`` names the build in which it is looked for.

    ``replaced``: it is one of the replaced design's. ``patch`` is None for faults of an environment.
    """

    name: str
    title: str
    story: str
    kind: Kind = Kind.CORE
    config: str = "w16_m0"
    replaced: bool = True
    patch: Path | None = None

    @property
    def signed_off(self) -> bool:
        """Return whether a sign-off must see it caught: one of the replaced design's, or of what says go."""
        return self.replaced or self.kind is Kind.BOARD


def _replaced(name: str, title: str, story: str, kind: Kind = Kind.CORE) -> Fault:
    patch = None if kind is Kind.ENVIRONMENT else PATCHES / f"{name}.patch"
    return Fault(name, title, story, kind, patch=patch)


def _above(kind: Kind, config: str, name: str, story: str) -> Fault:
    title = name.partition("-")[2].replace("-", " ")
    return Fault(name, title, story, kind, config, False, PATCHES / f"{name}.patch")


_engine = partial(_above, Kind.ENGINE, "mesh_w8_m8_d32_g4_l2")
_board = partial(_above, Kind.BOARD, "board_w12_m5_d128_g8_l4")


def _further(name: str, story: str, config: str = "w16_m0") -> Fault:
    title = name.replace("-", " ")
    return Fault(name, title, story, config=config, replaced=False, patch=PATCHES / f"{name}.patch")


FAULTS = (
    _replaced(
        "F1-box", "sign, box axes",
        "The second half of the overlap test asks for max > min where max < min is meant: here in the test "
        "of the boxes.",
    ),
    _replaced(
        "F1-space", "sign, axes in space",
        "The same sign in the test of the normals and of edge x edge.",
    ),
    _replaced(
        "F1-plane", "sign, axes in the plane",
        "The same sign in the test of the axes that decide coplanar pairs.",
    ),
    _replaced(
        "F2", "coplanarity",
        "One branch tests axes in space, the other axes in the plane. The choice compares N_A . A1 with "
        "N_B . B1, so normals that are opposite or of different length, or equality by accident, choose "
        "wrongly.",
    ),
    _replaced(
        "F3", "wrong operand",
        "The axis edge 1 of A x edge 2 of B takes an edge of A where one of B is meant, in one component.",
    ),
    _replaced("F4", "axis truncation", "Cross products are kept in W bits; they need 2W+1."),
    _replaced("F5", "edge truncation", "Differences of coordinates are kept in W bits; they need W+1."),
    _replaced("F6", "product truncation", "Sums of products are kept in 2W bits; they need 3W+2."),
    _replaced(
        "F7", "given normals",
        "The wrapper CollisionDetector tests the normals that it is handed, not those of the vertices.",
        Kind.WRAPPER,
    ),
    _replaced(
        "F8", "degenerate input",
        "The branch is chosen rightly, and its axes are right, but for a zero normal: that makes every pair "
        "coplanar, and all axes N_A x edge in the plane zero.",
    ),
    _replaced(
        "F9", "testbench range",
        "Vectors with coordinates up to 33,293 wrap silently in 16 signed bits. Here every way in must "
        "refuse them.",
        Kind.ENVIRONMENT,
    ),
    _replaced(
        "F10-late", "testbench timing",
        "A driver puts the last vertex on the pins a clock after the rest of its pair.",
        Kind.ENVIRONMENT,
    ),
    _replaced(
        "F10-unsent", "nothing checked: nothing sent",
        "A test sends nothing, and so cannot fail.",
        Kind.ENVIRONMENT,
    ),
    _replaced(
        "F10-unseen", "nothing checked: nothing seen",
        "Pairs are sent and answered, and nothing checks the answers.",
        Kind.ENVIRONMENT,
    ),
    _further("touching-is-clear", "Contact from one side counts as separation."),
    _further("narrow-cross", "Areas, and so cross products, are kept in one bit less than they need."),
    _further("wrong-edge", "One projection takes edge 0 of A for edge 2."),
    _further("last-axis", "The claim is the highest-numbered separating axis."),
    _further("late-margin", "The box axes get their margin a clock late.", "w16_m16"),
    _further("moving-operands", "Operands move for pairs that their boxes decide."),
    _further("moving-margins", "Margins move for pairs that their boxes decide.", "w16_m16"),
    _further("overfull-queue", "More pairs are accepted than the result queue holds."),
    _further("withdrawn-result", "A result that waits is withdrawn now and then."),
    _further("short-queue", "The result queue has an eighth of its places."),
    _further("early-result", "Results are taken from the pipeline a clock too early."),
    _further("hang", "A pair with a certain tag is never accepted."),
    _further("lost-results", "Results with certain tags are lost."),
    _engine("engine-margin-left-out", "Boxes are skipped as if the margin were 0."),
    _engine("engine-zones-skipped", "Boxes are skipped by the margin, not by that of the widest zone."),
    _engine("engine-groups-unmoved", "Boxes of A's groups are compared where A was loaded, not where it is."),
    _engine("engine-lane-mask", "The last triangle of a mesh, and its last group, count as not there."),
    _engine("engine-group-not-begun", "The box of a group goes on from that of the group before."),
    _engine("engine-boxes-too-early", "A run begins before the last triangles' boxes are in memory."),
    _engine("engine-lost-near", "A near pair is lost where another one still waits."),
    _engine("engine-abort-complete", "A run that was aborted says that it is complete."),
    _engine("engine-overflow-wrapped", "Where A moved leaves the range its coordinates wrap."),
    _engine("engine-memory-read", "A memory is read although no run is under way."),
    _board("board-go-kept-on-run", "Go stays although another pose is asked about, which does not hold."),
    _board("board-go-kept-on-near", "Go stays although the next segment is near."),
    _board("board-go-kept-late", "Go stays although the time of the last segment is over."),
    _board("board-go-kept-on-refusal", "Go stays although something was refused."),
    _board("board-refusals-keep-alive", "The watchdog takes a host that is refused for one that is well."),
    _board("board-damage-accepted", "Frames are taken whatever their CRC says."),
    _board("board-repeat-executed", "A command that comes twice is executed twice."),
    _board("board-counts-not-compared", "A run begins although the host counts other triangles in mesh B."),
    _board("board-ring-overrun", "Near pairs are lost where the ring is full."),
    _board("board-range-unchecked", "Coordinates that do not fit are cut off."),
)  # fmt: skip


def fault_names() -> tuple[str, ...]:
    """Return the names of all faults, in the order of the catalogue."""
    return tuple(fault.name for fault in FAULTS)


def fault_of(name: str) -> Fault:
    """Return the fault of that name; raise InputError where there is none."""
    for fault in FAULTS:
        if fault.name == name:
            return fault
    raise InputError(f"fault {name}: unknown; one of: {', '.join(fault_names())}")


def faults_of(name: str) -> tuple[Fault, ...]:
    """Return the fault of that name, or all variants of it: F1 stands for F1-box, F1-space, F1-plane."""
    variants = tuple(fault for fault in FAULTS if fault.name.startswith(f"{name}-"))
    return variants or (fault_of(name),)
