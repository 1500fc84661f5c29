"""Making a TriTest set: every family of the core's stimulus and of the stress test, each pair with its proof.

The core's families come at several widths, of which three fit float32; those of the stress test with all
settings of their knob, up to the 53 bits of float64. What is right is asked of the golden model's solver, and
each line is proven by `recheck` before it is written: what no proof was found for never gets into a set.
"""

import gzip
import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from math import gcd, lcm
from pathlib import Path

import numpy as np

from triaxis.bench.stress.families import FAMILIES as KNOBS
from triaxis.bench.stress.families import Family as Knobs
from triaxis.bench.tritest.recheck import FORMAT, Family, case_of, fault_of
from triaxis.golden.errors import ToldError
from triaxis.golden.exact import Rational
from triaxis.golden.judge import SOLVER
from triaxis.golden.outputs import write_whole
from triaxis.golden.processes import in_processes
from triaxis.verif.core.stimulus.families import FAMILIES
from triaxis.verif.core.stimulus.stimulus import Family as Stimuli
from triaxis.verif.core.stimulus.stimulus import Ints, Rng, divided

# Bits of a coordinate, sign included: float32 holds those of the first three.
WIDTHS = (8, 16, 25, 32)
# Pairs that a process proves at a time.
_CHUNK = 500

Maker = Callable[[Rng, int], Ints]


class ProofError(ToldError):
    """A pair of which the solver's answer does not prove itself. Never seen."""


def _at_widths(make: Stimuli, rng: Rng, count: int) -> Ints:
    shares = zip(WIDTHS, divided(count, [1] * len(WIDTHS)), strict=True)
    return np.concatenate(
        [make(rng, share, width, 0).pairs.astype(np.int64) for width, share in shares if share]
    )


def _at_settings(knobs: Knobs, rng: Rng, count: int) -> Ints:
    shares = zip(knobs.settings, divided(count, [1] * len(knobs.settings)), strict=True)
    return np.concatenate([setting.make(rng, share) for setting, share in shares if share])


def makers() -> dict[str, Maker]:
    """Return what makes the pairs (N, 2, 3, 3) of each family, by the family's name."""
    made: dict[str, Maker] = {_slug(name): partial(_at_widths, make) for name, make in FAMILIES.items()}
    return made | {f"hard-{_slug(knobs.name)}": partial(_at_settings, knobs) for knobs in KNOBS}


def _slug(name: str) -> str:
    return "-".join(name.split())


def line_of(pair: Sequence[Sequence[Sequence[int]]]) -> str:
    """Return the line of a set for a pair (2, 3, 3); raise ProofError where there is no proof."""
    a, b = pair
    nearest = SOLVER.nearest_points(a, b)
    distance = nearest.distance
    axis = _integers(SOLVER.best_axis(a, b).axis) if distance else [0, 0, 0]
    numbers = [
        *(x for triangle in pair for vertex in triangle for x in vertex),
        int(distance.numerator), int(distance.denominator),
        *_integers(nearest.weights_a), *_integers(nearest.weights_b), *axis,
    ]  # fmt: skip
    line = " ".join(map(str, numbers))
    fault = fault_of(case_of(line))
    if fault is not None:
        raise ProofError(f"{line}: {fault}: a fault of the solver")
    return line


def _integers(values: Sequence[Rational]) -> list[int]:
    """Return whole numbers in the same proportion, as small as can be."""
    scale = lcm(*(int(value.denominator) for value in values))
    whole = [int(value.numerator) * (scale // int(value.denominator)) for value in values]
    divisor = gcd(*whole) or 1
    return [value // divisor for value in whole]


def _lines(pairs: Ints) -> list[str]:
    return [line_of(pair) for pair in pairs.tolist()]


def write_set(folder: Path, count: int, seed: int, progress: Callable[[int], None]) -> list[Family]:
    """Write ``count`` pairs of each family; ``progress`` is told how many were proven.

    The same seed gives the same files, byte for byte. ``set.json`` goes first and comes last: a folder that
    has it is whole.
    """
    manifest = folder / "set.json"
    manifest.unlink(missing_ok=True)
    families: list[Family] = []
    for name, make in makers().items():
        pairs = make(np.random.default_rng([seed, *name.encode()]), count)
        chunks = [pairs[start : start + _CHUNK] for start in range(0, len(pairs), _CHUNK)]
        proven = in_processes(_lines, chunks, lambda lines: progress(len(lines)))
        text = f"# TriTest {FORMAT}: {name}, seed {seed}\n" + "".join(
            f"{line}\n" for part in proven for line in part
        )
        packed = gzip.compress(text.encode("ascii"), mtime=0)
        families.append(Family(name, len(pairs), hashlib.sha256(packed).hexdigest()))
        write_whole(folder / families[-1].file, packed)
    content = {"format": FORMAT, "seed": seed, "families": [asdict(family) for family in families]}
    write_whole(manifest, json.dumps(content, indent=1) + "\n")
    return families
