"""Which test notices which mutants, where each mutant meets every test; the fewest tests that notice all.

A run over all mutants ends each at the first test that notices it, so it tells of no test what would be lost
without it. Here a sample of the mutants that are selected at run time meets all short tests of a model, one
by one. What no test of these notices is left to other models, to volume and to proofs.
"""

import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from itertools import combinations
from pathlib import Path
from tempfile import mkdtemp
from zlib import crc32

from triaxis.golden.errors import InputError
from triaxis.golden.processes import threads
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import DUT
from triaxis.sim.validity import Provenance, standing
from triaxis.verif.mutation.builds import FOLDER, schema_library, temporary
from triaxis.verif.mutation.catalogue import Catalogue, catalogue, runtime_numbers
from triaxis.verif.mutation.equivalence import read_equivalents
from triaxis.verif.mutation.killers import KILLERS
from triaxis.verif.mutation.mutant import Mutant
from triaxis.verif.mutation.schema import write_schema
from triaxis.verif.mutation.targets import BOARD, ENGINE, MAIN, AnyTarget, elaborated
from triaxis.verif.testbench.simulation import run_trials
from triaxis.verif.testbench.trials import Model, Trials, Verdict

RESULT = FOLDER / "power.json"
MODELS: Mapping[str, AnyTarget] = {"core": MAIN, "mesh": ENGINE, "board": BOARD}
ONE_IN = 10
_ORIGINAL = "no mutant"

Progress = Callable[[int], None]


@dataclass(frozen=True)
class Power:
    """What the tests of a model notice: of each test, in the order in which runs try them, the mutants.

    ``tried``: all that met them; ``found_by``: of each test what it noticed.
    """

    model: str
    tried: tuple[str, ...]
    found_by: Mapping[str, frozenset[str]]

    @property
    def noticed(self) -> frozenset[str]:
        """Return what any test noticed."""
        return frozenset[str]().union(*self.found_by.values())

    def alone(self, test: str) -> frozenset[str]:
        """Return what no test but this one noticed."""
        return self.found_by[test].difference(*(of for other, of in self.found_by.items() if other != test))

    @property
    def fewest(self) -> tuple[str, ...]:
        """Return the fewest tests that notice all that any does; of several such sets the earliest tests."""
        needed = [test for test in self.found_by if self.alone(test)]
        others = [test for test in self.found_by if test not in needed]
        left = self.noticed.difference(*(self.found_by[test] for test in needed))
        for count in range(len(others) + 1):
            for chosen in combinations(others, count):
                if left <= frozenset[str]().union(*(self.found_by[test] for test in chosen)):
                    return tuple(test for test in self.found_by if test in (*needed, *chosen))
        raise AssertionError("all tests notice what all tests notice")


@dataclass(frozen=True)
class PowerResult:
    """The power of the tests of some models over one mutant in so many, as a seed draws them."""

    powers: tuple[Power, ...]
    seed: int
    one_in: int
    seconds: float
    problems: tuple[str, ...]
    valid_for: Provenance

    @property
    def passed(self) -> bool:
        """Return whether every test came to a verdict on every mutant, of one state of the sources."""
        return not self.problems

    @property
    def summary(self) -> str:
        """Return the result in one line."""
        return "; ".join(
            f"{one.model}: {len(one.noticed)} of {len(one.tried)} mutants noticed by {len(one.found_by)} "
            f"tests, all of these by {len(one.fewest)}"
            for one in self.powers
        )


def measure_power(
    models: Iterable[AnyTarget], seed: int = 1, one_in: int = ONE_IN, files: str | None = None,
    jobs: int = 2, dut: Path = DUT, progress: Progress = lambda _: None,
) -> PowerResult:  # fmt: skip
    """Let every short test of some models meet the mutants that the seed draws, one in so many.

    ``files``: of those whose file matches, or of all.
    ``progress`` is told of each test of a model that is done. Raises InputError where a test fails without a
    mutant, or where no mutant is drawn.
    """
    start, before = time.monotonic(), standing(KILLERS, dut)
    every = catalogue(dut).restricted(files, None) if files else catalogue(dut)
    found: list[Power] = []
    problems: list[str] = []
    for model in models:
        power, silent = _of_model(model, every, seed, one_in, jobs, dut, progress)
        found.append(power)
        problems += silent
    if not before.stands:
        problems.append("the RTL, or what plays its mutants, changed during the run: run again")
    return PowerResult(
        tuple(found), seed, one_in, time.monotonic() - start, tuple(problems), before.valid_for
    )


def sampled(model: AnyTarget, seed: int, one_in: int, every: Catalogue, dut: Path = DUT) -> list[Mutant]:
    """Return the mutants that a seed draws of those that a model holds at run time, no equivalent ones."""
    equivalent = {name for entry in read_equivalents() for name in entry.mutants}
    places = elaborated(model, dut)
    numbers = runtime_numbers(every.mutants)
    return [
        one
        for one in every.mutants
        if one.id in numbers
        and one.id not in equivalent
        and model.mutates(one.file)
        and (one.needs < 0 or (one.file, one.needs) in places)
        and crc32(f"{seed}/{one.id}".encode()) % one_in == 0
    ]


def _of_model(
    model: AnyTarget, every: Catalogue, seed: int, one_in: int, jobs: int, dut: Path, progress: Progress
) -> tuple[Power, list[str]]:
    mutants = sampled(model, seed, one_in, every, dut)
    if not mutants:
        raise InputError(f"{model.name}: no mutant is drawn: draw one in fewer")
    # Of all: the library of a run over them, which may be there.
    numbers = runtime_numbers(every.mutants)
    with temporary() as folder:
        extra = write_schema(every, numbers, dut, folder / "dut", model)
        library = str(schema_library(model, folder / "dut", extra, jobs))
    selected = {_ORIGINAL: 0, **{one.id: numbers[one.id] for one in mutants}}
    models = tuple(Model(name, library, number) for name, number in selected.items())
    tests = model.tests(seed)
    with temporary() as folder:

        def meet(number: int) -> list[Verdict]:
            place = Path(mkdtemp(dir=folder))
            trials = Trials((replace(tests[number], folder=str(place)),), models, place)
            # What came to no verdict is told of each mutant.
            with suppress(InputError):
                run_trials(trials)
            progress(1)
            return trials.verdicts()

        with threads(jobs) as pool:
            verdicts = dict(
                zip((test.test for test in tests), pool.map(meet, range(len(tests))), strict=True)
            )
    return _judged(model.name, tuple(one.id for one in mutants), verdicts)


def _judged(
    model: str, tried: tuple[str, ...], verdicts: Mapping[str, list[Verdict]]
) -> tuple[Power, list[str]]:
    """Return what the tests noticed, and which of them came to no verdict on what."""
    problems: list[str] = []
    for test, found in verdicts.items():
        of = {one.name: one for one in found}
        if (original := of.get(_ORIGINAL)) is None or original.trouble or original.symptom:
            said = (original.symptom or original.trouble) if original else "no verdict"
            raise InputError(f"{model}, no mutant selected: {test}: {said}")
        problems += [
            f"{name}: no verdict of {test}: {of[name].trouble if name in of else 'its process ended'}"
            for name in tried
            if name not in of or of[name].trouble
        ]
    noticed = {test: frozenset(one.name for one in found if one.symptom) for test, found in verdicts.items()}
    return Power(model, tried, noticed), problems


def write_result(result: PowerResult, command: str, path: Path = RESULT) -> Path:
    """Write the result as JSON, whole or not at all."""
    content = {
        "passed": result.passed,
        "problems": result.problems,
        "summary": result.summary,
        "command": command,
        "seconds": round(result.seconds, 1),
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "seed": result.seed,
        "one_in": result.one_in,
        "power": [
            {
                "model": one.model,
                "tests": {
                    test: {"alone": len(one.alone(test)), "in_fewest": test in one.fewest}
                    for test in one.found_by
                },
                "mutants": {
                    name: [test for test, found in one.found_by.items() if name in found]
                    for name in one.tried
                },
            }
            for one in result.powers
        ],
        **asdict(result.valid_for),
    }
    return write_evidence(path, content, KILLERS)
