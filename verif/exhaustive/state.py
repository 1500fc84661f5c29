"""How far a run has come, kept in a file so that it can be stopped at any time and continued."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.build import content_hash
from triaxis.sim.validity import Validity
from triaxis.verif.exhaustive.check import ClassResult, Counts, Mismatch


@dataclass(frozen=True)
class Identity(Validity):
    """What a run is of. A run of another identity is another run: neither continues the other."""

    grid: int
    seed: int
    config: str

    @property
    def key(self) -> str:
        """Return a short name, unique to this identity."""
        return content_hash((), super().key, str(self.grid), str(self.seed), self.config)[:12]


@dataclass
class Progress:
    """The first ``classes done`` classes (see `Counts.classes`), and the seconds they took."""

    result: ClassResult = field(default_factory=ClassResult)
    seconds: float = 0.0

    @property
    def done(self) -> int:
        """Return how many classes are done."""
        return self.result.counts.classes


def state_file(folder: Path, identity: Identity) -> Path:
    """Return where the state of that run is kept."""
    return folder / f"grid{identity.grid}-{identity.key}.state.json"


def other_states(folder: Path, identity: Identity) -> list[Path]:
    """Return the states of unfinished runs on the same grid with another seed, RTL or checker."""
    own = state_file(folder, identity)
    return sorted(path for path in folder.glob(f"grid{identity.grid}-*.state.json") if path != own)


def save(folder: Path, identity: Identity, progress: Progress) -> None:
    """Write the state."""
    content = {
        "identity": asdict(identity),
        "seconds": progress.seconds,
        "counts": asdict(progress.result.counts),
        "mismatches": [asdict(mismatch) for mismatch in progress.result.mismatches],
    }
    write_whole(state_file(folder, identity), json.dumps(content) + "\n")


def load(folder: Path, identity: Identity) -> Progress:
    """Return how far the run has come: nowhere where there is no state of it."""
    path = state_file(folder, identity)
    try:
        content = json.loads(path.read_text())
        if Identity(**content["identity"]) != identity:
            raise InputError(f"{path}: state of another run: delete it to start anew")
        counts: Any = {k: tuple(v) if isinstance(v, list) else v for k, v in content["counts"].items()}
        mismatches = [Mismatch(**mismatch) for mismatch in content["mismatches"]]
        return Progress(ClassResult(Counts(**counts), mismatches), float(content["seconds"]))
    except FileNotFoundError:
        return Progress()
    except InputError:
        raise
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise InputError(f"{path}: damaged: delete it to start anew") from error


def forget(folder: Path, identity: Identity) -> None:
    """Remove the state: the run is over."""
    state_file(folder, identity).unlink(missing_ok=True)
