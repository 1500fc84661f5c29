"""Which tests of the mesh engine a sign-off runs, in which configurations, and on how many pairs."""

from triaxis.verif.signoff.folder import FOLDER
from triaxis.verif.testbench.settings import BURST, PIN, RunSettings
from triaxis.verif.testbench.simulation import run_settings

# A word of lanes to a group and one word of groups; several of each, few clocks counted, no margins; the
# widest; one lane, in the width of the board's finer build; the engine as it stands on the board.
SQUARE = "mesh_w16_m16_d64_g8_l8"
WORDS = "mesh_w12_m0_d32_g4_l2_c8"
WIDEST = "mesh_w32_m32_d16_g4_l2"
ONE_LANE = "mesh_w24_m1_d16_g4_l1"
BOARD = "mesh_w16_m16_d4096_g8_l8"

# Whole runs on the bare engine: pairs to be accounted for at least, and of so many runs one has pairs judged
# by the golden model.
_BARE = {
    SQUARE: {
        "MeshRandomTest": (100_000, 8),
        "MeshVolumeTest": (200_000, 16),
        "MeshGapsTest": (1_000, 4),
        "MeshLimitsTest": (1, 1),
        "MeshAbortTest": (10_000, 16),
    },
    WORDS: {
        "MeshRandomTest": (40_000, 8),
        "MeshGapsTest": (500, 4),
        "MeshLimitsTest": (1, 1),
        "MeshAbortTest": (5_000, 16),
    },
    WIDEST: {
        "MeshRandomTest": (20_000, 8),
        "MeshGapsTest": (500, 4),
        "MeshLimitsTest": (1, 1),
        "MeshAbortTest": (3_000, 16),
    },
    ONE_LANE: {
        "MeshRandomTest": (20_000, 8),
        "MeshGapsTest": (500, 4),
        "MeshLimitsTest": (1, 1),
        "MeshAbortTest": (3_000, 16),
    },
    BOARD: {
        "MeshRandomTest": (5_000_000, 8),
        "MeshGapsTest": (500, 4),
        "MeshLimitsTest": (1, 4),
        "MeshAbortTest": (5_000, 16),
        "MeshRealTest": (1, 1),
    },
}
# The protocol, pin by pin, with all assertions.
_PINS = {
    SQUARE: {
        "MeshRandomTest": 3_000,
        "MeshStallsTest": 1_000,
        "MeshAbortTest": 1_000,
        "MeshResetsTest": 1_000,
    },
    WORDS: {
        "MeshRandomTest": 1_000,
        "MeshStallsTest": 1_000,
        "MeshAbortTest": 1_000,
        "MeshResetsTest": 1_000,
    },
}


def mesh_plan(seed: int) -> list[RunSettings]:
    """Return the runs, each in a folder of the sign-off's own."""
    pins = [(PIN, test, c, n, 1) for c, tests in _PINS.items() for test, n in tests.items()]
    bare = [(BURST, test, c, n, j) for c, tests in _BARE.items() for test, (n, j) in tests.items()]
    return [
        run_settings(
            test,
            config,
            seed,
            pairs,
            folder=FOLDER / "runs" / f"{test}-{config}-{agent}-{seed}",
            agent=agent,
            judged_one_in=judged,
        )
        for agent, test, config, pairs, judged in pins + bare
    ]
