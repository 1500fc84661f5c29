"""What decides a mutant's fate: a result is of today's where none of it has changed.

Of a run as a whole that is all of the RTL, what plays and judges the mutants of all blocks, and the evidence
of equivalence. What became of one mutant depends on less: on the RTL that the targets of its block elaborate,
which is its own and that below it, and on the tests of its block. So a new test of the board leaves what is
known of the core.
"""

from pathlib import Path

from triaxis.sim.build import content_hash, rtl_files
from triaxis.sim.toolchain import verilator
from triaxis.sim.validity import Sources
from triaxis.verif.testbench.settings import BOARD_TESTS, CORE_TESTS, ENTRY, MESH_TESTS, TEST_DATA

# Of each block its tests, but for those of real solids, which try no mutant and would bring host/ in.
_TESTS = {"core": CORE_TESTS[:1], "mesh": MESH_TESTS[:1], "board": BOARD_TESTS}
# What generates, plays, judges and excuses mutants: most of these modules are named by none of the others.
_MODULES = [path.stem for path in sorted(Path(__file__).parent.glob("*.py")) if path.stem != "__init__"]
KILLERS = Sources(
    (
        *(f"triaxis.verif.mutation.{name}" for name in _MODULES),
        ENTRY,
        *(name for names in _TESTS.values() for name in names),
    ),
    (
        "verif/mutation/*.toml",
        "verif/*/sva/*",
        *TEST_DATA,
        "verif/formal/rtl/*.sv",
        "requirements.lock",
    ),
)


def killers_hash() -> str:
    """Return the hash of these files and of Verilator's version."""
    return content_hash((), KILLERS.hash(), str(verilator()))


# Of each block what its tests read, and the folders of dut/ that its targets elaborate.
BLOCKS = tuple(_TESTS)
# What plays a block plays no other one; and nobody looks at waves of a mutant.
_PLAYERS = {
    "core": ("sim/core_player.cpp", "sim/lanes_player.cpp", "sim/detector_player.cpp"),
    "mesh": ("sim/mesh_player.cpp", "sim/mesh_public.vlt"),
    "board": ("sim/board_player.cpp",),
}
OUTCOMES = {
    block: Sources(
        ("triaxis.verif.mutation.judging", ENTRY, *tests),
        (
            f"verif/{block}/sva/*",
            *(data for data in TEST_DATA if data.startswith(f"verif/{block}/")),
            "requirements.lock",
        ),
        (
            *(file for other in BLOCKS if other != block for file in _PLAYERS[other]),
            "verif/testbench/waves.py",
        ),
    )
    for block, tests in _TESTS.items()
}


def outcomes_hash(block: str, dut: Path) -> str:
    """Return the hash of what decides the fates of a block's mutants in a folder of RTL."""
    below = BLOCKS[: BLOCKS.index(block) + 1]
    rtl = [path for path in rtl_files(dut) if path.relative_to(dut).parts[0] in below]
    return content_hash(rtl, OUTCOMES[block].hash(), str(verilator()))


def states(dut: Path) -> dict[str, str]:
    """Return that of every block."""
    return {block: outcomes_hash(block, dut) for block in BLOCKS}
