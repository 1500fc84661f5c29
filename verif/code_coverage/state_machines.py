"""State machines of the RTL, and the cover properties that count their states and arcs.

A state machine is a register of an enumerated type whose name ends in ``state_q``. Its arcs are no list of
ours: they are all steps to another state that the module's logic can take, for any inputs and any values of
its other registers, and a SAT solver finds them (yosys). An arc that the module's surroundings rule out is a
bin like any other, until a waiver says why.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pyslang

from triaxis.coverage.code_counters import STATES
from triaxis.golden.errors import InputError
from triaxis.sim.build import built
from triaxis.sim.paths import BUILD, DUT
from triaxis.sim.programs import read_slang, yosys_version
from triaxis.verif.formal.netlist import flat, run_yosys
from triaxis.verif.testbench.assertions import nodes

_REGISTER = re.compile(r"(\w+_)?state_q")
# Nothing is an output but the register, so that its net has no other name; reset never comes; registers
# become inputs and outputs; all solutions are asked for.
_ARCS = (
    "{reading}; proc; flatten; memory_map; setattr -set keep 1 */{register}; delete -output o:*; "
    "opt_clean -purge; delete -input */rst_ni; setundef -undriven -one; "
    "opt -full -nodffe -nosdff; dffunmap; opt -fast -nodffe -nosdff; expose -evert-dff; delete t:$dff; "
    "sat -all -show {register}.q,{register}.d; tee -o done.txt ls"
)
_STEP = re.compile(r"^ +\\\w*state_q\.([qd]) +(\d+) ", re.MULTILINE)


@dataclass(frozen=True)
class StateMachine:
    """A register of a module, and its states in the order of their numbers."""

    module: str
    source: Path
    register: str
    states: tuple[str, ...]

    @property
    def name(self) -> str:
        """Return the name of the module that counts its states and arcs."""
        return f"{self.module}{STATES}"

    def arcs(self, sources: Sequence[Path]) -> list[tuple[str, str]]:
        """Return each step to another state that the module's logic can take.

        ``sources``: the RTL of the module and of all in it. Raises InputError where yosys finds none, or a
        step from a state to a value that is none.
        """
        names = [source.relative_to(DUT).as_posix() for source in sources if source.is_relative_to(DUT)]
        script = _ARCS.format(reading=read_slang(flat(names), self.module, {}), register=self.register)

        def ask(folder: Path) -> None:
            run_yosys(script, DUT, names, folder, "done.txt")

        place, files = BUILD / "elaborated" / f"{self.module}_{self.register}", [DUT / name for name in names]
        log = built(place, files, (script, yosys_version()), ask) / "yosys.log"
        shown = _STEP.findall(log.read_text(encoding="utf-8"))
        models = [dict(pair) for pair in zip(shown[::2], shown[1::2], strict=True)]
        steps = sorted({(int(model["q"]), int(model["d"])) for model in models})
        known = range(len(self.states))
        lost = [step for step in steps if step[0] in known and step[1] not in known]
        if lost or not steps:
            what = (
                f"leads from {self.states[lost[0][0]]} to {lost[0][1]}, no state" if lost else "never moves"
            )
            raise InputError(f"{self.source}: {self.register} {what} (log: {log})")
        return [(self.states[a], self.states[b]) for a, b in steps if a != b and a in known]


def state_machines(sources: Iterable[Path]) -> list[StateMachine]:
    """Return the state machines of modules, whose types are their own or of a package among the sources."""
    trees = {path: pyslang.syntax.SyntaxTree.fromFile(str(path)) for path in sources if path.suffix == ".sv"}
    shared: dict[str, tuple[str, ...]] = {}
    for tree in trees.values():
        for package in nodes(tree.root, pyslang.syntax.ModuleDeclarationSyntax):
            if package.kind is pyslang.syntax.SyntaxKind.PackageDeclaration:
                shared |= _types(package)
    return [
        StateMachine(module.header.name.valueText, path, name, {**shared, **_types(module)}[kind])
        for path, tree in trees.items()
        for module in nodes(tree.root, pyslang.syntax.ModuleDeclarationSyntax)
        for kind, name in _variables(module)
        if _REGISTER.fullmatch(name)
    ]


def _types(scope: pyslang.syntax.ModuleDeclarationSyntax) -> dict[str, tuple[str, ...]]:
    """Return the enumerated types that a module or a package declares, each with its states."""
    found: dict[str, tuple[str, ...]] = {}
    for one in nodes(scope, pyslang.syntax.TypedefDeclarationSyntax):
        if isinstance(one.type, pyslang.syntax.EnumTypeSyntax):
            members = nodes(one.type, pyslang.syntax.DeclaratorSyntax)
            found[one.name.valueText] = tuple(member.name.valueText for member in members)
    return found


def _variables(module: pyslang.syntax.ModuleDeclarationSyntax) -> list[tuple[str, str]]:
    """Return the variables of named types that a module declares: type and name of each."""
    return [
        # Its last word: before its first stand comments, too.
        (one.type.getLastToken().valueText, declared.name.valueText)
        for one in nodes(module, pyslang.syntax.DataDeclarationSyntax)
        if isinstance(one.type, pyslang.syntax.NamedTypeSyntax)
        for declared in nodes(one, pyslang.syntax.DeclaratorSyntax)
    ]


def covers(machine: StateMachine, arcs: Iterable[tuple[str, str]]) -> str:
    """Return a module, bound to a state machine's, with a cover property for each state and each arc."""
    bits = (len(machine.states) - 1).bit_length()
    number = {state: place for place, state in enumerate(machine.states)}
    always = "cover property (@(posedge clk_i) disable iff (!rst_ni) "
    states = [f"  {state} : {always}state == {number[state]});" for state in machine.states]
    steps = [f"  {a}_to_{b} : {always}$past(state) == {number[a]} && state == {number[b]});" for a, b in arcs]
    return "\n".join([
        f"module {machine.name} (input logic clk_i, input logic rst_ni, input logic [{bits - 1}:0] state);",
        *states, *steps, "endmodule",
        f"bind {machine.module} {machine.name} u_states (.clk_i, .rst_ni, .state({machine.register}));", "",
    ])  # fmt: skip
