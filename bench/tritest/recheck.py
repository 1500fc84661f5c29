"""Prove a TriTest set again: with Python's own library alone, by a few whole numbers a pair.

    python3 recheck.py SET

A set is a folder: ``set.json`` names its families, each a file NAME.txt.gz of lines that describe a pair of
triangles A and B by 29 whole numbers (lines that begin with # say what the family is):

    18  x y z of A1 A2 A3 B1 B2 B3, at most 2^53 in size, so that float64 holds them
     2  p q: the Chebyshev distance of A and B is p / q, in lowest terms; they touch or overlap where p = 0
     6  weights, none below 0, of A1 A2 A3 and of B1 B2 B3: the point of each that has these as its
        barycentric coordinates, over their sum
     3  an axis c; 0 0 0 where p = 0

The two points show that the distance is at most p / q: no coordinate of their difference is larger. The
axis shows that it is at least as much: along c all of A lies beyond all of B by p / q times |c|1, and no two
points are closer than what they differ by along c over |c|1 (Hoelder's inequality). Nothing else is believed.

Exit codes: 0 everything is proven; 1 something is not; 2 the set cannot be read.
"""

import gzip
import hashlib
import json
import re
import sys
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import gcd
from pathlib import Path

FORMAT = 1
NUMBERS = 29
LARGEST = 1 << 53
# Proofs are of determinants of a few coordinates: far shorter.
_DIGITS = 999
_LINE = re.compile(rf"-?[0-9]{{1,{_DIGITS}}}( -?[0-9]{{1,{_DIGITS}}}){{{NUMBERS - 1}}}\n?")
_NAME, _HASH = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*"), re.compile(r"[0-9a-f]{64}")


class SetError(Exception):
    """A set, or a line of it, that cannot be read."""


@dataclass(frozen=True)
class Case:
    """A pair, and what is said to be right of it."""

    a: tuple[tuple[int, ...], ...]
    b: tuple[tuple[int, ...], ...]
    distance: tuple[int, int]
    weights_a: tuple[int, ...]
    weights_b: tuple[int, ...]
    axis: tuple[int, ...]

    @property
    def collides(self) -> bool:
        """Return whether both have a point in common."""
        return self.distance[0] == 0


def case_of(line: str) -> Case:
    """Read a line; raise SetError where it is none of a set."""
    if not _LINE.fullmatch(line):
        expected = f"{NUMBERS} whole numbers of at most {_DIGITS} digits, a blank between two, expected"
        raise SetError(f"{line[:60].strip()}: {expected}")
    n = tuple(map(int, line.split()))
    vertices = tuple(n[k : k + 3] for k in range(0, 18, 3))
    return Case(vertices[:3], vertices[3:], (n[18], n[19]), n[20:23], n[23:26], n[26:])


def fault_of(case: Case) -> str | None:
    """Return why the case does not prove what it says; None where it does."""
    p, q = case.distance
    if p < 0 or q < 1 or gcd(p, q) != 1:
        return f"distance {p} / {q}: not in lowest terms, or negative"
    if any(abs(x) > LARGEST for triangle in (case.a, case.b) for vertex in triangle for x in vertex):
        return f"a coordinate is more than {LARGEST} in size"
    sum_a, sum_b = sum(case.weights_a), sum(case.weights_b)
    if min(case.weights_a) < 0 or min(case.weights_b) < 0 or not sum_a or not sum_b:
        return "weights: one is negative, or all are 0"
    for k in range(3):
        on_a, on_b = _weighted(case.weights_a, case.a, k), _weighted(case.weights_b, case.b, k)
        # |on_a / sum_a - on_b / sum_b| <= p / q
        if q * abs(on_a * sum_b - on_b * sum_a) > p * sum_a * sum_b:
            return f"the points named are further apart than {p} / {q} in {'xyz'[k]}"
    if p:
        lowest = min(_along(case.axis, vertex) for vertex in case.a)
        highest = max(_along(case.axis, vertex) for vertex in case.b)
        size = sum(map(abs, case.axis))
        if not size or q * (lowest - highest) < p * size:
            return f"the axis {case.axis} does not show that they are {p} / {q} apart"
    return None


def _weighted(weights: Sequence[int], triangle: Sequence[Sequence[int]], k: int) -> int:
    return weights[0] * triangle[0][k] + weights[1] * triangle[1][k] + weights[2] * triangle[2][k]


def _along(axis: Sequence[int], vertex: Sequence[int]) -> int:
    return axis[0] * vertex[0] + axis[1] * vertex[1] + axis[2] * vertex[2]


@dataclass(frozen=True)
class Family:
    """An entry of set.json: the family's name, how many pairs its file has, and the hash of that."""

    name: str
    pairs: int
    sha256: str

    @property
    def file(self) -> str:
        """Return the name of its file."""
        return f"{self.name}.txt.gz"


def _refuse_pipe(path: Path) -> None:
    """Raise SetError where a file is there and would be waited for, or has no end."""
    if path.exists() and not path.is_file():
        raise SetError(f"{path}: is a folder, pipe, socket or device: an ordinary file is needed")


def families_of(folder: Path) -> list[Family]:
    """Read set.json; raise SetError where it is absent or not of this format."""
    path = folder / "set.json"
    _refuse_pipe(path)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["format"] is True or content["format"] != FORMAT:
            raise SetError(f"{path}: format {content['format']}: this reads format {FORMAT}")
        families = [Family(**entry) for entry in content["families"]]
        good = all(
            _NAME.fullmatch(one.name) and type(one.pairs) is int and _HASH.fullmatch(one.sha256)
            for one in families
        )
    except OSError as error:
        raise SetError(f"{path}: {error.strerror}: name the folder of a set") from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise SetError(f"{path}: not a TriTest set ({error})") from error
    if not good or len({one.name for one in families}) < len(families):
        raise SetError(f"{path}: not a TriTest set (a family's name, number of pairs or hash)")
    return families


def lines_of(folder: Path, family: Family) -> Iterator[tuple[int, str]]:
    """Yield the family's pairs, with the number of each, from 1 on; raise SetError where the file differs."""
    path = folder / family.file
    _refuse_pipe(path)
    number = 0
    try:
        if hashlib.sha256(path.read_bytes()).hexdigest() != family.sha256:
            raise SetError(f"{path}: not the file that set.json has the hash of")
        with gzip.open(path, "rt", encoding="ascii") as file:
            for line in file:
                if not line.startswith("#"):
                    number += 1
                    yield number, line
    except (OSError, EOFError, ValueError, zlib.error) as error:
        raise SetError(f"{path}: {error}") from error
    if number != family.pairs:
        raise SetError(f"{path}: {number} pairs: set.json says {family.pairs}")


def recheck(folder: Path) -> int:
    """Prove a set, and print what is not proven; return 0 where all is, 1 where not.

    Raises SetError where it cannot be read.
    """
    proven = wrong = 0
    for family in families_of(folder):
        for number, line in lines_of(folder, family):
            try:
                fault = fault_of(case_of(line))
            except SetError as error:
                raise SetError(f"{folder / family.file}: pair {number}: {error}") from error
            proven, wrong = proven + (fault is None), wrong + (fault is not None)
            if fault is not None:
                print(f"{family.name}:{number}: {fault}")
    passed = proven > 0 and wrong == 0
    print(f"{'PASSED' if passed else 'FAILED'}: {proven:,} pairs proven, {wrong:,} not")
    return 0 if passed else 1


def main() -> int:
    """Prove the set that the command line names."""
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        print("usage: python3 recheck.py SET", file=sys.stderr)
        return 2
    try:
        return recheck(Path(sys.argv[1]))
    except SetError as error:
        print(f"recheck: error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
