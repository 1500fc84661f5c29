"""What became of all mutants when they were last played, kept with the sources.

Where a block's state is today's (`killers.outcomes_hash`: the RTL, tests, judges and tools that decide), its
mutants would fare as they did, so a sign-off takes the record for it, and plays a sample of it again. Of
another state the record decides nothing: it tells where a mutant was noticed then, which is where it is tried
first, and everywhere else where that is in vain.
"""

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zlib import crc32

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.paths import VERIF
from triaxis.sim.player import ASSERTION
from triaxis.verif.mutation.mutant import Mutant
from triaxis.verif.mutation.outcomes import Killed

FILE = VERIF / "mutation" / "record.json"
# A record is of runs with this seed.
SEED = 1
# Of what is recorded, so much is played again.
_ONE_IN = 20
# What a recorded kill says in the place of the symptom, where that was no assertion.
_RECORDED = "as recorded"
_BY = {ASSERTION: "assertion", _RECORDED: "run"}
# Names in a line of the file.
_IN_A_LINE = 10


@dataclass(frozen=True)
class Place:
    """A stage, by its name, and one of its tests."""

    stage: str
    test: str


@dataclass(frozen=True)
class Record:
    """The state of each block that was played as a whole, and how each mutant was killed, by short names."""

    states: Mapping[str, str]
    kills: Mapping[str, Killed]

    def places(self, mutants: Iterable[Mutant]) -> dict[str, Place]:
        """Return where mutants were noticed, for those that were: the order in which to try them."""
        known = {one.id: self.kills[one.short] for one in mutants if one.short in self.kills}
        return {name: Place(how.stage, how.test) for name, how in known.items()}

    def killed(self, mutants: Iterable[Mutant], states: Mapping[str, str]) -> dict[str, Killed]:
        """Return how mutants were killed, of blocks whose recorded state is that which is given."""
        same = {block for block, state in states.items() if self.states.get(block) == state}
        return {
            one.id: self.kills[one.short] for one in mutants if one.block in same and one.short in self.kills
        }


def drawn(mutant: str, seed: int) -> bool:
    """Return whether a mutant is in the sample that a seed draws from what is recorded."""
    return crc32(f"{seed}/{mutant}".encode()) % _ONE_IN == 0


def read_record(file: Path = FILE) -> Record:
    """Return what is recorded. Raises InputError where the file is damaged."""
    try:
        content: dict[str, Any] = json.loads(file.read_text())
        found = [
            (name, Killed(test, stage.split(",")[0], symptom, 0, stage, 0))
            for stage, tests in content["noticed"].items()
            for test, kinds in tests.items()
            for symptom, by in _BY.items()
            for line in kinds.get(by, ())
            for name in line.split()
        ]
        kills = dict(found)
        if len(kills) < len(found):
            raise ValueError("a mutant is named twice")
        return Record({str(block): str(state) for block, state in content["states"].items()}, kills)
    except (OSError, ValueError, LookupError, AttributeError, TypeError) as error:
        raise InputError(
            f'{file}: damaged: {error!r}: write {{"states": {{}}, "noticed": {{}}}} into it, and run '
            "`triaxis prove mutate --record`"
        ) from error


def write_record(record: Record, file: Path = FILE) -> Path:
    """Write what is to be recorded, whole or not at all."""
    noticed: dict[str, dict[str, dict[str, list[str]]]] = {}
    for name, how in sorted(record.kills.items(), key=lambda one: (one[1].stage, one[1].test, one[0])):
        kinds = noticed.setdefault(how.stage, {}).setdefault(how.test, {})
        kinds.setdefault(_BY.get(how.symptom, _BY[_RECORDED]), []).append(name)
    for tests in noticed.values():
        for kinds in tests.values():
            for by, names in kinds.items():
                kinds[by] = [" ".join(names[at : at + _IN_A_LINE]) for at in range(0, len(names), _IN_A_LINE)]
    content = {"states": dict(sorted(record.states.items())), "noticed": noticed}
    return write_whole(file, json.dumps(content, indent=1) + "\n")


def recorded(
    before: Record, every: Sequence[Mutant], played: Mapping[str, Killed | None],
    equivalent: Collection[str], states: Mapping[str, str],
) -> Record:  # fmt: skip
    """Return the record after a run, with those of today's mutants, ``every``, alone.

    ``played``: what came of those in the run. A block is recorded as of its state where none of its mutants
    is left: each was killed or is ``equivalent``, in this run or, the same state, in those before.
    """
    kills = {one.short: before.kills[one.short] for one in every if one.short in before.kills}
    left: set[str] = set()
    for one in every:
        if one.id not in played:
            settled = before.states.get(one.block) == states[one.block]
        else:
            kills.pop(one.short, None)
            # Of what the evidence notices there is nothing to record: every run checks that.
            if (how := played[one.id]) is not None and how.stage:
                kills[one.short] = how
            settled = how is not None or one.id in equivalent
        if not settled:
            left.add(one.block)
    return Record({block: state for block, state in states.items() if block not in left}, kills)
