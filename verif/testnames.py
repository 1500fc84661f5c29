"""The names of the UVM tests, for those who run them from outside the simulator."""

from triaxis.golden.errors import InputError

REPLAY = "ReplayTest"
REGRESSIONS = "RegressionsTest"

TESTS = (
    "SeedVectorsTest",
    "RandomTest",
    "DegenerateTest",
    "CoplanarTest",
    "PenetratingTest",
    "SliversTest",
    "TouchingTest",
    "NearMissTest",
    "ExtremesTest",
    "TinyTest",
    "FarTest",
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


def check_test_name(name: str) -> None:
    """Raise InputError unless there is such a test."""
    if name not in TESTS:
        raise InputError(f"test {name}: unknown; one of: {', '.join(TESTS)}")
