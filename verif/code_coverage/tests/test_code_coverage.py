import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from triaxis.coverage.code_counters import Counters, read_counters
from triaxis.coverage.code_coverage import (
    Assessment,
    Bin,
    ModelCoverage,
    Total,
    assess_model,
    generate_blocks,
)
from triaxis.coverage.elaboration import read_elaboration
from triaxis.coverage.waivers import KINDS, Waiver, module_hash, read_waivers
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.pairs import coordinate_range
from triaxis.host.cli import main
from triaxis.sim.build import run_tool
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import (
    DELIVERED,
    DISCARDED,
    OFFER,
    RESET,
    TAKE,
    CorePlayer,
    Sent,
    Steps,
    core_words,
)
from triaxis.sim.models import core_build
from triaxis.sim.paths import mesh_sources, rtl_sources
from triaxis.sim.verilate import COUNTERS, described, library, verilate_command
from triaxis.verif.code_coverage.run import (
    CORES,
    ENGINES,
    CodeCoverage,
    Run,
    covered,
    write_json,
)
from triaxis.verif.code_coverage.stimulus import pairs_with_margins, stimulus
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.stimulus.schedules import disturbed, flowing

# Quick to build: its counters are shown to count here, not its coverage.
SMALL = Configuration(8, 0, tag_bits=1, edge_box=False)
TOP = "TOP.triaxis_core"


@pytest.fixture
def core() -> CorePlayer:
    return CorePlayer(library(covered(SMALL)))


def one_by_one(pairs: list[np.ndarray], steps: Steps | None = None) -> Sent:
    none = np.zeros(len(pairs), np.int64)
    return core_words(np.stack(pairs), none, none, SMALL, flowing() if steps is None else steps)


def counted(core: CorePlayer, sent: Sent, tmp_path: Path) -> Counters:
    assert core.play(sent).symptom == ""
    core.write_coverage(tmp_path / "coverage.dat")
    return read_counters(tmp_path / "coverage.dat")


@pytest.mark.simulator
def test_bits_above_64_are_counted_each_by_itself(core: CorePlayer, tmp_path: Path) -> None:
    """Verilator's own counting takes a change of bit b for one of b + 32, b + 64, .. as well."""
    still = np.zeros((2, 3, 3), np.int64)
    moved = still.copy()
    moved[0, 1, 0] = 1 << 4  # The fourth coordinate: bit 3 * 8 + 4 of TDATA.
    toggles = counted(core, one_by_one([still, moved, still]), tmp_path).toggles
    data = {bit: toggles[TOP, f"s_axis_tdata_i[{bit}]"] for bit in range(18 * 8)}
    assert {bit for bit, t in data.items() if t.rises or t.falls} == {28}
    assert (data[28].rises, data[28].falls) == (1, 1)


@pytest.mark.simulator
def test_nothing_is_counted_before_the_first_pair(core: CorePlayer, tmp_path: Path) -> None:
    """A constant 1 rises from the simulator's initial 0, once: no coverage."""
    toggles = counted(core, one_by_one([np.zeros((2, 3, 3), np.int64)]), tmp_path).toggles
    assert toggles[TOP, "rst_ni"].falls == 0
    zero = toggles[f"{TOP}.u_datapath.u_flags", "det_zero_d[9]"]
    assert (zero.rises, zero.falls) == (0, 0)


def played(
    core: CorePlayer, rng: np.random.Generator, steps: Steps, tmp_path: Path, count: int = 300
) -> tuple[Counters, np.ndarray]:
    sent, pairs, margins = stimulus(rng, count, SMALL, steps)
    seen = core.play(sent)
    core.write_coverage(tmp_path / "coverage.dat")
    expected = expected_words(bulk_facts(pairs, margins), SMALL)
    delivered = seen.states == DELIVERED
    assert delivered.any() and ((seen.states == DISCARDED) | delivered).all()
    assert np.array_equal(seen.words[delivered], expected[delivered])
    return read_counters(tmp_path / "coverage.dat"), seen.states


def assess(counters: Counters) -> Assessment:
    model = covered(SMALL)
    instances = read_elaboration(described(model), model.top)
    return assess_model(ModelCoverage(model.name, counters, instances), read_waivers())


def protocol_holes(found: Assessment) -> set[str]:
    """Return the bins of the handshake and the queue's pointers that are not hit."""
    names = ("s_axis_t", "m_axis_tready", "rst_ni", "awake_q", "in_flight_q", "write_q", "read_q")
    return {
        bin_.what
        for bin_ in found.uncovered
        if bin_.file in ("triaxis_core.sv", "triaxis_fifo.sv") and any(name in bin_.what for name in names)
    }


@pytest.mark.simulator
def test_what_the_protocol_needs_is_covered_with_back_pressure_and_resets_alone(
    core: CorePlayer, rng: np.random.Generator, tmp_path: Path
) -> None:
    counters, _ = played(core, rng, flowing(), tmp_path)
    found = assess(counters)
    assert found.problems == []
    assert found.totals["toggle"].total == 2 * len(counters.toggles) > 10_000
    holes = protocol_holes(found)
    assert {"m_axis_tready_i:1->0", "rst_ni:1->0", "awake_q:1->0", "in_flight_q[5]:0->1"} <= holes
    assert "((in_flight_q != Depth[5:0])==0) => 0" in holes
    core.renew()
    counters, _ = played(core, rng, disturbed(rng), tmp_path, 4000)
    assert protocol_holes(assess(counters)) == set()


@pytest.mark.simulator
def test_a_core_whose_results_are_not_taken_hangs(core: CorePlayer) -> None:
    pairs = [np.zeros((2, 3, 3), np.int64)] * 40
    assert core.play(one_by_one(pairs, np.array([OFFER], np.uint8))).symptom == "hangs"


@pytest.mark.simulator
def test_resets_discard_what_is_in_flight(core: CorePlayer, rng: np.random.Generator, tmp_path: Path) -> None:
    steps = np.full(60, OFFER | TAKE, np.uint8)
    steps[50] |= RESET
    _, states = played(core, rng, steps, tmp_path)
    assert 0 < (states == DISCARDED).sum() < len(states)


def declared_bits(tmp_path: Path, leave_out: int) -> set[str]:
    """Return the counters of TDATA that Verilator declares for the widest core, some options left out."""
    build = replace(core_build(Configuration(32, 0, edge_box=False)), counters=True)
    command = verilate_command(build, tmp_path)
    start = command.index("--coverage-max-width")
    del command[start : start + leave_out]
    run_tool(command, tmp_path, "W = 32")
    text = "".join(path.read_text() for path in tmp_path.glob("*__Slow.cpp"))
    calls = (part.partition(";")[0] for part in text.split("__vlCoverToggleInsert(")[1:])
    return {call.split(", &")[0] for call in calls if '"s_axis_tdata_i"' in call}


@pytest.mark.simulator
def test_the_widest_bus_has_a_counter_for_each_bit_and_would_have_none(tmp_path: Path) -> None:
    assert "--coverage-max-width" in COUNTERS
    for name, leave_out, found in (("with", 0, {"0, 575, 1"}), ("without", 2, set())):
        (tmp_path / name).mkdir()
        assert declared_bits(tmp_path / name, leave_out) == found


@pytest.mark.simulator
def test_the_models_elaborate_every_generate_block() -> None:
    found = {
        (instance.module, label)
        for model in map(covered, (*CORES, None, *ENGINES))
        for instance in read_elaboration(described(model), model.top).values()
        for label in instance.blocks
    }
    blocks = generate_blocks([*rtl_sources(), *mesh_sources()])
    missing = {block.label for block in blocks if (block.module, block.label) not in found}
    of_engine = {"g_bad_powers", "g_bad_sizes", "g_bad_cycles"}
    assert missing == {"g_bad_tag", "g_bad_w", "g_bad_m", "g_bad_edge_box"} | of_engine


@pytest.mark.parametrize("width", [8, 16, 32])
def test_pairs_for_coverage(width: int, rng: np.random.Generator) -> None:
    largest = (1 << width) - 1
    pairs, margins = pairs_with_margins(rng, 400, width, largest)
    low, high = coordinate_range(width)
    assert pairs.shape == (400, 2, 3, 3) and margins.shape == (400,)
    assert pairs.min() == low and pairs.max() == high
    assert margins.min() >= 0 and margins.max() == largest


def coverage(assessment: Assessment, **changes: int) -> CodeCoverage:
    run = replace(Run("w16_m0", 10, 9, 0, 50, 1.0), **changes)
    waiver = Waiver(1, "bounded", "because", "dut", module_hash(()), "toggle", ("m",), signals=("s",))
    return CodeCoverage([run], assessment, [waiver], 2.0, "a" * 64)


def all_hit() -> Assessment:
    return Assessment({("a.sv", kind): Total(9, 1, 10) for kind in KINDS}, waived={1: 1})


def hole() -> Bin:
    return Bin("w16_m0", "toggle", "a.sv", 3, "x[1]:0->1", TOP)


@pytest.mark.parametrize(
    ("result", "passed", "problem"),
    [
        (lambda: coverage(all_hit()), True, None),
        (lambda: coverage(all_hit(), wrong=2), False, "w16_m0: 2 of 9 results are wrong"),
        (lambda: coverage(all_hit(), checked=0), False, "w16_m0: no result was checked"),
        (lambda: coverage(replace(all_hit(), uncovered=[hole()])), False, None),
        (lambda: coverage(replace(all_hit(), problems=["a waiver"])), False, "a waiver"),
        (lambda: replace(coverage(all_hit()), changed=True), False, "the RTL changed during the run"),
    ],
)
def test_the_result_is_written(
    result: Callable[[], CodeCoverage], passed: bool, problem: str | None, tmp_path: Path
) -> None:
    path = tmp_path / "coverage" / "code.json"
    found = result()
    write_json(found, 5, path)
    content = json.loads(path.read_text())
    assert content["passed"] is found.passed is passed
    assert content["problems"] == ([problem] if problem else [])
    assert content["totals"]["toggle"] == {"hit": 9, "waived": 1, "total": 10, "percent": 100.0}
    assert content["files"]["a.sv"]["line"]["total"] == 10
    assert content["waivers"][0]["bins"] == 1 and content["seed"] == 5
    assert [path.name for path in path.parent.iterdir()] == ["code.json"]


@pytest.mark.parametrize("option", ["--seed=-1", "--pairs=0"])
def test_bad_options_are_refused(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["coverage", "code", option]) == 2
    assert "must" in capsys.readouterr().err


@pytest.mark.parametrize(("passed", "code"), [(True, 0), (False, 1)])
def test_the_exit_code_says_whether_all_is_covered(
    passed: bool,
    code: int,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    result = coverage(all_hit() if passed else replace(all_hit(), uncovered=[hole()] * 50))
    monkeypatch.setattr("triaxis.verif.commands.coverage.measure", lambda *_, **__: result)
    monkeypatch.setattr("triaxis.verif.commands.coverage.write_json", lambda *_: tmp_path / "code.json")
    assert main(["coverage", "code"]) == code
    said = capsys.readouterr().out
    assert ("PASSED" in said) is passed
    assert passed or ("a.sv:3: toggle x[1]:0->1, TOP.triaxis_core, w16_m0" in said and "10 more" in said)
