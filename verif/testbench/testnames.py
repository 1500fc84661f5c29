"""The names of the UVM tests, for those who run them from outside the simulator."""

from triaxis.golden.errors import InputError
from triaxis.sim.mesh_configuration import is_mesh_configuration

REPLAY = "ReplayTest"
REGRESSIONS = "RegressionsTest"

# One kind of pairs each, at full speed.
FAMILY_TESTS = (
    "RandomTest",
    "DegenerateTest",
    "CoplanarTest",
    "PenetratingTest",
    "SliversTest",
    "TouchingTest",
    "ExtremesTest",
    "TinyTest",
    "FarTest",
)

TESTS = (
    "SeedVectorsTest",
    *FAMILY_TESTS,
    "NearMissTest",
    "MixedTest",
    "VolumeTest",
    "OrdersTest",
    "MetamorphicTest",
    "MeshTest",
    "StallsTest",
    "ResetsTest",
    REGRESSIONS,
    REPLAY,
)


# Tests of the mesh engine; the others are tests of the core.
MESH_TESTS = (
    "MeshRandomTest",
    "MeshVolumeTest",
    "MeshGapsTest",
    "MeshLimitsTest",
    "MeshAbortTest",
    "MeshStallsTest",
    "MeshResetsTest",
    "MeshRealTest",
)


def check_test_name(name: str) -> None:
    """Raise InputError unless there is such a test."""
    if name not in (*TESTS, *MESH_TESTS):
        raise InputError(f"test {name}: unknown; one of: {', '.join((*TESTS, *MESH_TESTS))}")


def check_test_fits(name: str, config: str) -> None:
    """Raise InputError unless the test is one of what the configuration's name says is under test."""
    if (name in MESH_TESTS) != is_mesh_configuration(config):
        wanted = "mesh_w16_m16_d64_g8_l8" if name in MESH_TESTS else "w16_m0"
        raise InputError(f"test {name}: needs another --config than {config}, such as {wanted}")
