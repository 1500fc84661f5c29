"""Which tests a sign-off runs, in which configurations, and on how many pairs."""

from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.verif.core.detector_check import SEED_VECTORS
from triaxis.verif.signoff.folder import FOLDER
from triaxis.verif.testbench.settings import BURST, PIN, RunSettings
from triaxis.verif.testbench.simulation import run_settings
from triaxis.verif.testbench.testnames import FAMILY_TESTS, REGRESSIONS

# Pairs of the volume runs in all.
VOLUME = 100_000_000

# Shares of the volume, in percent. Wide cores simulate slowly, and narrow ones have the same structure,
# so most goes to the default build and to the two with margins that simulate fast; each other build
# gets what closes its coverage several times over.
_SHARES = {
    "w16_m0": 62.0,
    "w8_m8": 20.0,
    "w16_m16": 10.0,
    "w13_m4_t1": 2.0,
    "w16_m0_no_edge_box": 2.0,
    "w16_m0_ungated": 2.0,
    "w24_m24": 1.5,
    "w32_m32": 0.5,
}
# Pairs of one volume run at most: what fails is replayed by running it again from its start.
_LONGEST_RUN = 8_000_000
# The share that the golden model judges in volume runs, beside pairs of new kinds.
_JUDGED_ONE_IN = 1 << 16

# Directed runs in every configuration, with bursts, all of it judged by the golden model.
_JUDGED = 3_000
# Further ones where a build differs from the others in what they are about: the seed vectors and meshes
# in the builds that users start with, stalls and resets at each depth of the pipeline, the rarest bins
# where there is little volume.
_DIRECTED = {
    # Each family by itself, so that a failure says what it is about; volume sends them all to every build.
    **dict.fromkeys(FAMILY_TESTS, (20000, ("w16_m0", "w16_m16"))),
    "SeedVectorsTest": (SEED_VECTORS, ("w16_m0", "w16_m16", "w24_m24", "w32_m32")),
    "MeshTest": (20_000, ("w16_m0", "w16_m16", "w24_m24", "w32_m32")),
    "MetamorphicTest": (200_000, ("w16_m0", "w16_m16", "w8_m8", "w16_m0_no_edge_box", "w24_m24")),
    "NearMissTest": (400_000, ("w13_m4_t1", "w24_m24", "w32_m32")),
    "StallsTest": (10_000, ("w16_m0", "w16_m16", "w13_m4_t1", "w32_m32")),
    "ResetsTest": (10_000, ("w16_m0", "w16_m16", "w13_m4_t1", "w32_m32")),
}
# The protocol again, pin by pin, independent of the bus-functional model; everything judged.
_PIN_CONFIGS = ("w16_m0", "w13_m4_t1")
_PIN = (("MixedTest", 1_000), ("StallsTest", 1_000), ("ResetsTest", 1_000), ("OrdersTest", 720))


def _settings(
    test: str,
    configuration: Configuration,
    seed: int,
    pairs: int,
    agent: str = BURST,
    judged_one_in: int = 1,
) -> RunSettings:
    """Return a run in a folder of the sign-off's own, so that no other run disturbs it."""
    folder = FOLDER / "runs" / f"{test}-{configuration.name}-{agent}-{seed}"
    return run_settings(
        test, configuration, seed, pairs, folder=folder, agent=agent, judged_one_in=judged_one_in
    )


def _directed(name: str, seed: int) -> list[RunSettings]:
    configuration = parse_configuration(name)
    # What was found before comes first.
    runs = [_settings(REGRESSIONS, configuration, seed, 1)]
    runs.append(_settings("MixedTest", configuration, seed, _JUDGED))
    for test, (pairs, configs) in _DIRECTED.items():
        if name in configs:
            runs.append(_settings(test, configuration, seed, pairs, judged_one_in=1000))
    return runs


def _volume(configuration: Configuration, seed: int, pairs: int) -> list[RunSettings]:
    """Return volume runs of that many pairs in all, each with a seed of its own."""
    count = -(-pairs // _LONGEST_RUN)
    each = -(-pairs // count)
    return [
        _settings("VolumeTest", configuration, 1000 * seed + number, each, judged_one_in=_JUDGED_ONE_IN)
        for number in range(count)
    ]


def plan(seed: int, volume: int = VOLUME) -> list[RunSettings]:
    """Return every run of the sign-off, what fails soonest first; ``volume``: pairs of the volume runs."""
    runs = [run for name in _SHARES for run in _directed(name, seed)]
    for name in _PIN_CONFIGS:
        runs += [_settings(t, parse_configuration(name), seed, n, PIN) for t, n in _PIN]
    for name, share in _SHARES.items():
        runs += _volume(parse_configuration(name), seed, int(volume * share / 100))
    return runs
