"""Where each mutant is tried first: the stage and the test that noticed it in an earlier run.

An order saves what others would try in vain, and decides nothing: who is not noticed there is tried by all
the others, and a place that is no more is as none. Those that the very first trial notices are not listed.
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.paths import VERIF

FILE = VERIF / "mutation" / "order.json"
# Names in a line of the file.
_IN_A_LINE = 10


@dataclass(frozen=True)
class Place:
    """A stage, by its name, and one of its tests."""

    stage: str
    test: str


def _short(mutant: str) -> str:
    """Return what is left of a mutant's name in the file: two that are alike are only tried in vain."""
    return mutant.rpartition("/")[2]


def read_order(mutants: Iterable[str], file: Path = FILE) -> dict[str, Place]:
    """Return the places of mutants, for those that have one. Raises InputError where the file is damaged."""
    try:
        content: dict[str, dict[str, list[str]]] = json.loads(file.read_text())
        places = {
            name: Place(stage, test)
            for stage, tests in content.items()
            for test, lines in tests.items()
            for line in lines
            for name in line.split()
        }
    except (OSError, ValueError, AttributeError, TypeError) as error:
        raise InputError(
            f"{file}: damaged: {error}: write {{}} into it, and run `triaxis prove mutate --order`"
        ) from error
    return {mutant: places[_short(mutant)] for mutant in mutants if _short(mutant) in places}


def remember(noticed: Mapping[str, tuple[Place, int]], file: Path = FILE, others: Iterable[str] = ()) -> Path:
    """Write down where mutants were noticed in a run, and in which of their trials, for those to come.

    ``others`` keep their places.
    """
    known = read_order(noticed, file)
    places = read_order(others, file) | {
        mutant: place
        for mutant, (place, trial) in noticed.items()
        if trial != 1 or known.get(mutant) == place
    }
    names: dict[Place, list[str]] = {}
    for mutant, place in places.items():
        names.setdefault(place, []).append(_short(mutant))
    content: dict[str, Any] = {}
    for place in sorted(names, key=lambda one: (one.stage, one.test)):
        listed = sorted(names[place])
        lines = [" ".join(listed[at : at + _IN_A_LINE]) for at in range(0, len(listed), _IN_A_LINE)]
        content.setdefault(place.stage, {})[place.test] = lines
    return write_whole(file, json.dumps(content, indent=1) + "\n")
