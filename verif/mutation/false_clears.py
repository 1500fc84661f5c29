"""What certificates make of a wrong data path: mutants of it, in the core and in the certified core.

A mutant that makes the core say "clear" of a pair that is near is the danger. In the certified core no such
"clear" may come through: each is near, with a fault. Modules that the certifier has as well, the multiplier
and the rows of registers, are changed in both places at once, and told apart.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.golden.processes import threads
from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.core_engine import CoreError, CorePlayer, streamed
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import BUILD, DUT, certified_sources, rtl_sources
from triaxis.sim.result import FAULT, NEAR
from triaxis.sim.validity import Provenance, Sources, standing
from triaxis.verif.core.stimulus.families import mixed
from triaxis.verif.core.stimulus.stimulus import Stimulus
from triaxis.verif.mutation.builds import schema_library, temporary
from triaxis.verif.mutation.catalogue import Catalogue, catalogue, runtime_numbers
from triaxis.verif.mutation.mutant import Mutant
from triaxis.verif.mutation.schema import write_schema
from triaxis.verif.mutation.targets import Target

RESULT = BUILD / "certificates" / "certificates.json"
SOURCES = Sources(("triaxis.verif.mutation.false_clears",))
PLAIN, CERTIFIED = parse_configuration("w8_m8"), parse_configuration("w8_m8_certified")
PAIRS = 5000
Words = npt.NDArray[np.uint16]
_JOBS = 2
# The core's files outside its data path, and those of its modules that the certifier has as well.
_AROUND = ("CollisionDetector.sv", "triaxis_core.sv", "triaxis_fifo.sv", "triaxis_pkg.sv")
_SHARED = ("triaxis_mul.sv", "triaxis_narrow_mul.sv", "triaxis_sum.sv", "triaxis_delay.sv")


@dataclass(frozen=True)
class DataPath(Target):
    """A core, plain or certified, with the mutants of the data path."""

    def mutates(self, file: str) -> bool:
        """Return whether it is a file of the data path."""
        return file in data_path()


def data_path() -> frozenset[str]:
    """Return the files of the core's data path, from dut/ on."""
    files = set(rtl_sources()) - set(certified_sources())
    return frozenset(path.relative_to(DUT).as_posix() for path in files if path.name not in _AROUND)


def mutants_of_data_path(every: Catalogue | None = None) -> list[Mutant]:
    """Return the mutants of the data path that are selected at run time."""
    found = (every or catalogue()).mutants
    numbers, files = runtime_numbers(found), data_path()
    return [one for one in found if one.file in files and one.id in numbers]


@dataclass(frozen=True)
class Compared:
    """A mutant in both cores; ``shared``: its module is in the certifier too.

    ``dangerous``: near pairs of which the plain core says clear; ``through``: those of which the certified
    core does; ``turned``: the dangerous ones of which it says near, with a fault. A core that hangs, or
    answers out of order, answers nothing (None).
    """

    mutant: str
    shared: bool
    dangerous: int
    through: int
    turned: int | None

    @property
    def held(self) -> bool:
        """Return whether no wrong "clear" comes through, and each was told."""
        return not self.through and self.turned in (None, self.dangerous)


@dataclass(frozen=True)
class FalseClears:
    """All mutants of the data path, by what they make of near pairs."""

    compared: tuple[Compared, ...]
    pairs: int
    seed: int
    seconds: float
    problems: tuple[str, ...]
    valid_for: Provenance

    def dangerous(self, shared: bool) -> list[Compared]:
        """Return those that make the plain core say clear wrongly, of modules that are shared or are not."""
        return [one for one in self.compared if one.shared is shared and one.dangerous]

    def missed(self, shared: bool) -> list[Compared]:
        """Return those of which a wrong "clear" came through certificates, or was not told."""
        return [one for one in self.compared if one.shared is shared and not one.held]

    @property
    def passed(self) -> bool:
        """Return whether every wrong "clear" of what the core alone has was turned into a fault."""
        return not self.problems and not self.missed(False)

    @property
    def summary(self) -> str:
        """Return the result in one line."""
        own, both = (self.dangerous(shared) for shared in (False, True))
        return (
            f"{len(self.compared)} mutants of the data path, {self.pairs} pairs each: {len(own)} of the core "
            f"alone make it say clear wrongly, of {len(self.missed(False))} that comes through certificates; "
            f"of modules that the certifier has too {len(both)}, of {len(self.missed(True))}"
        )


def _asked(library: Path, configuration: Configuration, number: int, made: Stimulus) -> Words | None:
    try:
        return streamed(CorePlayer(library, number), configuration, made.pairs, made.margins, number)[0]
    except CoreError:
        return None


def _libraries(chosen: Catalogue, numbers: dict[str, int], dut: Path) -> tuple[Path, Path]:
    made: list[Path] = []
    for configuration in (PLAIN, CERTIFIED):
        target = DataPath(configuration)
        with temporary() as folder:
            extra = write_schema(chosen, numbers, dut, folder / "dut", target)
            made.append(schema_library(target, folder / "dut", extra, _JOBS, assertions=False))
    return made[0], made[1]


def compare(
    progress: Callable[[int], None], seed: int = 1, pairs: int = PAIRS, dut: Path = DUT,
    of: Sequence[str] = ("*",),
) -> FalseClears:  # fmt: skip
    """Ask both cores with every mutant of the data path that is selected at run time.

    ``of``: patterns, one of which a name must fit. Raises InputError where a core without a mutant is wrong.
    """
    start, before = time.monotonic(), standing(SOURCES, dut)
    every = catalogue(dut)
    numbers = runtime_numbers(every.mutants)
    wanted = [one for one in mutants_of_data_path(every) if any(fnmatch(one.id, pattern) for pattern in of)]
    libraries = _libraries(every, numbers, dut)
    made = mixed(np.random.default_rng(seed), pairs, PLAIN.width, PLAIN.max_margin)
    near = bulk_facts(made.pairs, made.margins).separating == 0

    def ask(number: int, name: str = "", shared: bool = False) -> Compared:
        plain, certified = (
            _asked(library, configuration, number, made)
            for library, configuration in zip(libraries, (PLAIN, CERTIFIED), strict=True)
        )
        wrong = near & (plain & NEAR == 0) if plain is not None else np.zeros(pairs, np.bool_)
        if certified is None:
            return Compared(name, shared, int(wrong.sum()), 0, None)
        told = certified & (NEAR | FAULT) == NEAR | FAULT
        through = near & (certified & NEAR == 0)
        return Compared(name, shared, int(wrong.sum()), int(through.sum()), int((wrong & told).sum()))

    if ask(0) != Compared("", False, 0, 0, 0):
        raise InputError(f"certificates: without a mutant: {ask(0)}: the RTL is wrong")

    def one(mutant: Mutant) -> Compared:
        found = ask(numbers[mutant.id], mutant.id, mutant.file.rpartition("/")[2] in _SHARED)
        progress(1)
        return found

    with threads(_JOBS) as pool:
        compared = tuple(pool.map(one, wanted))
    problems = [] if any(one.dangerous for one in compared) else ["no mutant is dangerous: nothing shown"]
    if not before.stands:
        problems.append("the RTL, or what plays its mutants, changed during the run: run again")
    return FalseClears(compared, pairs, seed, time.monotonic() - start, tuple(problems), before.valid_for)


def write_result(result: FalseClears) -> Path:
    """Write the result as JSON, whole or not at all."""
    rows = [one for shared in (False, True) for one in result.dangerous(shared)]
    through = [one for shared in (False, True) for one in result.missed(shared)]
    content: dict[str, Any] = {
        "passed": result.passed,
        "problems": [*result.problems, *map(str, result.missed(False))],
        "summary": result.summary,
        "command": f"triaxis prove certificates --seed {result.seed} --pairs {result.pairs}",
        "seconds": round(result.seconds, 1),
        "seed": result.seed,
        "pairs": result.pairs,
        "mutants": len(result.compared),
        "dangerous": len(result.dangerous(False)),
        "through": len(result.missed(False)),
        "dangerous_in_shared_modules": len(result.dangerous(True)),
        "through_in_shared_modules": len(result.missed(True)),
        "examples": [asdict(one) for one in [*through, *rows][:50]],
        **asdict(result.valid_for),
    }
    return write_evidence(RESULT, content, SOURCES)
