"""Code coverage: every bit and block has its counter, and the result says what is missed."""

import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from triaxis.coverage.code_counters import (
    FIRST_LINE,
    LAST_LINE,
    Counters,
    add_files,
    read_counters,
    read_lines,
)
from triaxis.coverage.code_coverage import Assessment, Bin, Total, generate_blocks
from triaxis.coverage.elaboration import Instance, read_elaboration
from triaxis.coverage.waivers import KINDS, Waiver
from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.host.tests.published import read_published
from triaxis.sim.build import run_tool
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import CorePlayer
from triaxis.sim.models import BOARD_SVA, CORE_SVA, MESH_SVA, assertions, core_build
from triaxis.sim.paths import board_sources, mesh_sources, rtl_sources
from triaxis.sim.validity import Provenance
from triaxis.sim.verilate import QUICK, compiler, described, library, runtime
from triaxis.verif.code_coverage import run as measuring
from triaxis.verif.code_coverage.run import (
    BOARDS,
    CORES,
    ENGINES,
    CodeCoverage,
    Run,
    asserted_in,
    covered,
    unbound,
    write_json,
)
from triaxis.verif.commands import coverage as command
from triaxis.verif.testbench.simulation import RunResult, run_settings

# Quick to build: its counters are shown to count here, not its coverage.
SMALL = Configuration(8, 0, tag_bits=1, edge_box=False)
TOP = "TOP.triaxis_core"


def counted(pairs: list[np.ndarray], tmp_path: Path) -> Counters:
    """Return what one pair after the other makes a core count."""
    core = CorePlayer(library(covered(SMALL)))
    none, always = np.zeros(len(pairs), np.int64), np.zeros(0, np.uint16)
    core.run(1)
    core.set_reset(False)
    core.start(np.stack(pairs), none, none, always, 100)
    core.run(100)
    core.run(100)
    core.write_coverage(tmp_path / "coverage.dat")
    return read_counters(tmp_path / "coverage.dat")


@pytest.mark.regress
@pytest.mark.simulator
def test_bits_are_counted_each_by_itself_and_from_the_first_pair_on(tmp_path: Path) -> None:
    still = np.zeros((2, 3, 3), np.int64)
    moved = still.copy()
    moved[0, 1, 0] = 1 << 4  # The fourth coordinate: bit 3 * 8 + 4 of TDATA.
    # Verilator's own counting takes a change of bit b for one of b + 32, b + 64, .. as well.
    toggles = counted([still, moved, still], tmp_path).toggles
    data = {bit: toggles[TOP, f"s_axis_tdata_i[{bit}]"] for bit in range(18 * 8)}
    assert {bit for bit, t in data.items() if t.rises or t.falls} == {28}
    assert (data[28].rises, data[28].falls) == (1, 1)
    # A constant 1 rises from the simulator's initial 0, once: no coverage.
    toggles = counted([still], tmp_path).toggles
    assert toggles[TOP, "rst_ni"].falls == 0
    zero = toggles[f"{TOP}.u_datapath.u_flags", "det_zero_d[9]"]
    assert (zero.rises, zero.falls) == (0, 0)


def test_counters_of_two_builds_are_not_added(tmp_path: Path) -> None:
    for name, bins in (("a", ("C 'x' 1", "C 'y' 2")), ("b", ("C 'x' 3", "C 'y' 4")), ("c", ("C 'x' 3",))):
        (tmp_path / name).write_text("\n".join([FIRST_LINE, *bins, LAST_LINE]) + "\n")
    add_files([tmp_path / "a", tmp_path / "b"], tmp_path / "total")
    assert read_lines(tmp_path / "total") == ["C 'x' 4", "C 'y' 6"]
    with pytest.raises(InputError, match="counters of two builds"):
        add_files([tmp_path / "a", tmp_path / "c"], tmp_path / "total")


@pytest.mark.long
@pytest.mark.simulator
def test_the_models_elaborate_every_generate_block_and_every_assertion() -> None:
    models = [covered(one) for one in (*CORES, None, *ENGINES, *BOARDS)]
    designs = [read_elaboration(described(model), model.top) for model in models]
    found = {(one.module, label) for design in designs for one in design.values() for label in one.blocks}
    rules = [path for folder in (CORE_SVA, MESH_SVA, BOARD_SVA) for path in assertions(folder)]
    assert unbound(rules, set().union(*map(asserted_in, designs))) == []
    blocks = generate_blocks([*rtl_sources(), *mesh_sources(), *board_sources()])
    missing = {block.label for block in blocks if (block.module, block.label) not in found}
    of_engine = {"g_bad_powers", "g_bad_sizes", "g_bad_range", "g_bad_cycles"}
    of_board = {"g_bad_rate", "g_bad_depth", "g_bad_hold", "g_bad_watchdog"}
    assert missing == {"g_bad_tag", "g_bad_w", "g_bad_m", "g_bad_edge_box"} | of_engine | of_board


def coverage(assessment: Assessment, **changes: int) -> CodeCoverage:
    run = replace(Run("w16_m0", "MixedTest", 9, 0, 1.0), **changes)
    waiver = Waiver(1, "bounded", "because", "toggle", ("m",), signals=("s",))
    read = replace(waiver, reviewed=waiver.hashes({}))
    valid_for = Provenance("a" * 64, "b" * 64, "5.048", None, None)
    return CodeCoverage([run], assessment, [read], 2.0, valid_for)


def all_hit() -> Assessment:
    return Assessment({("a.sv", kind): Total(9, 1, 10) for kind in KINDS}, waived={1: 1})


def hole() -> Bin:
    return Bin("w16_m0", "toggle", "a.sv", 3, "x[1]:0->1", TOP)


CHANGED = "the RTL, or its environment, changed during the run"
HOLE = "a.sv:3: toggle x[1]:0->1, TOP.triaxis_core, w16_m0"


@pytest.mark.parametrize(
    ("found", "problem", "said"),
    [
        (coverage(all_hit()), None, "PASSED"),
        (coverage(all_hit(), wrong=2), "w16_m0: MixedTest: 2 of 9 wrong", "2 of 9 wrong"),
        (coverage(all_hit(), checked=0), "w16_m0: MixedTest: nothing was checked", "nothing was checked"),
        (coverage(replace(all_hit(), uncovered=[hole()] * 50)), None, HOLE),
        (coverage(replace(all_hit(), problems=["a waiver"])), "a waiver", "a waiver"),
        (
            replace(coverage(all_hit()), changed=True),
            CHANGED,
            "changed during",
        ),
    ],
)
def test_the_result_is_written_and_the_exit_code_says_the_same(
    found: Any, problem: str | None, said: str, monkeypatch: Any, tmp_path: Path, capsys: Any
) -> None:
    path, passed = tmp_path / "coverage" / "code.json", said == "PASSED"
    monkeypatch.setattr(command, "measure", lambda *_, **__: found)
    monkeypatch.setattr(command, "write_json", lambda *_, **__: write_json(found, 5, path))
    assert main(["coverage", "code"]) == (0 if passed else 1)
    out = capsys.readouterr().out
    assert said in out and ("PASSED" in out) is passed
    content = read_published(path, "evidence")
    assert content["passed"] is found.passed is passed
    assert content["problems"] == ([problem] if problem else [])
    assert content["totals"]["toggle"] == {"hit": 9, "waived": 1, "total": 10, "percent": 100.0}
    assert content["files"]["a.sv"]["line"]["total"] == 10
    assert content["waivers"][0]["bins"] == 1 and content["seed"] == 5
    assert main(["coverage", "code", "--pairs=0"]) == 2


@pytest.mark.parametrize(("passed", "counts"), [(False, {"checked": 9, "failed": 1}), (True, None)])
def test_a_test_that_fails_or_counts_nothing_ends_it(monkeypatch, passed, counts) -> None:
    came = RunResult(run_settings("FarTest", "w8_m0", 1, 9), passed, 1.0, counts, (), Path("log"))
    monkeypatch.setattr(measuring, "run", lambda *_, **__: came)
    monkeypatch.setattr(measuring, "library", lambda _: Path())
    with pytest.raises(InputError, match="code coverage: FAILED FarTest"):
        measuring._Test(core_build(SMALL), "FarTest", 9, 1).run()


RULES = """
module held_sva (input logic clk_i, a, b);
  Held : assert property (@(posedge clk_i) a |=> b);
  Never : assert property (@(posedge clk_i) !(a && b));
endmodule
module {module} (input logic clk_i, a);
  Always : assert property (@(posedge clk_i) a);
endmodule
bind left held_sva u_sva (.clk_i, .a, .b);
bind right held_sva u_sva (.clk_i, .a, .b(1'b1));
bind left always_sva u_always_sva (.clk_i, .a);
"""


def test_an_assertion_that_is_bound_to_nothing_is_a_problem(tmp_path: Path) -> None:
    rules = tmp_path / "held_sva.sv"
    rules.write_text(RULES.format(module="always_sva"))

    def placed(module: str, inside: str, *labels: str) -> dict[str, Instance]:
        return {
            "TOP.top": Instance("TOP.top", "top"),
            f"TOP.top.g_block[0].u_{module}": Instance("", module),
            f"TOP.top.g_block[0].u_{module}.{inside}": Instance("", inside, named={*labels}),
        }

    left = asserted_in(placed("left", "held_sva", "Held", "Never"))
    right = asserted_in(placed("right", "held_sva", "Held", "Never"))
    always = asserted_in(placed("left", "always_sva", "Always"))
    assert unbound([rules], left | right | always) == []
    # One without a left side has no counter that would be missed.
    (said,) = unbound([rules], left | right)
    assert said == "held_sva.sv: always_sva.Always is in left in none of the models: is it bound there?"
    # Nor has one that is bound elsewhere, too.
    told = unbound([rules], left | always)
    assert told == [
        f"held_sva.sv: held_sva.{label} is in right in none of the models: is it bound there?"
        for label in ("Held", "Never")
    ]
    assert len(unbound([rules], left | asserted_in(placed("right", "held_sva", "Held")) | always)) == 1
    other = tmp_path / "other_sva.sv"
    other.write_text(RULES.format(module="other_sva"))
    assert unbound([other], left | right) == ["other_sva: its assertions are bound to no module: bind it"]


def test_an_elaboration_that_is_damaged_or_of_another_module_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "tree.json"
    for text in ('{"modulesp": [], "miscsp": []}', '{"modulesp": ['):
        path.write_text(text)
        with pytest.raises(InputError, match="with a module top, or damaged"):
            read_elaboration(path, "top")
    with pytest.raises(InputError, match="none: cannot read: No such file or directory"):
        read_elaboration(path.with_name("none"), "top")


COUNTING = """
#include <array>
#include <cstdio>
#include "verilated.h"
#include "verilated_cov.h"
int main() {
  std::array<uint32_t, 200> counts{};
  VL_COV_TOGGLE_CHG_ST_I(3, counts.data(), 0xF5, 0xA0);
  VL_COV_TOGGLE_CHG_ST_Q(40, counts.data() + 6, 0, ~0ULL);
  const EData now[2] = {1u << 31, 0xFFFFFFFEu}, before[2] = {0, 0};
  VL_COV_TOGGLE_CHG_ST_W(34, counts.data() + 86, now, before);
  for (const uint32_t count : counts) std::putchar('0' + count);
}
"""


@pytest.mark.long
@pytest.mark.simulator
def test_bits_above_a_signals_width_are_no_bits_of_the_next_one(tmp_path: Path) -> None:
    source = tmp_path / "counting.cpp"
    source.write_text(COUNTING)
    build, program = covered(SMALL), tmp_path / "counting"
    run_tool(
        [*compiler(build, QUICK), str(source), str(runtime(build)), "-o", str(program)], tmp_path, "counting"
    )
    said = subprocess.run([program], capture_output=True, text=True, check=True).stdout
    # Falling, then rising, of each bit: 0 and 2 rose; 40 fell; 31 and 33 rose.
    narrow, middle = "010001", "10" * 40
    wide = "00" * 31 + "01" + "00" + "01"
    assert said == (narrow + middle + wide).ljust(200, "0")
