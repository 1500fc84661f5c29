"""The names of the UVM tests, for those who run them from outside the simulator."""

from triaxis.golden.errors import InputError

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


def check_test_name(name: str) -> None:
    """Raise InputError unless there is such a test."""
    if name not in TESTS:
        raise InputError(f"test {name}: unknown; one of: {', '.join(TESTS)}")
