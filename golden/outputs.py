"""Output files: written whole or not at all, and ordinary files only.

One rule for every file that is written: the content goes to a file beside it, which then takes its place,
so that a full disk or a kill leaves what was there before. Folders that are missing are made. Where the name
is a symbolic link, its target is written. What is no ordinary file (a device, a pipe, a folder) is refused,
and so is the file that this process's own output goes to: taking its place would lose that output.
"""

import importlib.metadata
import os
import stat
import threading
from pathlib import Path

from triaxis.golden.errors import InputError


def build_folder() -> Path:
    """Return where what is built is kept: in the checkout, or among the user's caches, by version."""
    root = Path(__file__).resolve().parents[1]
    if (root / "pyproject.toml").exists():
        return root / "build"
    caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return caches / "triaxis" / importlib.metadata.version("triaxis")


def write_whole(path: Path, content: str | bytes) -> Path:
    """Write a file, text as UTF-8; raise InputError where that cannot be done."""
    whole = content.encode() if isinstance(content, str) else content
    target = ordinary(path)
    make_folder(target.parent)
    # Short, so that it is no longer than names may be.
    partial = target.with_name(f".triaxis-{os.getpid()}-{threading.get_ident()}.partial")
    try:
        try:
            partial.write_bytes(whole)
            partial.replace(target)
        finally:
            partial.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot write: {error.strerror or error}") from error
    return path


def remove_older(path: Path) -> None:
    """Remove what an earlier run wrote there; raise InputError where that, or writing, cannot be done."""
    target = ordinary(path)
    try:
        target.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot remove the older one: {error.strerror or error}") from error


def make_folder(path: Path) -> Path:
    """Make a folder and those above it, where there are none; raise InputError where that cannot be done."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot make this folder: {error.strerror or error}") from error
    return path


def ordinary(path: Path) -> Path:
    """Return the file that is meant, behind all links; raise InputError where it is no ordinary file."""
    try:
        target = path.resolve()
        # Of the name, not of the target: that of /dev/stdout is no path where it is a pipe.
        found = path.stat() if path.exists() else None
    # A loop of links is a RuntimeError before Python 3.13.
    except (OSError, RuntimeError) as error:
        raise InputError(f"{path}: cannot write: {getattr(error, 'strerror', None) or error}") from error
    if found is None:
        return target
    if stat.S_ISDIR(found.st_mode):
        raise InputError(f"{path}: is a folder: name a file to write to")
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"{path}: is a device or a pipe: name an ordinary file to write to")
    if any(os.path.samestat(found, own) for own in _own_outputs()):
        raise InputError(f"{path}: the output of this very command goes there: name another file")
    return target


def _own_outputs() -> list[os.stat_result]:
    own: list[os.stat_result] = []
    for number in (1, 2):
        try:
            own.append(os.fstat(number))
        # Closed.
        except OSError:
            continue
    return own
