"""Packages of the lock file of peers, found where they are installed."""

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from types import ModuleType
from typing import Any

from triaxis.bench.error.peers.peer import PeerAbsentError

_INSTALL = "`make peers` installs it"


def installed_version(distribution: str, module: str) -> str:
    """Return the version of a package that can be imported; raise PeerAbsentError otherwise."""
    imported(module)
    try:
        return version(distribution)
    except PackageNotFoundError as error:
        raise PeerAbsentError(f"{distribution}: not installed: {_INSTALL}") from error


def imported(module: str) -> Any:
    """Return a module; raise PeerAbsentError where it is absent or does not start."""
    try:
        found: ModuleType = import_module(module)
    except ModuleNotFoundError as error:
        raise PeerAbsentError(f"{error.name}: not installed: {_INSTALL}") from error
    # A library of the system that it needs may be missing.
    except (ImportError, OSError) as error:
        raise PeerAbsentError(f"{module}: installed, but does not start: {error}") from error
    return found
