"""Which tests a sign-off runs, in which configurations, and on how many pairs."""

from triaxis.verif.configuration import Configuration, parse_configuration
from triaxis.verif.settings import BURST, PIN, RunSettings
from triaxis.verif.signoff.detector_check import SEED_VECTORS
from triaxis.verif.signoff.result import FOLDER
from triaxis.verif.simulation import run_settings
from triaxis.verif.testnames import REGRESSIONS

# Pairs of the volume runs in all.
VOLUME = 100_000_000

# Shares of the volume, in percent. Wide cores simulate slowly, and narrow ones have the same structure,
# so most goes to the default build and to the two with margins that simulate fast; each other build
# gets what closes its coverage several times over.
_SHARES = {
    "w16_m0": 50.0,
    "w8_m8": 24.0,
    "w16_m16": 15.5,
    "w13_m4_t1": 4.0,
    "w16_m0_no_edge_box": 2.5,
    "w16_m0_ungated": 2.5,
    "w24_m24": 1.5,
    "w32_m32": 0.6,
}
# Pairs of one volume run at most: what fails is replayed by running it again from its start.
_LONGEST_RUN = 8_000_000
# The share that the golden model judges in volume runs, beside the first pairs of each kind.
_JUDGED_ONE_IN = 1 << 16

# Directed runs in every configuration, with bursts: test, pairs, and whether the golden model judges all.
_DIRECTED = (
    ("MixedTest", 3_000, True),
    ("MetamorphicTest", 200_000, False),
    # The rarest bins: in wide cores, which get little volume, they come from here.
    ("NearMissTest", 400_000, False),
    ("MeshTest", 20_000, False),
    ("StallsTest", 10_000, False),
    ("ResetsTest", 10_000, False),
)
# The protocol again, pin by pin, independent of the bus-functional model; everything judged.
_PIN_CONFIGS = ("w16_m0", "w8_m8", "w13_m4_t1")
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


def _directed(configuration: Configuration, seed: int) -> list[RunSettings]:
    # What was found before comes first.
    runs = [_settings(REGRESSIONS, configuration, seed, 1)]
    if configuration.width >= 16:
        runs.append(_settings("SeedVectorsTest", configuration, seed, SEED_VECTORS))
    for test, pairs, judged in _DIRECTED:
        runs.append(_settings(test, configuration, seed, pairs, judged_one_in=1 if judged else 1000))
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
    configurations = {name: parse_configuration(name) for name in _SHARES}
    runs = [run for configuration in configurations.values() for run in _directed(configuration, seed)]
    for name in _PIN_CONFIGS:
        runs += [_settings(t, configurations[name], seed, n, PIN) for t, n in _PIN]
    for name, share in _SHARES.items():
        runs += _volume(configurations[name], seed, int(volume * share / 100))
    return runs
