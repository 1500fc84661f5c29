"""What a result is valid for: the RTL, the files that drive and judge it, the Verilator that simulated it.

A method names the modules that its results come from. What these import, wherever it lies, counts with them,
and so does the compiled code in the folders of all of these. Nothing else counts: where the command line or a
report changes, every result stands. What a run is of must stand until it ends: an edit is known, however soon
it was taken back.
"""

import ast
import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.native import written
from triaxis.sim.build import content_hash, rtl_files, rtl_hash
from triaxis.sim.paths import DUT, ROOT
from triaxis.sim.toolchain import verilator

_PACKAGE = "triaxis"
# What is compiled, or read by what is: it belongs to the modules of its folder.
_COMPILED = (".cpp", ".h", ".sv", ".v", ".vlt", ".csv")


@dataclass(frozen=True)
class Sources:
    """The files that a method's results come from.

    ``modules``: full names of Python modules, also those that are loaded by name only, which no import shows;
    ``data``: further files, as patterns in the checkout; ``without``: files that decide none of them.
    """

    modules: tuple[str, ...]
    data: tuple[str, ...] = ()
    without: tuple[str, ...] = ()

    def files(self) -> list[Path]:
        """Return all of them in a fixed order; raise ValueError where a module or a pattern names nothing."""
        waiting = [path for name in self.modules for path in _named(name)]
        if missing := [name for name in self.modules if not list(_named(name))]:
            raise ValueError(f"{', '.join(missing)}: no such module")
        found: set[Path] = set()
        while waiting:
            path = waiting.pop()
            if path not in found:
                found.add(path)
                waiting += _imported(path.read_text(encoding="utf-8"))
        for folder in {path.parent for path in found}:
            found.update(_compiled_in(folder))
        found.update(_matching(self.data))
        found.difference_update(_matching(self.without))
        return sorted(found)

    def hash(self) -> str:
        """Return the hash of their contents as they stand now."""
        return content_hash(self.files())


def _matching(patterns: tuple[str, ...]) -> set[Path]:
    found: set[Path] = set()
    for pattern in patterns:
        matching = list(ROOT.glob(pattern))
        if not matching:
            raise ValueError(f"{pattern}: no such file")
        found.update(matching)
    return found


def _place(name: str) -> Path | None:
    package, *parts = name.split(".")
    return ROOT.joinpath(*parts) if package == _PACKAGE and parts else None


def _named(name: str) -> Iterator[Path]:
    """Yield the file of a module of ours, and what its packages run when it is imported."""
    place = _place(name)
    if place is None:
        return
    own = [path for path in (place.with_suffix(".py"), place / "__init__.py") if path.is_file()]
    yield from own
    if own:
        packages = [path for path in place.parents if path != ROOT and path.is_relative_to(ROOT)]
        yield from (path / "__init__.py" for path in packages if (path / "__init__.py").is_file())


@cache
def _imported(text: str) -> tuple[Path, ...]:
    """Return the files of ours that the text of a module imports, wherever in it."""
    names: list[str] = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            # What is imported from a package can be one of its modules.
            names += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return tuple(path for name in names for path in _named(name))


def _compiled_in(folder: Path) -> Iterator[Path]:
    """Yield the compiled files of a folder, and of its folders that are no packages."""
    for path in folder.iterdir():
        if path.suffix in _COMPILED:
            yield path
        elif path.is_dir() and path.name != "tests" and not (path / "__init__.py").exists():
            yield from _compiled_in(path)


@dataclass(frozen=True)
class Validity:
    """What a result is valid for. ``environment_hash``: of the `Sources` that it comes from."""

    rtl_hash: str
    environment_hash: str
    verilator: str

    @property
    def key(self) -> str:
        """Return a short name of all three together."""
        return content_hash((), self.rtl_hash, self.environment_hash, self.verilator)[:16]


@dataclass(frozen=True)
class Provenance(Validity):
    """What a result is valid for, and the commit that was checked out; None where this is no checkout."""

    git_commit: str | None
    git_clean: bool | None

    def still_holds(self, sources: Sources) -> bool:
        """Return whether all that it is valid for is as it was; a commit changes nothing of that."""
        return validity(sources).key == self.key


def validity(sources: Sources, dut: Path = DUT) -> Validity:
    """Return what a result of ``sources`` on this RTL is valid for, as both stand now."""
    return Validity(rtl_hash(dut), sources.hash(), str(verilator()))


def provenance(sources: Sources, dut: Path = DUT) -> Provenance:
    """Return the same with the commit: to be taken before the first run."""
    return Provenance(
        **vars(validity(sources, dut)), git_commit=git("rev-parse", "HEAD"), git_clean=_is_clean(sources)
    )


def _is_clean(sources: Sources) -> bool | None:
    """Return whether what is checked out is the commit; None where this is no checkout.

    Of the files that results come from that is asked file by file: git does not look at what its index, or
    a file of ignored names, tells it to pass over.
    """
    changed = git("status", "--porcelain", "--untracked-files=all")
    if changed is None:
        return None
    places = [path.relative_to(ROOT).as_posix() for path in (*rtl_files(), *sources.files())]
    found = git("hash-object", "--no-filters", "--", *places) or ""
    kept = {place: entry.split()[2] for entry, place in _entries(git("ls-tree", "-r", "-z", "HEAD") or "")}
    return not changed and [kept.get(place) for place in places] == found.split()


def _entries(listing: str) -> Iterator[list[str]]:
    return (line.split("\t", 1) for line in listing.split("\0") if line)


_State = dict[Path, tuple[int, int] | None]


@dataclass(frozen=True)
class Standing:
    """What a run is of, taken before anything of it runs. ``valid_for``: what its result is valid for."""

    valid_for: Provenance
    _sources: Sources
    _dut: Path
    _state: _State

    @property
    def stands(self) -> bool:
        """Return whether none of its files was written to since, and none is new or gone."""
        return _state(self._sources, self._dut) == self._state

    def check(self) -> None:
        """Raise InputError where it does not stand."""
        if not self.stands:
            raise InputError("the RTL, or its environment, was written to during the run: run again")


def standing(sources: Sources, dut: Path = DUT) -> Standing:
    """Return how the files of ``sources``, and the RTL, stand now."""
    # First: what is written to while it is hashed is another afterwards.
    state = _state(sources, dut)
    return Standing(provenance(sources, dut), sources, dut, state)


def _state(sources: Sources, dut: Path) -> _State:
    files = [*rtl_files(dut), *sources.files()]
    return dict(zip(files, written(files), strict=True))


def git(*arguments: str) -> str | None:
    """Return what git answers of this checkout, whatever its variables name; None where it is none."""
    others = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    try:
        answer = subprocess.run(
            ["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=False, env=others
        )
    except FileNotFoundError:
        return None
    return answer.stdout.strip() if answer.returncode == 0 else None
