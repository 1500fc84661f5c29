"""What became of mutants, kept in build/ under everything that it depends on.

So a run after an unrelated change is quick.
"""

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from triaxis.golden.outputs import write_whole
from triaxis.sim.build import content_hash, rtl_hash
from triaxis.verif.mutation.builds import FOLDER, Killed
from triaxis.verif.mutation.killers import killers_hash
from triaxis.verif.mutation.mutant import Mutant

# Files of earlier states that are kept beside that of today's: for going back and forth.
_EARLIER = 1


@dataclass(frozen=True)
class Outcome:
    """What became of a mutant: how it was killed, if it was, and the targets that elaborate it."""

    mutant: Mutant
    killed: Killed | None
    targets: tuple[str, ...]
    seconds: float


class Store:
    """Outcomes that are known already, in build/."""

    def __init__(self, dut: Path, seed: int, pairs: int, fresh: bool) -> None:
        """Read what an earlier run with the same RTL, stimulus and seed left; nothing where ``fresh``."""
        self._dut = dut
        self._state = self._state_now()
        key = content_hash((), self._state, str(seed), str(pairs))
        self._path = FOLDER / f"outcomes-{key[:12]}.json"
        self._known: dict[str, Any] = {}
        if not fresh and self._path.exists():
            self._known = json.loads(self._path.read_text())

    def _state_now(self) -> str:
        return content_hash((), rtl_hash(self._dut), killers_hash())

    def _key(self, mutant: Mutant, stage: str) -> str:
        text = f"{stage}\0{mutant.id}\0{mutant.edit.start}\0{mutant.edit.text}"
        return hashlib.sha256(text.encode()).hexdigest()[:24]

    def get(self, mutant: Mutant, stage: str) -> Outcome | None:
        """Return what is known of a mutant in that stage, None where nothing is."""
        known = self._known.get(self._key(mutant, stage))
        if known is None:
            return None
        killed = None if known["killed"] is None else Killed(**known["killed"])
        return Outcome(mutant, killed, tuple(known["targets"]), known["seconds"])

    def put(self, outcome: Outcome, stage: str) -> None:
        """Keep an outcome."""
        self._known[self._key(outcome.mutant, stage)] = {
            "killed": None if outcome.killed is None else asdict(outcome.killed),
            "targets": list(outcome.targets),
            "seconds": outcome.seconds,
        }

    def save(self) -> None:
        """Write all to build/, unless what it depends on has changed since; remove files of long ago."""
        if self._state_now() != self._state:
            return
        write_whole(self._path, json.dumps(self._known))
        others = {path: path.stat().st_mtime for path in FOLDER.glob("outcomes-*.json") if path != self._path}
        for path in sorted(others, key=lambda path: -others[path])[_EARLIER:]:
            path.unlink(missing_ok=True)
