"""The board with all its registers and memories public; with all measures against upsets, or without some."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from triaxis.golden.outputs import write_whole
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.build import content_hash
from triaxis.sim.configuration import CERTIFIED_TOP
from triaxis.sim.models import board_build
from triaxis.sim.paths import BUILD, DUT, SIM
from triaxis.sim.verilate import Build
from triaxis.verif.faults.faulty_rtl import patched_rtl
from triaxis.verif.formal.cone import Hierarchy, hierarchy
from triaxis.verif.mutation.syntax import below, kind, module_name, read_source, span

FOLDER = BUILD / "upsets"


@dataclass(frozen=True)
class Measure:
    """What is done against upsets; ``without`` is the change of the RTL that makes it look away.

    All registers are there without it, too: the same upsets can be tried.
    """

    name: str
    title: str

    @property
    def without(self) -> Path:
        """Return the diff that takes it away."""
        return Path(__file__).with_name("without") / f"{self.name}.patch"


# In the order in which they are added up, from nothing to all.
MEASURES = (
    Measure("outputs", "go and stop are decided apart, each by a watchdog of its own"),
    Measure("runners", "what a run is asked for and answers is kept twice"),
    Measure("walks", "each run is walked twice"),
    Measure("parity", "all that is kept of a mesh has parity"),
    Measure("scrub", "meshes are looked at again between runs"),
    Measure("intakes", "boxes are computed twice"),
    Measure("certificates", "each clear of the core is shown again"),
    Measure("frames", "frames have parity until they are gathered"),
)
_FILES = tuple(sorted(DUT.rglob("*.sv")))
_NAME = re.compile(r"[A-Za-z_]\w*")


def registers() -> dict[str, list[str]]:
    """Return the names of the registers and memories of each module: what is assigned at an edge."""
    found: dict[str, list[str]] = {}
    for path in _FILES:
        source = read_source(path, path.parent)
        for module in source.modules:
            start, end = span(module)
            names = {stage.register for stage in source.stages if start <= stage.start < end}
            for node in below(module):
                if kind(node) == "NonblockingAssignmentExpression":
                    names |= _assigned(source.of(node.left))
            if names:
                found[module_name(module)] = sorted(names)
    return found


@cache
def _hierarchy() -> Hierarchy:
    return hierarchy(_FILES)


def module_of(register: str) -> str:
    """Return the module of a register, by its place from the top on; the board has the certified core."""
    _, top, path = register.split(".", 2)
    return _hierarchy().register(top, path, CERTIFIED_TOP).module


def _assigned(left: str) -> set[str]:
    """Return what stands on the left of an assignment: a name with indices, or several in braces."""
    parts = left.strip("{} \n").split(",") if left.startswith("{") else [left]
    return {match[0] for part in parts if (match := _NAME.search(part))}


def without_measures(measures: Iterable[Measure]) -> Path:
    """Return a folder of the RTL in which these are taken away, made where needed."""
    patches = [measure.without for measure in measures]
    return patched_rtl(FOLDER / "without", patches) if patches else DUT


def upset_build(parameters: BoardParameters, without: Iterable[Measure] = ()) -> Build:
    """Return the build of the board; its player lists the registers and flips their bits."""
    without = tuple(without)
    lines = [
        f'public_flat_rw -module "{module}" -var "{name}"'
        for module, names in registers().items()
        for name in names
    ]
    text = "\n".join(["`verilator_config", *lines, ""])
    control = FOLDER / f"registers-{content_hash((), text)[:12]}.vlt"
    if not control.exists():
        write_whole(control, text)
    build = board_build(parameters, without_measures(without))
    left = "".join(f"_{measure.name}" for measure in without)
    return replace(
        build, name=f"{build.name}_upsets{left and f'_without{left}'}", sources=(control, *build.sources),
        headers=(*build.headers, SIM / "registers.h"), defines={**build.defines, "UPSETS": 1},
    )  # fmt: skip
