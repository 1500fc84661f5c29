"""The board with all its registers and memories public."""

import re
from dataclasses import replace
from functools import cache

from triaxis.golden.outputs import write_whole
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.build import content_hash
from triaxis.sim.models import board_build
from triaxis.sim.paths import BUILD, DUT, SIM
from triaxis.sim.verilate import Build
from triaxis.verif.formal.cone import Hierarchy, hierarchy
from triaxis.verif.mutation.syntax import below, kind, module_name, read_source, span

FOLDER = BUILD / "upsets"
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
    """Return the module of a register, by its place from the top on."""
    _, top, path = register.split(".", 2)
    return _hierarchy().register(top, path).module


def _assigned(left: str) -> set[str]:
    """Return what stands on the left of an assignment: a name with indices, or several in braces."""
    parts = left.strip("{} \n").split(",") if left.startswith("{") else [left]
    return {match[0] for part in parts if (match := _NAME.search(part))}


def upset_build(parameters: BoardParameters) -> Build:
    """Return the build of the board; its player lists the registers and flips their bits."""
    lines = [
        f'public_flat_rw -module "{module}" -var "{name}"'
        for module, names in registers().items()
        for name in names
    ]
    text = "\n".join(["`verilator_config", *lines, ""])
    control = FOLDER / f"registers-{content_hash((), text)[:12]}.vlt"
    if not control.exists():
        write_whole(control, text)
    build = board_build(parameters)
    return replace(
        build, name=f"{build.name}_upsets", sources=(control, *build.sources),
        headers=(*build.headers, SIM / "registers.h"), defines={**build.defines, "UPSETS": 1},
    )  # fmt: skip
