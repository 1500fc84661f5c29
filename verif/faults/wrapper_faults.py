"""Faults of the wrapper CollisionDetector, and the smallest pair and normals that show one."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.pairs import Pairs
from triaxis.sim.detector import detect
from triaxis.verif.core.detector_check import wrapper_questions
from triaxis.verif.counterexample.shrinking import Predicate, shrink
from triaxis.verif.faults.result import Attempt, Catch, Example

CHECK = "CollisionDetector"

Normals = npt.NDArray[np.int64]
# Takes pairs (N, 2, 3, 3) and normals (N, 2, 3); says which fail, (N,).
_Fails = Callable[[Pairs, Normals], npt.NDArray[np.bool_]]


def try_wrapper(dut: Path, seed: int) -> Attempt:
    """Ask the wrapper built from ``dut`` what a sign-off asks it."""
    pairs, normals = wrapper_questions(seed)
    wrong = np.flatnonzero(_wrong(pairs, normals, dut))
    if not len(wrong):
        return Attempt(None, f"all of {len(pairs)} pairs are answered rightly", clean=True)
    first = int(wrong[0])
    near = bool(_near(pairs[first : first + 1])[0])
    message = f"wrapper says {_word(not near)}, exact answer {_word(near)}"
    catch = Catch(CHECK, message, first + 1)
    return Attempt(catch, example=partial(_example, pairs[first], normals[first], dut))


def _near(pairs: Pairs) -> npt.NDArray[np.bool_]:
    return bulk_facts(pairs, np.zeros(len(pairs), np.int64)).separating == 0


def _wrong(pairs: Pairs, normals: Normals, dut: Path) -> npt.NDArray[np.bool_]:
    return detect(pairs, normals, dut) != _near(pairs)


def _word(near: bool) -> str:
    return "near" if near else "clear"


def _example(pair: Pairs, normals: Normals, dut: Path) -> Example:
    """Return the pair (2, 3, 3) and the normals (2, 3) made small in turns, until neither gets smaller."""
    near = bool(_near(pair[None])[0])

    def fails(pairs: Pairs, given: Normals) -> npt.NDArray[np.bool_]:
        """Say which pairs are answered wrongly, and in the same way as the first."""
        return _wrong(pairs, given, dut) & (_near(pairs) == near)

    small, given = pair, normals
    while True:
        before = small, given
        small = shrink(small, 0, _with_normals(fails, given))[0]
        given = _smaller_normals(small, given, fails)
        if (small == before[0]).all() and (given == before[1]).all():
            break
    return Example(
        _text(pair, normals),
        _text(small, given),
        f"says {_word(not near)} where the pair is {_word(near)}",
        _word(not near),
        _word(near),
        [{"margin": 0, "A": small[0].tolist(), "B": small[1].tolist()}],
        normals=given.tolist(),
    )


def _with_normals(fails: _Fails, given: Normals) -> Predicate:
    return lambda pairs, _: fails(pairs, np.repeat(given[None], len(pairs), 0))


def _smaller_normals(pair: Pairs, given: Normals, fails: _Fails) -> Normals:
    """Return normals of which no component can be 0, halved, or of the other sign where it is negative."""
    for index in np.ndindex(*given.shape):
        while (value := int(given[index])) != 0:
            tries = np.repeat(given[None], 3, 0)
            tries[:, *index] = 0, abs(value) // 2, abs(value)
            smaller = np.array([True, True, value < 0])
            found = np.flatnonzero(fails(np.repeat(pair[None], 3, 0), tries) & smaller)
            if not len(found):
                break
            given = tries[found[0]]
    return given


def _text(pair: Pairs, normals: Normals) -> str:
    return f"{pair.tolist()}, normals {normals.tolist()}"
