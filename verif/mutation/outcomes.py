"""What became of mutants, kept in build/ under everything that it depends on, so that no run begins anew."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from threading import Lock
from typing import Any

from triaxis.golden.outputs import write_whole
from triaxis.sim.build import content_hash, rtl_hash
from triaxis.verif.mutation.builds import FOLDER
from triaxis.verif.mutation.killers import killers_hash
from triaxis.verif.mutation.mutant import Mutant

# Files of earlier states that are kept beside that of today's: for going back and forth.
_EARLIER = 1


@dataclass(frozen=True)
class Killed:
    """How a mutant was noticed: the test that ran, the model, what was wrong, after how many pairs.

    ``stage``: of the run; ``trial``: the number of its trials until then, this one among them.
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
    """What is known already: how mutants were killed, and which survive everything."""

    def __init__(self, dut: Path, seed: int, fresh: bool) -> None:
        """Read what an earlier run with the same RTL, killers and seed left; nothing where ``fresh``."""
        self._dut = dut
        # Several threads add to it.
        self._lock = Lock()
        self._state = self._state_now()
        self._path = FOLDER / f"outcomes-{content_hash((), self._state, str(seed))[:12]}.json"
        known: dict[str, Any] = {}
        if not fresh and self._path.exists():
            known = json.loads(self._path.read_text())
        self.killed = {name: Killed(**how) for name, how in known.get("killed", {}).items()}
        self.surviving: set[str] = set(known.get("surviving", ()))

    def _state_now(self) -> str:
        return content_hash((), rtl_hash(self._dut), killers_hash())

    def save(self) -> None:
        """Write all to build/, unless what it depends on has changed since; remove files of long ago."""
        if self._state_now() != self._state:
            return
        with self._lock:
            self._write({name: asdict(how) for name, how in dict(self.killed).items()})

    def _write(self, killed: dict[str, Any]) -> None:
        write_whole(self._path, json.dumps({"killed": killed, "surviving": sorted(self.surviving)}))
        others = {path: path.stat().st_mtime for path in FOLDER.glob("outcomes-*.json") if path != self._path}
        for path in sorted(others, key=lambda path: -others[path])[_EARLIER:]:
            path.unlink(missing_ok=True)
