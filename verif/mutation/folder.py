"""The folder in build/ where mutants are made and played, and what a run that was killed leaves there."""

import fcntl
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from triaxis.sim.paths import BUILD

FOLDER = BUILD / "mutation"

_PREFIXES = ("dut-", "proof-", "exhaustive-", "mutant-")
# Seconds: a file that is written whole and renamed is younger, and holds no lock.
_YOUNG = 60


@contextmanager
def temporary(prefix: str) -> Iterator[Path]:
    """Provide a folder that is removed afterwards, and that no `sweep` takes meanwhile."""
    if prefix not in _PREFIXES:
        raise ValueError(f"{prefix}: not one of {', '.join(_PREFIXES)}")
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (FOLDER / ".lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_SH)
        with tempfile.TemporaryDirectory(dir=FOLDER, prefix=prefix) as name:
            yield Path(name)


def sweep(folder: Path = FOLDER) -> None:
    """Remove what runs left that were killed, unless another run is at work in the folder now."""
    folder.mkdir(parents=True, exist_ok=True)
    before = time.time() - _YOUNG
    with (folder / ".lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return
        for path in folder.iterdir():
            if _left(path) and path.stat().st_mtime < before:
                _remove(path)


def _left(path: Path) -> bool:
    return path.name.endswith(".partial") or (path.is_dir() and path.name.startswith(_PREFIXES))


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
