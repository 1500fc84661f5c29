"""Broken cores are caught: each fault is put into a copy of the RTL, and the test that is to find it
must fail, say why, keep the failing pairs, and fail again when they are replayed.
"""

import re
import shutil
from dataclasses import dataclass

import numpy as np
import pytest

from triaxis.verif.configuration import parse_configuration
from triaxis.verif.paths import DUT
from triaxis.verif.simulation import run, run_settings


@dataclass(frozen=True)
class Fault:
    """A change of one RTL file, and the test that must see it by a message."""

    name: str
    file: str
    old: str
    new: str
    test: str
    message: str
    about_pairs: bool = True
    config: str = "w16_m0"


FAULTS = (
    Fault(
        "touching taken for clear", "triaxis_interval.sv",
        "assign above_d[i] = points[i] > ceiling;", "assign above_d[i] = points[i] >= ceiling;",
        "TouchingTest", "exact answer",
    ),
    Fault(
        "cross product one bit too narrow", "triaxis_cross.sv",
        "assign cross_d[k] = CrossWidth'(plus - minus);",
        "assign cross_d[k] = CrossWidth'($signed(plus[CrossWidth-2:0] - minus[CrossWidth-2:0]));",
        "ExtremesTest", "exact answer",
    ),
    Fault(
        "wrong edge in one axis", "triaxis_projections.sv",
        "assign far_d[2][j] = qf_3[j] - q_normal_3;", "assign far_d[2][j] = qf_3[j] - p_normal_3;",
        "RandomTest", "exact answer",
    ),
    Fault(
        "claims the last axis", "triaxis_verdict.sv",
        "for (int i = NumAxes - 1; i >= 0; i--)", "for (int i = 0; i < NumAxes; i++)",
        "RandomTest", "exact answer",
    ),
    Fault(
        "margin one clock late", "triaxis_box.sv",
        ".Cycles(Comb ? 0 : BoxLatency - 1)", ".Cycles(Comb ? 0 : BoxLatency)",
        "RandomTest", "exact answer", config="w16_m16",
    ),
    Fault(
        "operands move for decided pairs", "triaxis_boxes.sv",
        "assign open = valid && (!Gating || separated == '0);", "assign open = valid;",
        "FarTest", "an operand moved", about_pairs=False,
    ),
    Fault(
        "accepts more than the queue holds", "triaxis_core.sv",
        "(in_flight_q != count_t'(Depth))", "1'b1",
        "StallsTest", "in flight", about_pairs=False,
    ),
    Fault(
        "withdraws a waiting result", "triaxis_fifo.sv",
        "if (pop_i) read_q", "if (pop_i || (valid_o && read_q[3:0] == 4'd9)) read_q",
        "StallsTest", "a result changed while it waited", about_pairs=False,
    ),
    Fault(
        "margins move for decided pairs", "triaxis_boxes.sv",
        "        operand_margin_o <= margin;\n      end\n", "      end\n      operand_margin_o <= margin;\n",
        "FarTest", "a margin moved", about_pairs=False, config="w16_m16",
    ),
    Fault(
        "an eighth of the queue", "triaxis_core.sv",
        "2 ** $clog2(core_latency(W, M))", "2 ** $clog2(core_latency(W, M)) / 8",
        "RandomTest", "not ready although", about_pairs=False,
    ),
    Fault(
        "a clock too early", "triaxis_core.sv",
        "localparam int unsigned Latency = datapath_latency(W, M);",
        "localparam int unsigned Latency = datapath_latency(W, M) - 1;",
        "RandomTest", "a result is due and not there", about_pairs=False,
    ),
    Fault(
        "hangs", "triaxis_core.sv",
        "&& (in_flight_q != count_t'(Depth))",
        "&& (in_flight_q != count_t'(Depth)) && (tag != 16'd700)",
        "StallsTest", "the core hangs", about_pairs=False,
    ),
    Fault(
        "loses results now and then", "triaxis_core.sv",
        ".push_i (valid_q[Latency-1])", ".push_i (valid_q[Latency-1] && result.tag[6:0] != 7'd77)",
        "ResetsTest", "was due",
    ),
)  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_fault_is_caught(tmp_path, seed, fault):
    broken = tmp_path / "dut"
    shutil.copytree(DUT, broken)
    text = (broken / fault.file).read_text()
    assert text.count(fault.old) == 1, "the RTL has changed: adapt the fault"
    (broken / fault.file).write_text(text.replace(fault.old, fault.new))
    configuration = parse_configuration(fault.config)

    settings = run_settings(fault.test, configuration, seed, 1500, folder=tmp_path / "run")
    result = run(settings, dut=broken, shrink=False)
    assert not result.passed
    explanation = result.explain()
    assert fault.message in explanation, explanation
    replay = re.search(rf"replay: \.venv/bin/triaxis sim {fault.test} --seed {seed} --config", explanation)
    assert replay, explanation

    if fault.about_pairs:
        assert result.failing_pairs
        with np.load(result.failing_pairs) as file:
            assert file["pairs"].shape[1:] == (2, 3, 3)
            assert len(file["margins"]) == len(file["pairs"]) > 0
    if fault.message == "exact answer" and "late" not in fault.name:
        again = run_settings(
            "ReplayTest", configuration, seed, 1, str(result.failing_pairs), folder=tmp_path / "again"
        )
        assert not run(again, dut=broken, shrink=False).passed
        assert run(again).passed
