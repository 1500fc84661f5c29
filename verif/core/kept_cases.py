"""Counterexamples that are kept: one small JSON file each, which later runs send first.

What a failing run finds is kept in build/; copied to verif/core/kept/ and committed it is kept for good.

A file says what is sent (``pairs``, the last of which failed) and how it was found (``found``: the
configuration, what was wrong, what the core said, what is right, the fault that it revealed). Its name
comes from a hash of what is sent, so that nothing is kept twice, and a changed file is noticed.
"""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.outputs import write_whole
from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH, Pairs, coordinate_range
from triaxis.sim.configuration import Configuration
from triaxis.sim.paths import BUILD, VERIF
from triaxis.verif.core.failing_pairs import Stream

REGRESSIONS = VERIF / "core" / "kept"
# Those that runs in this checkout found.
FOUND = BUILD / "kept"
_HASH_DIGITS = 12
_FOUND = ("configuration", "symptom", "meaning", "core_said", "right", "fault")


@dataclass(frozen=True, eq=False)
class RegressionCase:
    """What is sent, and how it was found: the entries of ``found`` as text."""

    stream: Stream
    found: dict[str, str]

    @property
    def name(self) -> str:
        """Return the name of its file, without the ending."""
        rows = [
            f"{m}:{p.ravel().tolist()}" for p, m in zip(self.stream.pairs, self.stream.margins, strict=True)
        ]
        digest = hashlib.sha256(";".join(rows).encode()).hexdigest()
        return f"{self.found['symptom']}-{digest[:_HASH_DIGITS]}"

    @property
    def width(self) -> int:
        """Return the smallest width of a core that holds all of it."""
        # Of -1 - x for x below 0: as many bits as x needs beside its sign.
        largest = int(np.maximum(self.stream.pairs, ~self.stream.pairs).max())
        return max(MIN_WIDTH, largest.bit_length() + 1)


def case_text(case: RegressionCase) -> str:
    """Return the case as JSON, one vertex list a line."""
    sent = [
        f'    {{"margin": {margin},\n     "A": {json.dumps(a)},\n     "B": {json.dumps(b)}}}'
        for (a, b), margin in zip(case.stream.pairs.tolist(), case.stream.margins.tolist(), strict=True)
    ]
    found = json.dumps(case.found, indent=2).replace("\n", "\n  ")
    return (
        f'{{\n  "width": {case.width},\n  "pairs": [\n'
        + ",\n".join(sent)
        + f'\n  ],\n  "found": {found}\n}}\n'
    )


def write_case(case: RegressionCase, folder: Path = REGRESSIONS) -> Path:
    """Keep a case: whole or not at all. Returns its file: that of an earlier case that sends the same."""
    digest = case.name.rpartition("-")[2]
    same = sorted(folder.glob(f"*-{digest}.json"))
    if same:
        return same[0]
    return write_whole(folder / f"{case.name}.json", case_text(case))


def read_case(path: Path) -> RegressionCase:
    """Read a case; raise InputError where the file is damaged, or is not the one that was written."""
    data = read_input(path)
    try:
        content = json.loads(data)
    except ValueError as error:
        raise InputError(f"{path}: not JSON ({error}): restore or delete it") from error
    case = _case(path, content)
    if case.name != path.stem or content["width"] != case.width:
        raise InputError(
            f"{path}: was changed: width {case.width} and the name {case.name}.json go with what it sends"
        )
    return case


def _case(path: Path, content: Any) -> RegressionCase:
    try:
        rows, found = content["pairs"], content["found"]
        # Left to NumPy, numbers like 1.5 or "1" would be converted.
        values = [
            value for row in rows for part in (row["A"], row["B"]) for vertex in part for value in vertex
        ]
        if any(
            type(value) is not int for value in [*values, *(row["margin"] for row in rows), content["width"]]
        ):
            raise TypeError("a coordinate, margin or width is no integer")
        pairs = np.array([[row["A"], row["B"]] for row in rows], np.int64)
        stream = Stream(pairs, np.array([row["margin"] for row in rows], np.int64))
        if any(type(found[key]) is not str for key in _FOUND):
            raise TypeError("found: must be texts")
        low, high = coordinate_range(MAX_WIDTH)
        if (
            pairs.min() < low
            or pairs.max() > high
            or not 0 <= stream.margins.min() <= stream.margins.max() <= high - low
        ):
            raise ValueError(f"does not fit {MAX_WIDTH} bits")
    except (KeyError, TypeError, ValueError, IndexError, OverflowError) as error:
        reason = f"{error} is missing" if isinstance(error, KeyError) else error
        raise InputError(f"{path}: not a regression case: {reason}; restore or delete it") from error
    return RegressionCase(stream, {key: found[key] for key in _FOUND})


def read_cases(folder: Path = REGRESSIONS) -> list[RegressionCase]:
    """Read all cases of a folder, in the order of their names; InputError where one is damaged."""
    return [read_case(path) for path in sorted(folder.glob("*.json"))]


def load_regressions(configuration: Configuration, *folders: Path) -> tuple[Pairs, npt.NDArray[np.int64]]:
    """Return pairs (N, 2, 3, 3) and margins (N,) of all cases that a core in that configuration can be
    sent, to be sent in this order without a reset; a case is there whole, or not at all.

    ``folders``: those that were kept for good, where none is named.
    """
    cases = (case for folder in folders or (REGRESSIONS,) for case in read_cases(folder))
    fitting = [case.stream for case in cases if case.stream.fits(configuration)]
    pairs = np.concatenate([np.empty((0, 2, 3, 3), np.int64), *(stream.pairs for stream in fitting)])
    return pairs, np.concatenate([np.empty(0, np.int64), *(stream.margins for stream in fitting)])
