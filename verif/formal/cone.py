"""Which registers of dut/ the proofs look at: those in the cones of influence of what they assert.

For proofs by algebra these are the registers that the argument follows values through.

A register is a variable, or a member of a structure, that flip-flops or a memory hold, by its name in its
module: once for all instances, all elements of an array, all parameters. It is in a cone where any bit of any
of these is.

The cone is an upper bound of what a proof says: what it asserts depends on every register in it in some way,
and a wrong value may still satisfy it. What is in no cone, no proof can find wrong.
"""

import json
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from pyslang.syntax import SyntaxKind, SyntaxTree

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.sim.configuration import Configuration
from triaxis.sim.paths import DUT, board_sources, mesh_sources, rtl_sources
from triaxis.sim.programs import read_slang
from triaxis.verif.formal.netlist import flat, run_yosys

UNPROVED_FILE = Path(__file__).with_name("unproved.toml")
# What together has every register of dut/, whatever parameters leave out: the board with the mesh engine,
# the core with pieces that take no DSP block, and without margins, the first of these with certificates.
_WHOLE = (
    ("nexys4ddr_top", {}),
    *(
        (one.top, one.parameters)
        for one in (Configuration(20, 20), Configuration(gating=False), Configuration(20, 20, certified=True))
    ),
)
# yosys-slang names a flip-flop after what it holds, and yosys keeps that name whatever the cell becomes.
_DRIVER = "$driver$"
_MEMORIES = ("$mem_v2", "$memwr_v2")
_FLIP_FLOP = re.compile(r"\$(anyinit|\w*ff\w*)")


@dataclass(frozen=True, order=True)
class Register:
    """A register by its module and its name there, the blocks that it is declared in included."""

    module: str
    name: str


@dataclass(frozen=True)
class Hierarchy:
    """What the instances in each module can be of, as the sources say: a parameter may choose."""

    instances: Mapping[tuple[str, str], frozenset[str]]
    # Signals and blocks, each after its module.
    declared: frozenset[tuple[str, str]]

    def register(self, top: str, path: str, file: str = "") -> Register:
        """Return the register of a path from ``top``, such as ``u_core.u_delay[1].g_regs.stage_q[0]``.

        Where an instance can be of several modules, it is of the one that has what the path goes on with; of
        several such, of the one that is called as the ``file`` that writes the register. InputError where
        none is.
        """
        ways: list[tuple[str, tuple[str, ...]]] = [(top, ())]
        for name in re.sub(r"\[[^]]*\]", "", path).split("."):
            ways = [
                way
                for module, names in ways
                for way in (
                    [(below, ()) for below in self.instances.get((module, name), ())]
                    or [(module, (*names, name))]
                )
            ]
        deepest = min(len(names) for _, names in ways)
        found = {Register(module, ".".join(names)) for module, names in ways if len(names) == deepest}
        if len(found) > 1:
            found = {one for one in found if (one.module, one.name.split(".")[0]) in self.declared}
        if len(found) > 1:
            found = {one for one in found if one.module == Path(file).stem}
        if len(found) != 1:
            raise InputError(f"{top}: {path}: can be in several modules, none of them that of {file or '?'}")
        return found.pop()


def hierarchy(sources: Iterable[Path]) -> Hierarchy:
    """Return the hierarchy of some files."""
    found: dict[tuple[str, str], set[str]] = {}
    declared: set[tuple[str, str]] = set()
    known: set[str] = set()
    for path in sources:
        modules: list[str] = []

        def visit(node: Any, modules: list[str] = modules) -> None:
            kind = getattr(node, "kind", None)
            if kind == SyntaxKind.ModuleDeclaration:
                modules.append(node.header.name.valueText)
                known.add(modules[-1])
            elif kind == SyntaxKind.HierarchyInstantiation:
                of = node.type.valueText
                for instance in node.instances:
                    name = getattr(instance, "decl", None) and instance.decl.name.valueText
                    if name:
                        found.setdefault((modules[-1], name), set()).add(of)
            elif kind in (SyntaxKind.Declarator, SyntaxKind.NamedBlockClause) and modules:
                declared.add((modules[-1], node.name.valueText))

        SyntaxTree.fromFile(str(path)).root.visit(visit)
    # What none of the files has is not there: a parameter leaves it out.
    instances = {place: frozenset(of & known or of) for place, of in found.items()}
    return Hierarchy(instances, frozenset(declared))


@dataclass(frozen=True)
class _Net:
    """A module as yosys writes it, flat."""

    top: str
    module: Mapping[str, Any]
    hierarchy: Hierarchy

    @cached_property
    def _names(self) -> dict[Any, list[str]]:
        """Return the names of each net that sources gave."""
        found: dict[Any, list[str]] = {}
        for name, net in self.module["netnames"].items():
            for bit in net["bits"] if not net["hide_name"] else ():
                found.setdefault(bit, []).append(name)
        return found

    def registers(self, name: str) -> Iterator[Register]:
        """Yield what a cell holds; where it lost its name on the way, what is called as its output is."""
        cell = self.module["cells"][name]
        if cell["type"] in _MEMORIES:
            paths = {cell["parameters"]["MEMID"].removeprefix("\\")}
        elif name.startswith(_DRIVER):
            paths = {name.removeprefix(_DRIVER)}
        elif _FLIP_FLOP.fullmatch(cell["type"]):
            paths = {one for bit in cell["connections"]["Q"] for one in self._names.get(bit, ())}
        else:
            paths = set()
        file = cell["attributes"].get("src", "").split(":")[0]
        for path in paths:
            yield self.hierarchy.register(self.top, path, file)

    def cone(self) -> set[str]:
        """Return the cells on which the assertions depend, through any number of clocks."""
        cells = self.module["cells"]
        drivers: dict[Any, str] = {}
        for name, cell in cells.items():
            for port, bits in cell["connections"].items():
                if cell["port_directions"][port] == "output":
                    drivers.update(dict.fromkeys(bits, name))
        waiting = [name for name, cell in cells.items() if cell["type"] in ("$assert", "$check")]
        found = set(waiting)
        while waiting:
            cell = cells[waiting.pop()]
            for port, bits in cell["connections"].items():
                if cell["port_directions"][port] == "input":
                    new = {drivers[bit] for bit in bits if bit in drivers} - found
                    found |= new
                    waiting += new
        return found


def read_cone(path: Path, sources: Iterable[Path], top: str, own: frozenset[str]) -> frozenset[Register]:
    """Return the registers of the modules ``own`` in the cone of a netlist's assertions, as yosys wrote it.

    The netlist is what the solver is given: what yosys found constant or equal to something else, and what a
    proof cuts or replaces, is not there any more, and in no cone. Modules that stand in for others have files
    beside those of dut/, and are none of ``own``, whatever they are called.
    """
    modules = json.loads(path.read_text(encoding="utf-8"))["modules"]
    if set(modules) != {top}:
        raise InputError(f"{path}: holds {', '.join(modules)}: a cone is that of one flat module, {top}")
    net = _Net(top, modules[top], hierarchy(sources))
    return frozenset(one for name in net.cone() for one in net.registers(name) if one.module in own)


def of_cells(names: Iterable[str], top: str, dut: Path) -> frozenset[Register]:
    """Return the registers of cells of an elaborated netlist of dut/, by the names of the cells."""
    known = hierarchy(dut.glob("*/*.sv"))
    return frozenset(
        known.register(top, name.removeprefix(_DRIVER)) for name in names if name.startswith(_DRIVER)
    )


def all_registers(dut: Path, folder: Path) -> frozenset[Register]:
    """Return every register of dut/, as elaborated; ``folder`` takes netlists and a log."""
    files = [*rtl_sources(DUT), *mesh_sources(DUT), *board_sources(DUT)]
    names = [str(path.relative_to(DUT)) for path in files]
    script = "; ".join(
        f"{read_slang(flat(names), top, parameters)}; write_json whole_{number}.json; design -reset"
        for number, (top, parameters) in enumerate(_WHOLE)
    )
    run_yosys(script, dut, names, folder, f"whole_{len(_WHOLE) - 1}.json")
    known = hierarchy(folder / name for name in flat(names))
    own = {path.stem for path in dut.glob("*/*.sv")}
    found: set[Register] = set()
    for number, (top, _) in enumerate(_WHOLE):
        text = (folder / f"whole_{number}.json").read_text(encoding="utf-8")
        net = _Net(top, json.loads(text)["modules"][top], known)
        found |= {one for name in net.module["cells"] for one in net.registers(name) if one.module in own}
    return frozenset(found)


# --- What the proofs look at together -----------------------------------------------------------------


@dataclass(frozen=True)
class Covered:
    """Every register of dut/, those in the cone of a proof that holds, and why others are in none."""

    every: frozenset[Register]
    proved: frozenset[Register]
    reasons: Mapping[Register, str]

    @cached_property
    def outside(self) -> list[Register]:
        """Return the registers in no cone."""
        return sorted(one for one in self.every if self.proved.isdisjoint(_wholes(one)))

    @property
    def unexplained(self) -> list[Register]:
        """Return those in no cone that have no reason."""
        return [one for one in self.outside if one not in self.reasons]

    @property
    def problems(self) -> list[str]:
        """Return which reasons no longer apply, a line each."""
        return [
            f"{UNPROVED_FILE.name}: {one.module}: {one.name}: {why}: take it out"
            for one in sorted(set(self.reasons) - set(self.outside))
            for why in ["is in the cone of a proof" if one in self.every else "there is no such register"]
        ] + [
            f"{one.module}: {one.name}: only proofs have this register: elaborate it in cone.py as well"
            for one in sorted(self.proved - {whole for each in self.every for whole in _wholes(each)})
        ]

    @property
    def summary(self) -> str:
        """Return the result in a line."""
        inside, every = len(self.every) - len(self.outside), len(self.every)
        return (
            f"{inside} of {every} registers are in the cone of influence of a proof; of the others "
            f"{len(self.unexplained)} have no reason in {UNPROVED_FILE.name}"
        )

    @property
    def content(self) -> dict[str, object]:
        """Return the result as it stands in the file of all proofs."""
        by_module = by_modules(self.every)
        outside = by_modules(self.outside)
        return {
            "total": len(self.every),
            "covered": len(self.every) - len(self.outside),
            "unexplained": len(self.unexplained),
            "summary": self.summary,
            "modules": {
                module: {"total": len(names), "covered": len(names) - len(outside.get(module, ()))}
                for module, names in by_module.items()
            },
            "outside": [{**vars(one), "reason": self.reasons.get(one)} for one in self.outside],
        }


def _wholes(register: Register) -> set[Register]:
    """Return a member of a structure and what it is a member of, which a proof may have as a plain word."""
    names = register.name.split(".")
    return {Register(register.module, ".".join(names[:count])) for count in range(1, len(names) + 1)}


def by_modules(registers: Iterable[Register]) -> dict[str, list[str]]:
    """Return the names of registers by module, both in order."""
    found: dict[str, list[str]] = {}
    for one in sorted(registers):
        found.setdefault(one.module, []).append(one.name)
    return found


def read_unproved(path: Path = UNPROVED_FILE) -> dict[Register, str]:
    """Return the reason of each register that is listed; raise InputError where the file is wrong."""
    try:
        entries = tomllib.loads(read_input(path).decode())["unproved"]
        found = [
            (Register(module, name), str(entry["reason"]))
            for entry in entries
            for module, names in entry["registers"].items()
            for name in names
        ]
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: cannot be read: {error!r}") from error
    if len(dict(found)) != len(found):
        raise InputError(f"{path}: lists a register twice")
    return dict(found)
