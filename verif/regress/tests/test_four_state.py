"""Unknown values are seen where they reach an output; what a two-state simulator takes for a number too."""

import json
from dataclasses import replace

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim import simulators
from triaxis.sim.simulators import ICARUS, compiled_for, icarus_installed
from triaxis.sim.validity import Validity
from triaxis.verif.core.tests.broken_rtl import broken_rtl
from triaxis.verif.regress.four_state import FourStateResult, plan, run_four_state, write_result
from triaxis.verif.testbench.settings import Block
from triaxis.verif.testbench.simulation import RunResult, program_of, run, run_settings
from triaxis.verif.testbench.unknown_values import unknown_file

HERE = Validity("a" * 64, "b" * 64, "5.048")
needs_icarus = pytest.mark.skipif(not icarus_installed(), reason="Icarus is not installed: iverilog")


def small_runs(folder, test="FarTest", pairs=60):
    return [run_settings(test, "w16_m0", 1, pairs, folder=folder / "run", simulator=ICARUS)]


@needs_icarus
@pytest.mark.simulator
@pytest.mark.prover
def test_nothing_is_unknown_in_the_core(tmp_path):
    result = run_four_state(1, lambda _: None, small_runs(tmp_path))
    assert result.problems == []
    assert (result.checked(Block.CORE), result.wrong, result.unknown) == (60, 0, 0)
    content = json.loads(write_result(result, "command", tmp_path / "four_state.json").read_text())
    assert content["passed"] and content["looked"] > 200


# Each right in two states, where what is not reset is 0 or any other number; and the test that sees it.
UNKNOWN = {
    "a counter that no reset reaches": (
        ("core/triaxis_core.sv", "      in_flight_q <= '0;\n      awake_q", "      awake_q"),
        "FarTest",
        "s_axis_tready_o is unknown",
    ),
    "claims of the boxes mixed with those of tests that never had operands": (
        (
            "core/triaxis_verdict.sv",
            "(separated_q[AxisNormalA-1:0] != '0) ? '0 :\n      separated_q[NumAxes-1:AxisNormalA] & "
            "-separated_q[NumAxes-1:AxisNormalA];",
            "(NumAxes - AxisNormalA)'((separated_q & -separated_q) >> AxisNormalA);",
        ),
        "FarTest",
        "m_axis_tdata_o is unknown",
    ),
    "a result that waits, overwritten where an enable is unknown": (
        (
            "core/triaxis_fifo.sv",
            "  always_ff @(posedge clk_i) begin\n    if (push_i) memory_q[write_q[PtrWidth-1:0]]",
            "  logic stray_q;\n  always_ff @(posedge clk_i) begin\n    if (pop_i) stray_q <= 1'b0;\n"
            "    if (push_i || stray_q)\n"
            "      memory_q[push_i ? write_q[PtrWidth-1:0] : read_q[PtrWidth-1:0]]",
        ),
        "StallsTest",
        "m_axis_tdata_o is unknown",
    ),
}


@needs_icarus
@pytest.mark.simulator
@pytest.mark.prover
@pytest.mark.parametrize(("change", "test", "message"), UNKNOWN.values(), ids=UNKNOWN)
def test_what_is_unknown_is_seen(tmp_path, change, test, message):
    result = run_four_state(1, lambda _: None, small_runs(tmp_path, test), broken_rtl(tmp_path, change))
    assert result.unknown > 0
    assert any(message in problem for problem in result.problems), result.problems


@needs_icarus
@pytest.mark.simulator
@pytest.mark.prover
@pytest.mark.parametrize("broken", [False, True])
def test_what_is_unknown_is_seen_on_the_board(tmp_path, broken):
    # It checks nothing, and is short; a register of the line without its reset.
    settings = run_settings(
        "BoardNothingTest", "board_w8_m0_d16_g4_l2", 1, 1, folder=tmp_path / "run", simulator=ICARUS
    )
    change = ("board/triaxis_uart_tx.sv", "      left_q  <= '0;\n", "")
    result = run_four_state(1, lambda _: None, [settings], broken_rtl(tmp_path, *[change][:broken]))
    assert result.looked > 30_000 and (result.unknown > 0) == broken
    assert ("uart_tx_o is unknown" in result.problems[0]) == broken


def test_a_run_that_sends_less_than_it_is_asked_for_is_a_problem(tmp_path):
    (settings,) = small_runs(tmp_path)
    unknown = unknown_file(tmp_path / "run")
    unknown.parent.mkdir()
    unknown.write_text('{"looked": 9, "unknown": 0}')
    for accepted, said in ((60, []), (30, ["FarTest in w16_m0: 30 of 60 pairs sent"])):
        counts = {"accepted": accepted, "checked": accepted, "failed": 0}
        ran = RunResult(settings, True, 1.0, counts, (), tmp_path / "log")
        assert FourStateResult((ran,), HERE, False, 1.0).problems == said
    # Nor do others hide one that looked at nothing.
    blind = replace(ran, settings=replace(settings, folder=str(tmp_path)))
    said = FourStateResult((ran, blind), HERE, False, 1.0).problems
    assert said[-1] == "FarTest in w16_m0: no output was looked at"
    assert FourStateResult((), HERE, False, 1.0).problems == ["nothing was run"]


def test_the_plan_has_every_test_of_resets_and_ten_thousand_pairs():
    runs = plan(1)
    assert {run.test for run in runs} >= {"ResetsTest", "MeshResetsTest"}
    assert max(run.pairs for run in runs if run.block is Block.CORE) >= 10_000
    assert {run.test for run in runs if run.block is Block.BOARD} == {"BoardSmokeTest", "BoardResetsTest"}
    assert len({run.folder for run in runs}) == len(runs)
    assert all("--simulator icarus" in run.replay_command for run in runs)
    assert all(("--agent pin" in run.replay_command) == (run.block is Block.BOARD) for run in runs)


def test_a_simulator_is_refused_in_a_line(tmp_path, monkeypatch):
    monkeypatch.setattr(simulators.shutil, "which", lambda _: None)
    build = program_of(small_runs(tmp_path)[0])
    with pytest.raises(InputError, match="install Icarus"):
        compiled_for(ICARUS, build)
    with pytest.raises(InputError, match="install Icarus"):
        run(small_runs(tmp_path)[0])
