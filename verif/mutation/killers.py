"""What decides a mutant's fate beside the RTL: a result is of today's where none of it has changed."""

from pathlib import Path

from triaxis.sim.build import content_hash
from triaxis.sim.toolchain import verilator
from triaxis.sim.validity import Sources
from triaxis.verif.testbench.settings import BOARD_TESTS, CORE_TESTS, ENTRY, MESH_TESTS, TEST_DATA

# What generates, plays, judges and excuses mutants: most of these modules are named by none of the
# others. And the tests, but for those of real solids, which try no mutant and would bring host/ in.
_MODULES = [path.stem for path in sorted(Path(__file__).parent.glob("*.py")) if path.stem != "__init__"]
KILLERS = Sources(
    (
        *(f"triaxis.verif.mutation.{name}" for name in _MODULES),
        ENTRY,
        CORE_TESTS[0],
        MESH_TESTS[0],
        *BOARD_TESTS,
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
