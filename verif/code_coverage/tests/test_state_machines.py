"""State machines: each is found, its arcs are those of its logic, and left sides of assertions fire."""

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.models import BOARD_SVA, CORE_SVA, MESH_SVA, assertions
from triaxis.sim.paths import board_sources, mesh_sources, rtl_sources
from triaxis.verif.code_coverage.state_machines import StateMachine, state_machines
from triaxis.verif.testbench.assertions import assertion_names, with_antecedents

SOURCES = [*rtl_sources(), *mesh_sources(), *board_sources()]


def machine(module: str) -> StateMachine:
    return next(one for one in state_machines(SOURCES) if one.module == f"triaxis_{module}")


def test_every_enumerated_state_is_a_state_machine() -> None:
    text = "".join(source.read_text() for source in SOURCES)
    found = state_machines(SOURCES)
    assert len(found) == text.count("} state_e;") + text.count("} run_state_e;") == 8
    assert machine("runner").states == ("RunNever", "RunGoing", "RunDone")


def test_a_comment_above_a_state_is_no_part_of_its_type(tmp_path) -> None:
    source = tmp_path / "a.sv"
    source.write_text(
        "module a; typedef enum logic {Idle, Busy} state_e;\n"
        "  // What it does.\n  state_e state_q;\nendmodule\n"
    )
    assert state_machines([source]) == [StateMachine("a", source, "state_q", ("Idle", "Busy"))]


@pytest.mark.prover
def test_arcs_are_all_steps_of_the_logic() -> None:
    # As one reads them.
    assert set(machine("slip_tx").arcs(SOURCES)) == {
        ("First", "Plain"), ("Plain", "Escaped"), ("Plain", "Last"), ("Escaped", "Plain"),
        ("Escaped", "Last"), ("Last", "First"),
    }  # fmt: skip
    control = machine("run_control")
    arcs = set(control.arcs(SOURCES))
    assert {a for a, b in arcs if b == "StateDrain"} == {
        "StateSettle", "StateCheck", "StateStart", "StateScan",
    }  # fmt: skip
    assert ("StateIdle", "StateSettle") in arcs and ("StateIdle", "StateScan") not in arcs
    # The same register, were it of seven states: it leads to an eighth.
    fewer = StateMachine(control.module, control.source, control.register, control.states[:-1])
    with pytest.raises(InputError, match="state_q leads from StateCheck to 7, no state"):
        fewer.arcs(SOURCES)


def test_each_left_side_of_an_assertion_has_a_cover_property() -> None:
    for path in (*assertions(CORE_SVA), *assertions(MESH_SVA), *assertions(BOARD_SVA)):
        text = with_antecedents(path)
        sides = text.count("|->") + text.count("|=>")
        assert text.count("Antecedent : cover property") == sides <= len(assertion_names(path))
        # No line moves.
        assert len(text.splitlines()) == len(path.read_text().splitlines())
