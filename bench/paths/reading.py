"""How many programs of a folder are read: of those that LinuxCNC's own interpreter completes.

A machine that has all that a program may ask for is made up: each tool with its length, all offsets, homes.
Each program is tried with it, with the same whose A, B and C turn, and without any machine file.
"""

import argparse
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from functools import partial
from pathlib import Path

from rich.table import Table

from triaxis.bench.harness import FOLDER, Findings, report
from triaxis.golden.errors import InputError
from triaxis.golden.processes import in_processes
from triaxis.host.cli.terminal import progress_bar
from triaxis.host.motion.kinematics import ROTARY, Axis
from triaxis.host.motion.machine import SYSTEMS, Machine, Tool
from triaxis.host.motion.program import read_program
from triaxis.host.motion.rs274 import completes, read_by_rs274
from triaxis.host.quantise import NOWHERE, vector
from triaxis.host.scenes import box
from triaxis.host.stl import StlMesh

RESULT = FOLDER / "programs.json"
SUFFIXES = frozenset((".ngc", ".nc", ".gcode", ".tap"))
# Of the programs that the interpreter completes, with it and by our own reader.
_DEMANDS = (("by_rs274", "with --reader rs274", 0.95), ("by_own", "by our own reader", 0.75))
# Seconds of the processor: what takes longer is taken for a loop without an end.
_LONGEST = 60
_LISTED = 12
_TOOL_NUMBER = re.compile(r"[Tt]\s*(\d{1,5})(?!\d)", re.ASCII)
# Why a program is refused, after where.
_REASON = re.compile(r".*?: (?:line \d+: )?(?:word '[^']*': )?([^;]*).*", re.ASCII | re.DOTALL)


@dataclass(frozen=True)
class Reading:
    """A program that the interpreter completes, and why our readers refuse it; "" where they accept it."""

    file: str
    by_rs274: str
    by_own: str


def machines(text: str) -> list[Machine]:
    """Return machines that a program may be for, with the tools that it names."""
    mesh = StlMesh(box((-3, -3, 0), (3, 3, 30)), Fraction(0))
    numbers = sorted({1, *map(int, _TOOL_NUMBER.findall(text))})
    tools = {
        number: Tool(number, mesh, "a tool", Fraction(50 + number % 50), Fraction(6)) for number in numbers
    }
    zeros = {name: vector(map(Fraction, (100 + 10 * k, 100, -200))) for k, name in enumerate(SYSTEMS)}
    mill = Machine(
        tools, zeros, {"G28": NOWHERE, "G30": NOWHERE}, tolerance=Fraction(1, 100), loaded=1,
        turn_tolerance=Fraction(1, 100),
    )  # fmt: skip
    turning = replace(mill, axes=tuple(Axis("table", letter, 1) for letter in ROTARY))
    return [mill, turning, Machine()]


def read(root: Path, path: Path) -> Reading | None:
    """Return what becomes of a program; None where the interpreter does not complete it, or moves nothing."""
    own, with_rs274 = list[str](), list[str]()
    made_up = machines(path.read_text(encoding="utf-8", errors="replace"))
    if not completes(path, made_up[0], _LONGEST):
        return None
    for readers, found in ((read_program, own), (read_by_rs274, with_rs274)):
        for machine in made_up:
            try:
                readers(path, NOWHERE, False, machine)
            except InputError as error:
                found.append(str(error))
            else:
                found[:] = [""]
                break
    return Reading(str(path.relative_to(root)), with_rs274[0], own[0])


def _refusals(title: str, found: Sequence[Reading], name: str) -> Table:
    """Return a table of the reasons for which a reader refuses programs, the most frequent first."""
    files: dict[str, list[str]] = {}
    for one in found:
        if told := getattr(one, name):
            files.setdefault(_REASON.sub(r"\1", told), []).append(one.file)
    table = Table(title, "programs", "as")
    for reason, of in sorted(files.items(), key=lambda entry: -len(entry[1]))[:_LISTED]:
        table.add_row(reason, str(len(of)), of[0])
    return table


def findings(found: Sequence[Reading], tried: int) -> Findings:
    """Return what is shown and written; ``tried``: files that were there."""
    counts = {name: sum(not getattr(one, name) for one in found) for name in ("by_rs274", "by_own")}
    problems = [
        f"{what}: {counts[name]} of {len(found)} accepted: fewer than {least:.0%}"
        for name, what, least in _DEMANDS
        if counts[name] < least * len(found)
    ]
    problems += ["none of the programs is completed by rs274: name another folder"] * (not found)
    tables = [_refusals(f"refused {what}", found, name) for name, what, _ in _DEMANDS]
    summary = (
        f"{len(found)} programs that rs274 completes, of {tried} files: {counts['by_rs274']} accepted with "
        f"it, {counts['by_own']} by our own reader"
    )
    content = {"files": tried, "completed": len(found), **counts, "programs": [asdict(one) for one in found]}
    return Findings("triaxis bench programs", summary, problems, content, tables)


def _measured(options: argparse.Namespace) -> Findings:
    root: Path = options.folder
    files = sorted(path for path in root.rglob("*") if path.suffix.lower() in SUFFIXES and path.is_file())
    if not files:
        raise InputError(f"{root}: no program there ({', '.join(sorted(SUFFIXES))}): name another folder")
    with progress_bar("programs", len(files)) as progress:
        found = in_processes(partial(read, root), files, lambda _: progress(1))
    return findings([one for one in found if one is not None], len(files))


def add_programs(parser: argparse.ArgumentParser) -> None:
    """Read all programs of a folder that LinuxCNC's interpreter completes (Debian: linuxcnc-uspace), with
    it and by our own reader, for a machine that has whatever they ask for, and say what is refused.
    """
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="with programs, also in folders of it")
    parser.set_defaults(run=lambda options: report(RESULT, lambda: _measured(options)))
