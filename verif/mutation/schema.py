"""Copies of dut/: with one mutant, or with every run-time mutant; a number in a package selects one.

The number that the mutants are compared with follows at a clock edge: what depends on a public signal at once
is computed twice more in each clock, and it is half of the design.

Each host keeps its statement and gains a changed copy of it for each mutant, so a mutant is exactly what the
changed source would be: nothing is widened or made unsigned by standing in a larger expression.
"""

import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.build import rtl_files
from triaxis.verif.mutation.builds import temporary
from triaxis.verif.mutation.catalogue import Catalogue
from triaxis.verif.mutation.mutant import Edit, Mutant, applied
from triaxis.verif.mutation.statements import ALWAYS, ASSIGN, BYPASS, LATE, PORT, STUCK, Host
from triaxis.verif.mutation.targets import AnyTarget

# Unsized numbers would be extended in every comparison.
_SELECTED = "triaxis_mutant::active"
_NEVER = (1 << 32) - 1

SUPPORT = "triaxis_mutant.sv"
_SUPPORT = """\
// Written by verif/mutation/schema.py.

package triaxis_mutant;
  int unsigned selected  /*verilator public_flat_rw*/;
  int unsigned active;
endpackage

module triaxis_mutant_stage #(
    parameter type T = logic,
    parameter bit Comb = 1'b0,
    parameter int unsigned Bypass = 0,
    parameter int unsigned Late = 0,
    parameter int unsigned Stuck = 0
) (
    input logic clk_i,
    input T d_i,
    output T q_o
);
  T zero, stage_q, late_q;
  if (Comb) begin : g_wire
    logic unused_clk;
    assign unused_clk = clk_i;
    always_comb begin
      q_o = d_i;
      if (triaxis_mutant::active == Stuck) q_o = zero;
    end
  end else begin : g_reg
    always_ff @(posedge clk_i) begin
      stage_q <= d_i;
      late_q <= stage_q;
    end
    always_comb begin
      q_o = stage_q;
      if (triaxis_mutant::active == Bypass) q_o = d_i;
      if (triaxis_mutant::active == Late) q_o = late_q;
      if (triaxis_mutant::active == Stuck) q_o = zero;
    end
  end
endmodule
"""

# Where there is a clock, and where not: the top, to which it is bound.
_CLOCKED = """\

module triaxis_mutant_switch (
    input logic clk_i
);
  always_ff @(posedge clk_i) triaxis_mutant::active <= triaxis_mutant::selected;
endmodule

bind {} triaxis_mutant_switch u_mutant_switch (.clk_i({}));
"""
_COMBINATIONAL = """\

module triaxis_mutant_switch;
  always_comb triaxis_mutant::active = triaxis_mutant::selected;
endmodule

bind {} triaxis_mutant_switch u_mutant_switch ();
"""


def _body(source: str, host: Host, mutant: Mutant) -> str:
    """Return the host's body as the mutant has it."""
    start, end = host.body
    edit = mutant.edit
    return applied(source[start:end], [Edit(edit.start - start, edit.end - start, edit.text)])


def _selection(cases: Mapping[int, str], default: str) -> str:
    """Return a statement that is the selected one of the cases, else the default.

    The cases are consecutive numbers, so one comparison tells whether any is meant.
    """
    first = min(cases)
    numbered = "".join(f" {number}: {text}" for number, text in cases.items())
    return (
        f"if ({_SELECTED} - {first} < {len(cases)}) case ({_SELECTED}){numbered} default: ; endcase "
        f"else {default}"
    )


def _assignments(source: str, host: Host, target: str, numbers: Mapping[str, int], zero: str) -> str:
    cases: dict[int, str] = {}
    for mutant in host.mutants:
        value = zero if mutant.operator == STUCK else _value(source, host, mutant)
        cases[numbers[mutant.id]] = f"{target} = {value};"
    original = source[host.body[0] : host.body[1]] if host.kind == ASSIGN else host.target
    return f"always_comb {_selection(cases, f'{target} = {original};')}"


def _value(source: str, host: Host, mutant: Mutant) -> str:
    text = _body(source, host, mutant)
    # `.name` alone becomes `.name(other)`: the connection is the body.
    if host.kind == PORT and host.body == (host.start, host.end):
        return text[text.index("(") + 1 : text.rindex(")")]
    return text


def _edits(source: str, host: Host, numbers: Mapping[str, int]) -> list[Edit]:
    """Return the edits that make a host hold its mutants."""
    serial = host.start
    if host.kind == ASSIGN:
        zero = f"triaxis_zero_{serial}"
        declared = f"var type({host.target}) {zero}; "
        text = declared + _assignments(source, host, host.target, numbers, zero)
        return [Edit(host.start, host.end, text)]
    if host.kind == ALWAYS:
        start, end = host.body
        cases = {numbers[m.id]: f"begin {_body(source, host, m)} end" for m in host.mutants}
        return [Edit(start, end, f"begin {_selection(cases, f'begin {source[start:end]} end')} end")]
    if host.kind == PORT:
        return _port_edits(source, host, numbers)
    assert host.stage is not None
    # 0 selects no mutant, so a number that no mutant has must not be 0.
    number = dict.fromkeys((BYPASS, LATE, STUCK), _NEVER)
    number |= {mutant.operator: numbers[mutant.id] for mutant in host.mutants}
    register, value = host.stage.register, host.stage.value
    selected = ", ".join(
        f".{name}(32'd{number[operator]})"
        for name, operator in (("Bypass", BYPASS), ("Late", LATE), ("Stuck", STUCK))
    )
    text = (
        f"triaxis_mutant_stage #(.T(type({register})), .Comb(Comb), {selected}) u_{register}_stage "
        f"(.clk_i, .d_i({value}), .q_o({register}));"
    )
    return [Edit(host.start, host.end, text)]


def _port_edits(source: str, host: Host, numbers: Mapping[str, int]) -> list[Edit]:
    name = source[host.start + 1 : host.end].split("(")[0].strip()
    value = host.target
    # A bare number has no width of its own, which the port would give it.
    if value[0].isdigit() or value[0] == "'":
        chosen = value
        for mutant in host.mutants:
            chosen = f"({_SELECTED} == {numbers[mutant.id]}) ? {_value(source, host, mutant)} : {chosen}"
        return [Edit(host.start, host.end, f".{name}({chosen})")]
    signal, zero = f"triaxis_port_{host.start}", f"triaxis_zero_{host.start}"
    declared = f"var type({value}) {signal}, {zero}; {_assignments(source, host, signal, numbers, zero)} "
    return [Edit(host.anchor, host.anchor, declared), Edit(host.start, host.end, f".{name}({signal})")]


def schema(source: str, hosts: Sequence[Host], numbers: Mapping[str, int]) -> str:
    """Return the text of a file that holds the mutants of its hosts, under their numbers."""
    edits = [edit for host in hosts for edit in _edits(source, host, numbers)]
    # Declarations before the same instance, in any order, become one.
    inserted: dict[int, str] = {}
    for edit in edits:
        if edit.start == edit.end:
            inserted[edit.start] = inserted.get(edit.start, "") + edit.text
    replaced = [edit for edit in edits if edit.start != edit.end]
    return applied(source, [*replaced, *(Edit(at, at, text) for at, text in inserted.items())])


def copy_rtl(
    dut: Path, folder: Path, mutant: Mutant | None = None, guard: tuple[str, str] = ("", "")
) -> None:
    """Copy all that elaborates, with a mutant where there is one, and a text replaced in all files."""
    for source in rtl_files(dut):
        place = folder / source.relative_to(dut)
        place.parent.mkdir(parents=True, exist_ok=True)
        text = source.read_text()
        if mutant is not None and source == dut / mutant.file:
            text = applied(text, [mutant.edit])
        place.write_text(text.replace(*guard) if guard[0] else text)


@contextmanager
def mutated(dut: Path, mutant: Mutant) -> Iterator[Path]:
    """Provide a copy of dut/ with that one mutant in it."""
    with temporary() as folder:
        copy_rtl(dut, folder, mutant)
        _check_syntax(folder / mutant.file, mutant)
        yield folder


def _check_syntax(path: Path, mutant: Mutant) -> None:
    """Raise InputError where the mutant is no SystemVerilog: the generator's fault, not a mutant killed."""
    from pyslang.syntax import SyntaxTree

    if any(item.isError() for item in SyntaxTree.fromFile(str(path)).diagnostics):
        raise InputError(f"{mutant.id} ({mutant.place}): the changed text does not parse: {mutant.changed}")


def write_schema(
    catalogue: Catalogue, numbers: Mapping[str, int], dut: Path, folder: Path, target: AnyTarget
) -> Path:
    """Write the copy of dut/ that holds all run-time mutants of a target's files; others stay as they are.

    Returns the file that it needs besides.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    copy_rtl(dut, folder)
    for source in catalogue.sources:
        if target.mutates(source.name):
            text = schema(source.text, catalogue.hosts.get(source.name, ()), numbers)
            (folder / source.name).write_text(text)
    support = folder / SUPPORT
    switch = _COMBINATIONAL if target.combinational else _CLOCKED
    support.write_text(_SUPPORT + switch.format(target.build(dut).top, target.clock))
    return support
