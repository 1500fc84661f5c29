"""Mutants of the macro TRIAXIS_STAGE itself, the one register of all modules."""

from pathlib import Path

from triaxis.verif.mutation.mutant import ELABORATION, Edit, Mutant, named, normalised

FILE = "core/triaxis_stage.svh"
_NAME = "triaxis_stage"

# What in the macro's text gives way to what. The operators' names are those of statements.py.
_CHANGES = (
    ("generate_condition", "if (Comb)", "if (!(Comb))"),
    ("deletion", "assign q = d;", ""),
    ("deletion", "always_ff @(posedge clk_i) q <= d;", ""),
    ("edge", "posedge clk_i", "negedge clk_i"),
)


def macro_mutants(dut: Path) -> list[Mutant]:
    """Return the mutants of the macro, named. Each is there wherever the macro is used."""
    text = (dut / FILE).read_text()
    found: list[Mutant] = []
    for operator, old, new in _CHANGES:
        start = text.find(old)
        if start < 0:
            continue
        line = text.count("\n", 0, start) + 1
        edit = Edit(start, start + len(old), new)
        found.append(
            Mutant("", _NAME, operator, ELABORATION, FILE, line, normalised(old), new or ";", edit, start, -1)
        )
    return named(found)
