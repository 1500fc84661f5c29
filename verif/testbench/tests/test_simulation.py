"""What a failed run tells: what went wrong, and not that nothing did; which command repeats it."""

from dataclasses import replace

import pytest

from triaxis.verif.testbench.simulation import errors_in, run_settings

SUMMARY = """\
 39.00ns INFO     reports.py(45) [RUN] RandomTest, seed 1
 39.00ns INFO     uvm_report_server.py(349) [uvm]: UVM_ERROR   :    {}
 39.00ns INFO     uvm_report_server.py(352) [uvm]: Quit count :     {} of UNLIMITED (UVM_ERROR)
"""


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", "struct.error: unpack requires a buffer of 51 bytes"),
        ("", "AssertionError: 5 pairs sent, 4 answered"),
        (" 39.00ns ERROR    scoreboard.py(158) [SCOREBOARD] pair 7: core says (1)\n", ""),
    ],
)
def test_a_run_that_failed_tells_its_error_and_not_a_count_of_none(tmp_path, before, after):
    log = tmp_path / "simulation.log"
    count = before.count("ERROR")
    log.write_text(f"{before}{SUMMARY.format(count, count)}{after}\n")
    assert errors_in(log) == (((before + after).strip(),), None)


def test_a_log_without_an_error_is_told(tmp_path):
    (tmp_path / "simulation.log").write_text(SUMMARY.format(0, 0))
    assert errors_in(tmp_path / "simulation.log")[0] == (
        "no error line in the log: the simulator ended early",
    )


def test_the_command_that_repeats_a_replay_names_all_that_it_was_run_with():
    ran = run_settings("ReplayTest", "w16_m0", 7, 1, "pairs.npz", agent="burst", judged_one_in=9)
    again = ".venv/bin/triaxis sim ReplayTest --seed 7 --config w16_m0 --replay pairs.npz"
    assert ran.replay_command == f"{again} --agent burst --judged 9"
    # What another test has kept is sent by that one alone.
    kept = run_settings("TouchingTest", "w16_m0", 7, 1, "pairs.npz", simulator="icarus")
    assert kept.replay_command == f"{again} --simulator icarus"
    spaced = replace(kept, replay="my pairs.npz", simulator="verilator")
    assert spaced.replay_command.endswith("--replay 'my pairs.npz'")
