"""What a failed run tells of its log: what went wrong, and not that nothing did."""

import pytest

from triaxis.verif.testbench.simulation import errors_in

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
