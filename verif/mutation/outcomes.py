"""What became of mutants, kept in build/ under everything that it depends on, so that no run begins anew."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from threading import Lock

from triaxis.golden.outputs import write_whole
from triaxis.sim.build import content_hash
from triaxis.verif.mutation.builds import FOLDER
from triaxis.verif.mutation.catalogue import Catalogue
from triaxis.verif.mutation.killers import states
from triaxis.verif.mutation.mutant import Mutant

# Files of earlier states that are kept beside that of today's: for going back and forth.
_EARLIER = 1


@dataclass(frozen=True)
class Killed:
    """How a mutant was noticed: the test that ran, the model, what was wrong, after how many pairs.

    ``stage``: of the run; ``trial``: the number of its trials until then, this one among them; 0 where it is
    taken from the record.
    """

    test: str
    target: str
    symptom: str
    pairs: int
    stage: str = ""
    trial: int = 1


@dataclass(frozen=True)
class Outcome:
    """What became of a mutant: how it was killed, if it was, and the targets that elaborate it."""

    mutant: Mutant
    killed: Killed | None
    targets: tuple[str, ...]


class Store:
    """What is known already, a file for each block: how mutants were killed; which survive everything;
    which, listed as equivalent, survive the one test that such get.
    """

    def __init__(self, catalogue: Catalogue, dut: Path, seed: int, fresh: bool) -> None:
        """Read what earlier runs with the same RTL, tests and seed left; nothing where ``fresh``.

        ``catalogue``: of the mutants that may be added.
        """
        self._dut = dut
        # Several threads add to it.
        self._lock = Lock()
        self._block = {one.id: one.block for one in catalogue.mutants}
        self._state = states(dut)
        self.killed: dict[str, Killed] = {}
        self.surviving: set[str] = set()
        self.excused: set[str] = set()
        self._paths = {
            block: FOLDER / f"outcomes-{block}-{content_hash((), state, str(seed))[:12]}.json"
            for block, state in self._state.items()
        }
        for block, path in self._paths.items():
            if not fresh and path.exists():
                known = json.loads(path.read_text())
                self.killed |= {name: Killed(**how) for name, how in known["killed"].items()}
                self.surviving |= set(known["surviving"])
                self.excused |= set(known["excused"])
                names = [*known["killed"], *known["surviving"], *known["excused"]]
                self._block |= dict.fromkeys(names, block)

    def save(self) -> None:
        """Write all to build/, but what depends on something that has changed since; remove old files."""
        now = states(self._dut)
        with self._lock:
            for block, path in self._paths.items():
                if now[block] == self._state[block]:
                    self._write(block, path)

    def _write(self, block: str, path: Path) -> None:
        killed = {
            name: asdict(how) for name, how in dict(self.killed).items() if self._block.get(name) == block
        }
        surviving, excused = (
            sorted(name for name in names if self._block.get(name) == block)
            for names in (self.surviving, self.excused)
        )
        if not killed and not surviving and not excused:
            return
        write_whole(path, json.dumps({"killed": killed, "surviving": surviving, "excused": excused}))
        found = FOLDER.glob(f"outcomes-{block}-*.json")
        others = {other: other.stat().st_mtime for other in found if other != path}
        for other in sorted(others, key=lambda one: -others[one])[_EARLIER:]:
            other.unlink(missing_ok=True)
