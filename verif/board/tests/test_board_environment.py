"""The board's environment: its tests pass; lies are seen."""

import pytest

from triaxis.sim.models import BOARD_SVA, assertions
from triaxis.sim.paths import DUT
from triaxis.verif.board.base_test import BOARD, REAL, SHIPPED
from triaxis.verif.core.tests.broken_rtl import broken_rtl
from triaxis.verif.testbench.assertions import assertion_names
from triaxis.verif.testbench.settings import BURST, PIN, Block
from triaxis.verif.testbench.simulation import run, run_settings
from triaxis.verif.testbench.table import names_of

pytestmark = [pytest.mark.simulator, pytest.mark.long]

SMALL = "board_w8_m0_d16_g4_l2"

# The tests whose monitor lies, or that check nothing, and what is said of each.
SAID = {
    "BoardGoTooMuchTest": "is due",
    "BoardBeyondTooMuchTest": "is due",
    "BoardGoLateTest": "is due",
    "BoardPinsLostTest": "is due",
    "BoardByteLostTest": "a reply that nothing asked for",
    "BoardOtherReplyTest": "bad CRC",
    "BoardReplyCutTest": "a reply does not end",
    "BoardReplyUnaskedTest": "a reply that nothing asked for",
    "BoardReplyLostTest": "is due",
    "BoardBeatLostTest": "the beat is",
    "BoardLitLateTest": "the displays begin",
    "BoardNothingTest": "nothing was checked",
}

# For each rule of sva/: RTL that breaks it, and a test that shows it.
BROKEN = (
    ("QuietInReset", "loader", "state_q <= Idle;\n    end", "state_q <= state_q;\n    end", "Resets"),
    ("LineIdleInReset", "uart_tx", "      left_q  <= '0;\n", "", "Resets"),
    ("NothingInReset", "runner", "      mode_q <= '0;\n      margins_q", "      margins_q", "Resets"),
    ("ForgottenByHello", "runner", "never = forget_i || ", "never = ", "Smoke"),
    ("ForgottenInReset", "safety", "part_q  <= '0;\n", "part_q  <= part_q;\n", "Resets"),
    ("StopInReset", "safety", "stop_q <= 1'b1;\n    end else", "stop_q <= stop_q;\n    end else", "Resets"),
    ("EmptyingHeld", "loader", "if (both_q && tready_i)", "if (both_q)", "Abort"),
    ("FrameHeld", "frame_rx", "if (release_i)", "if (over)", "Frames"),
    ("ByteTakenIsThere", "slip_tx", "ready_o = ready_i && (", "ready_o = (", "Smoke"),
    ("TrianglesTakenAtOnce", "judge", "busy_i ? CodeBusy : load_code", "load_code", "Full"),
    ("RunsTakenAtOnce", "judge", "busy_i ? CodeBusy : run_code", "run_code", "Full"),
    ("RepliesTakenAtOnce", "command", "if (full_i && reply_ready_i)", "if (full_i)", "Go"),
    ("OnlyWhatIsAcceptedIsDone", "command", "Act && good_q && code_q == CodeOk", "Act", "Refusals"),
    ("NothingChangesDuringRuns", "judge", "busy_i ? CodeBusy : load_code", "load_code", "Full"),
    ("ForgetsAtRest", "command", "state_q == HelloEnd && load_done", "state_q == HelloEnd", "Abort"),
    ("ForgetsMeshes", "loader", "emptied = both_q && mesh_q", "emptied = both_q", "Smoke"),
    ("FreesWhatWasAsked", "reply", "number_q <= first_pair_i;", "number_q <= first_pair_i + 32'd1;", "Smoke"),
    ("RingBounded", "near_ring", "freed_q <= number_i;", "freed_q <= number_i + 32'd1;", "Smoke"),
    ("Antivalent", "safety", "stop_q <= !go_d;", "stop_q <= !go_q;", "Smoke"),
    ("GoEnds", "safety", "clear)) && !changed && !fault", "clear)) && !changed", "Go"),
    ("GoEndsWithARun", "safety", "!late && !done_i) ||", "!late) ||", "Hold"),
    ("GoEndsInTime", "safety", "left_q  <= hold_i;", "left_q  <= hold_i + hold_t'(1);", "Hold"),
    (
        # A run that begins moves the deadline: at rest go is not late, which another rule would tell.
        "GoEndsInTimeOfTheLast", "safety", "    end else if (last) begin\n",
        "    end else if (run_i) begin\n      left_q <= left_q + hold_t'(2);\n    end else if (last) begin\n",
        "Hold",
    ),
    ("FaultEndsGo", "safety", " || !alive_i || fault_i", " || !alive_i", "Trials"),
    ("FaultStands", "top", " || (board_fault_q && !hello)", "", "Trials"),
    ("NoFalseAlarm", "frame_rx", "{^data_i, data_i}", "{|data_i, data_i}", "Smoke"),
    (
        "RunnerShowsAll", "runner", "    waiting_q,\n    aborting_q,", "    aborting_q,\n    waiting_q,",
        "Smoke",
    ),
    ("RunnerMisreadAsAsked", "top", "trying_runner && 5'(i % 31) == trial.which", "trying_runner", "Trials"),
    (
        "FrameTriedAsAsked", "top", "TrialBoard && trial.which == '1", "TrialBoard && trial.which == '0",
        "Trials",
    ),
    ("BeyondOnlyWithGo", "safety", "beyond_o <= go_d ? ~zones_d : '0", "beyond_o <= ~zones_d", "Smoke"),
    ("BeatOnlyWithGo", "beat", "    else if (!go_i) beat_q <= 1'b0;\n", "", "Go"),
)  # fmt: skip

# Those that press the button.
PRESSED = (
    "BoardGoTest",
    "BoardHoldTest",
    "BoardFullTest",
    "BoardSilenceTest",
    "BoardResetsTest",
    "BoardMixedTest",
    "BoardTrialsTest",
)


# Those that take a minute, which each sign-off runs.
SLOW = ("BoardFullTest", "BoardTrialsTest")


def rtl_of(module):
    return "board/nexys4ddr_top.sv" if module == "top" else f"board/triaxis_{module}.sv"


def simulated(folder, test, seed):
    return run(run_settings(test, BOARD, seed, 60, folder=folder, agent=BURST))


@pytest.mark.parametrize(
    "test",
    [
        pytest.param(name, marks=pytest.mark.regress) if name in SLOW else name
        for name in names_of(Block.BOARD)
    ],
)
def test_passes(tmp_path, seed, test):
    result = simulated(tmp_path / "run", test, seed)
    assert result.passed and result.counts, result.explain()
    assert result.counts["runs"] and result.counts["gos"]
    assert (result.counts["resets"] > 1) == (test in PRESSED)


@pytest.mark.regress
@pytest.mark.parametrize("late", [False, True])
def test_the_pins_say_what_the_library_says(tmp_path, seed, late):
    # Go a clock late, which breaks no rule of sva/: the scoreboard sees it.
    right = "  assign go_d = ((go_q && !late && !done_i) || (armed_q && clear)) && !changed && !fault;"
    wrong = (
        "  logic late_q;\n  always_ff @(posedge clk_i) late_q <= armed_q && clear;\n"
        "  assign go_d = ((go_q && !late && !done_i) || late_q) && !changed && !fault;"
    )
    change = ("board/triaxis_safety.sv", right, wrong)
    dut = broken_rtl(tmp_path, change) if late else DUT
    pins, library = (
        run(run_settings("BoardSmokeTest", SMALL, seed, 20, folder=tmp_path / agent, agent=agent), dut)
        for agent in (PIN, BURST)
    )
    assert pins.passed == library.passed == (not late), pins.explain()
    if late:
        assert "is due" in pins.errors[0], pins.errors
    else:
        # The same replies, runs and clocks.
        for count in ("checked", "runs", "gos", "resets", "clocks"):
            assert pins.counts and library.counts and pins.counts[count] == library.counts[count]


@pytest.mark.parametrize("name", SAID)
def test_a_lie_fails_the_test(tmp_path, seed, name):
    result = simulated(tmp_path / "run", name, seed)
    assert not result.passed
    log = result.log.read_text()
    assert SAID[name] in log, log[-3000:]


@pytest.mark.regress
@pytest.mark.parametrize(("rule", "module", "right", "wrong", "test"), BROKEN, ids=[one[0] for one in BROKEN])
def test_what_breaks_a_rule_is_told_by_it(tmp_path, seed, rule, module, right, wrong, test):
    settings = run_settings(f"Board{test}Test", BOARD, seed, 40, folder=tmp_path / "run", agent=BURST)
    result = run(settings, broken_rtl(tmp_path, (rtl_of(module), right, wrong)))
    assert not result.passed
    log = result.log.read_text()
    assert f"sva.{rule}:" in log
    # One that fails at every clock does not fill the disk.
    assert log.count("Assertion failed") < 2000


def test_every_rule_is_seen_broken(tmp_path):
    rules = [name.rpartition(".")[2] for path in assertions(BOARD_SVA) for name in assertion_names(path)]
    assert sorted(rules) == sorted(one[0] for one in BROKEN)
    for rule, module, right, wrong, _ in BROKEN:
        broken_rtl(tmp_path / rule, (rtl_of(module), right, wrong))


@pytest.mark.regress
@pytest.mark.parametrize(
    ("test", "config", "module", "right", "wrong"),
    [
        ("BoardDepthTest", SHIPPED, "mesh/triaxis_mesh_store.sv", ".write_address_i(index)",
         ".write_address_i(Depth == 4096 ? index & ~(1 << 11) : index)"),
        ("BoardSmokeTest", REAL, "board/triaxis_uart_rx.sv", "CountWidth = $clog2(ClocksPerThreeBits)",
         "CountWidth = ClocksPerThreeBits == 25 ? 4 : $clog2(ClocksPerThreeBits)"),
    ],
)  # fmt: skip
def test_what_is_wrong_as_the_board_ships_is_seen(tmp_path, seed, test, config, module, right, wrong):
    settings = run_settings(test, config, seed, 20, folder=tmp_path / "run", agent=BURST)
    result = run(settings, broken_rtl(tmp_path, (module, right, wrong)))
    assert not result.passed and not result.errors[0].startswith("no error line"), result.explain()
