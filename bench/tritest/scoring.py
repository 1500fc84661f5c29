"""Scoring a program on a TriTest set: what it misses, takes for a collision, and does not answer."""

import contextlib
import shlex
import subprocess
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from triaxis.bench.tritest.libraries import CLEAR, COLLIDES, UNTOLD
from triaxis.bench.tritest.recheck import Case, Family, SetError, case_of, families_of, fault_of, lines_of
from triaxis.golden.errors import InputError
from triaxis.golden.exact import triangle_rank

# What float32 holds every whole number up to.
_FLOAT32 = 1 << 24
# Kinds of pairs, since most programs are made for the first alone.
KINDS = ("float32", "float64", "degenerate")
_COORDINATES = 18
# Of an answer, at most: what a program writes without an end is not kept.
_BYTES = 64


@dataclass(frozen=True)
class Asked:
    """A family's pairs as they are asked, whether each collides, and of which kind it is."""

    family: Family
    questions: Sequence[str]
    collide: Sequence[bool]
    kinds: Sequence[str]


def kind_of(case: Case) -> str:
    """Return whether one of the triangles is a segment or a point, or else which type holds both."""
    if triangle_rank(case.a) < 2 or triangle_rank(case.b) < 2:
        return "degenerate"
    largest = max(abs(x) for triangle in (case.a, case.b) for vertex in triangle for x in vertex)
    return "float32" if largest <= _FLOAT32 else "float64"


def read_set(folder: Path) -> list[Asked]:
    """Read a whole set; raise InputError where it cannot be read, or a pair of it is not proven."""
    asked: list[Asked] = []
    try:
        for family in families_of(folder):
            lines = [line for _, line in lines_of(folder, family)]
            cases = [case_of(line) for line in lines]
            for number, case in enumerate(cases, 1):
                if fault := fault_of(case):
                    raise SetError(f"{folder}: {family.name}:{number}: {fault}: a set of wrong answers")
            questions = [" ".join(line.split()[:_COORDINATES]) for line in lines]
            collide = [case.collides for case in cases]
            asked.append(Asked(family, questions, collide, [kind_of(case) for case in cases]))
    except SetError as error:
        raise InputError(str(error)) from error
    return asked


@dataclass
class Tally:
    """Pairs: how many there are, collide, were missed, were taken for collisions, were not answered."""

    pairs: int = 0
    colliding: int = 0
    missed: int = 0
    false_alarms: int = 0
    unanswered: int = 0

    @property
    def right(self) -> int:
        """Return how many were answered rightly."""
        return self.pairs - self.wrong - self.unanswered

    @property
    def wrong(self) -> int:
        """Return how many were answered wrongly."""
        return self.missed + self.false_alarms

    def add(self, collides: bool, said: str) -> None:
        """Count a pair."""
        self.pairs += 1
        self.colliding += collides
        self.missed += collides and said == CLEAR
        self.false_alarms += not collides and said == COLLIDES
        self.unanswered += said == UNTOLD


@dataclass
class Score:
    """What a program made of a set: tallies by kind and by family; the pairs it failed on, by family.

    A pair's number is its line's, from 1 on. ``ended``: families in which it ended early, and how.
    """

    kinds: dict[str, Tally] = field(default_factory=lambda: {kind: Tally() for kind in KINDS})
    families: dict[str, Tally] = field(default_factory=dict[str, Tally])
    missed: dict[str, list[int]] = field(default_factory=dict[str, list[int]])
    false_alarms: dict[str, list[int]] = field(default_factory=dict[str, list[int]])
    unanswered: dict[str, list[int]] = field(default_factory=dict[str, list[int]])
    ended: dict[str, str] = field(default_factory=dict[str, str])
    first_error: str = ""

    @property
    def all_right(self) -> bool:
        """Return whether every pair was answered, and rightly, by a program that ended well."""
        return not self.ended and all(tally.right == tally.pairs for tally in self.kinds.values())

    @property
    def wrong(self) -> tuple[int, int]:
        """Return how many pairs were answered wrongly: of proper triangles, and of others."""
        *proper, other = (self.kinds[kind].wrong for kind in KINDS)
        return sum(proper), other

    @property
    def place(self) -> tuple[bool, int, int, int]:
        """Return what a league is in the order of.

        Whether it answers nothing; of proper triangles the wrong answers, then the unanswered; what is not
        right of others.
        """
        *proper, other = (self.kinds[kind] for kind in KINDS)
        silent = all(one.unanswered == one.pairs for one in proper)
        return silent, self.wrong[0], sum(one.unanswered for one in proper), other.pairs - other.right

    def add(self, asked: Asked, said: Sequence[str]) -> None:
        """Count a family, of which there are as many answers as pairs."""
        name = asked.family.name
        tally = self.families.setdefault(name, Tally())
        failed = {UNTOLD: self.unanswered, CLEAR: self.missed, COLLIDES: self.false_alarms}
        rows = zip(asked.collide, asked.kinds, said, strict=True)
        for number, (collides, kind, answer) in enumerate(rows, 1):
            tally.add(collides, answer)
            self.kinds[kind].add(collides, answer)
            if answer != (COLLIDES if collides else CLEAR):
                failed[answer].setdefault(name, []).append(number)


def score(command: Sequence[str], asked: Sequence[Asked], progress: Callable[[int], None]) -> Score:
    """Ask a program about all families; ``progress`` is told of each.

    It is asked about all of them at once. Where answers are missing nobody knows to which pairs, so it is
    asked again, about each family by itself. Raises InputError where it cannot be started, or answers what is
    no answer.
    """
    found, total = Score(), sum(one.family.pairs for one in asked)
    said, how, found.first_error = _run(command, asked)
    whole = len(said) == total
    for one in asked:
        name, pairs = one.family.name, one.family.pairs
        if whole:
            own, said = said[:pairs], said[pairs:]
            # It answered all, and ended badly all the same.
            ending = how if one is asked[-1] else None
        else:
            own, ending, told = _run(command, [one])
            found.first_error = found.first_error or told
        if missing := pairs - len(own):
            # One that failed is believed up to there, one that left a pair out is not.
            own = [*own, *[UNTOLD] * missing] if ending else [UNTOLD] * pairs
            ending = ending or f"{pairs - missing} answers to {pairs} pairs"
        if ending is not None:
            found.ended[name] = ending
        found.add(one, own)
        progress(1)
    return found


def _run(command: Sequence[str], asked: Sequence[Asked]) -> tuple[list[str], str | None, str]:
    """Return what a program answers, how it ended if not well, and the first line of its errors."""
    questions = "".join(f"{question}\n" for one in asked for question in one.questions)
    try:
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
    except OSError as error:
        raise InputError(f"{shlex.join(command)}: {error.strerror}") from error
    assert process.stdin and process.stdout and process.stderr
    most = _BYTES * (1 + questions.count("\n"))
    with process, ThreadPoolExecutor(3) as pool:
        try:
            pool.submit(_written, process.stdin, questions.encode())
            reading = pool.submit(_read, process.stdout, most, process.kill)
            errors = pool.submit(_read, process.stderr, most, bool).result().decode(errors="replace")
            output, code = reading.result(), process.wait()
        except BaseException:
            # Threads wait for it.
            process.kill()
            raise
    if len(output) > most:
        raise InputError(f"{shlex.join(command)}: more than {most} bytes of answers: a line a pair is wanted")
    said = output.decode(errors="replace").split()
    wrong = next((word for word in said if word not in (CLEAR, COLLIDES, UNTOLD)), None)
    if wrong is not None or len(said) > questions.count("\n"):
        what = (
            f"{wrong:.40}: no answer" if wrong else f"{len(said)} answers to {questions.count(chr(10))} pairs"
        )
        raise InputError(f"{shlex.join(command)}: {what}: a line with 0, 1 or ? for each pair is wanted")
    told = errors.strip().splitlines() or [""]
    return said, f"exit code {code}: {told[-1]}" if code else None, told[0]


def _written(stream: IO[bytes], text: bytes) -> None:
    # Whoever ends early need not have read all.
    with contextlib.suppress(OSError):
        stream.write(text)
    with contextlib.suppress(OSError):
        stream.close()


def _read(stream: IO[bytes], most: int, beyond: Callable[[], object]) -> bytes:
    """Return what a program writes, of more than so many bytes these alone and one; then do ``beyond``."""
    found = bytearray()
    while part := stream.read(1 << 16):
        found += part[: most + 1 - len(found)]
        if len(found) > most:
            beyond()
    return bytes(found)


def rows_of(score_: Score) -> Iterator[tuple[str, Tally]]:
    """Yield what tables show of a score: its kinds, then the families in which something was not right."""
    yield from score_.kinds.items()
    yield from ((name, tally) for name, tally in score_.families.items() if tally.right < tally.pairs)
