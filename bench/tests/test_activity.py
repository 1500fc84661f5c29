"""Operand gating by counted toggles: the counts are exact, the bound holds, broken gating is seen."""

import json
import re
import shutil

import numpy as np
import pytest

from triaxis.bench.activity import measuring
from triaxis.bench.activity.measuring import (
    BOUND,
    MultiplierToggles,
    Row,
    in_place,
    multiplier_toggles,
    trace,
    write_result,
)
from triaxis.bench.activity.saif import Activity, read_saif
from triaxis.bench.activity.streams import UNDECIDED, box_gaps, random_stream, streams
from triaxis.bench.activity.traced_mesh import TracedMeshEngine
from triaxis.fpga.board_build import ENGINE_INSTANCE, TOP_RTL
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.host.cli import fpga as command
from triaxis.host.cli import main
from triaxis.sim.configuration import Configuration
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.paths import DUT

# The smallest core: what it shows of gating holds for all.
GATED = Configuration(8, 0, edge_box=False)
UNGATED = Configuration(8, 0, edge_box=False, gating=False)


@pytest.fixture
def stream(rng):
    return random_stream(rng, 2000, GATED.width)


def toggles(sequence, bits):
    """Return the toggles of a register of so many bits that starts at 0 and takes the values in turn."""
    words = np.concatenate([[0], sequence]) & ((1 << bits) - 1)
    return int(np.bitwise_count((words[1:] ^ words[:-1]).astype(np.uint64)).sum())


def cross_products(pairs):
    """Return the factors of all products in the cross products of the smallest core."""
    p, q = pairs[:, 0, 1] - pairs[:, 0, 0], pairs[:, 0, 2] - pairs[:, 0, 0]
    r = [pairs[:, 1, j] - pairs[:, 0, 0] for j in range(3)]
    for a, b in [(p, q), *((r[j], r[(j + 1) % 3]) for j in range(3))]:
        for k in range(3):
            yield a[:, (k + 1) % 3], b[:, (k + 2) % 3]
            yield a[:, (k + 2) % 3], b[:, (k + 1) % 3]


@pytest.mark.parametrize("configuration", [GATED, UNGATED], ids=lambda c: c.name)
def test_toggles_are_exactly_those_of_the_pairs_that_pass(tmp_path, stream, configuration):
    file = tmp_path / "core.saif"
    trace(stream, configuration, file)
    passing = stream.pairs[stream.undecided] if configuration.gating else stream.pairs
    factors = list(cross_products(passing))
    bits = configuration.width + 1
    counted = {"a_i": 0, "b_i": 0, "piece_q": 0}
    measured = read_saif(file)
    found = [path for path in measured.instances if path.endswith(("/u_plus", "/u_minus"))]
    assert len(found) == len(factors) == 24
    for path in found:
        for signal in counted:
            counted[signal] += measured.inside(path, signal)
    assert counted == {
        "a_i": sum(toggles(a, bits) for a, _ in factors),
        "b_i": sum(toggles(b, bits) for _, b in factors),
        "piece_q": sum(toggles(a * b, 2 * bits) for a, b in factors),
    }


def test_gating_leaves_about_the_undecided_share(tmp_path, stream):
    gated, ungated = (trace(stream, c, tmp_path / "core.saif") for c in (GATED, UNGATED))
    # Four cross products of six, ten triple products of three.
    assert gated.multipliers == ungated.multipliers == 24 + 30
    row = Row(stream.name, len(stream.pairs), int(stream.undecided.sum()), 0, gated, ungated)
    assert row.within_bound
    assert 0.5 * UNDECIDED < row.ratio < BOUND


def test_broken_gating_is_seen(tmp_path, stream):
    dut = tmp_path / "dut"
    shutil.copytree(DUT, dut)
    boxes, right = dut / "core" / "triaxis_boxes.sv", "assign open = valid && (!Gating || separated == '0);"
    assert boxes.read_text().count(right) == 1
    boxes.write_text(boxes.read_text().replace(right, "assign open = valid;"))
    broken = trace(stream, GATED, tmp_path / "core.saif", dut)
    ungated = trace(stream, UNGATED, tmp_path / "core.saif")
    row = Row(stream.name, len(stream.pairs), int(stream.undecided.sum()), 0, broken, ungated)
    assert not row.within_bound
    assert row.ratio > 0.9


def test_streams_have_one_undecided_pair_in_a_hundred():
    every = streams(1)
    assert len(every) == 6
    for stream in every:
        assert UNDECIDED <= stream.share < 1.2 * float(UNDECIDED)
        assert stream.margin < 1 << measuring.GATED.margin_bits


def test_box_gaps():
    pairs = np.zeros((3, 2, 3, 3), np.int64)
    pairs[1, 1, :, 2] = [7, 5, 9]
    pairs[2, 0, :, 0] = [4, 4, 6]
    pairs[2, 1, :, 1] = [-3, -9, -5]
    assert box_gaps(pairs).tolist() == [0, 5, 4]


def test_the_mesh_engine_is_followed_while_it_runs(tmp_path, rng):
    a, b = rng.integers(-128, 127, (2, 20, 3, 3), endpoint=True)
    file = tmp_path / "mesh.saif"
    near = TracedMeshEngine(MeshConfiguration(8, 0, 64, 4, 2)).count_near(a, b, 0, file)
    pairs = np.stack([np.repeat(a, 20, 0), np.tile(b, (20, 1, 1))], 1)
    assert near == bulk_facts(pairs, 0).near.sum() > 0
    followed = read_saif(file)
    assert followed.instances["TOP"]["clk_i"] * 5000 == followed.duration
    assert any(path.startswith("TOP/triaxis_mesh/u_core/") for path in followed.instances)
    assert multiplier_toggles(followed).total > 0


def test_the_engines_activity_is_given_its_place_in_the_board(tmp_path):
    engine = "(SAIFILE (DURATION 1) (INSTANCE TOP (NET (clk_i (TC 2)))\n"
    engine += " (INSTANCE triaxis_mesh (NET (busy (TC 3)))\n"
    engine += " (INSTANCE u_core (NET (a (TC 4))) (INSTANCE TOP (NET (b (TC 5))))))))"
    file = tmp_path / "placed.saif"
    file.write_text(in_place(engine))
    assert read_saif(file).instances == {
        "nexys4ddr_top": {"clk_i": 2},
        "nexys4ddr_top/u_mesh": {"busy": 3},
        "nexys4ddr_top/u_mesh/u_core": {"a": 4},
        "nexys4ddr_top/u_mesh/u_core/TOP": {"b": 5},
    }


def test_the_board_has_the_engine_where_its_activity_says():
    top = TOP_RTL
    if not top.exists():
        pytest.skip(f"{top} is not there")
    assert re.search(rf"triaxis_mesh\s*#\([^;]*\)\s*{ENGINE_INSTANCE}\s*\(", top.read_text())


@pytest.mark.parametrize(("gated", "status"), [(3, 0), (4, 1)])
def test_command(tmp_path, monkeypatch, capsys, gated, status):
    row = Row("pairs", 1000, 10, 5, MultiplierToggles(1, gated, 0, 0), MultiplierToggles(1, 50, 30, 20))
    monkeypatch.setattr(measuring, "RESULT", tmp_path / "activity.json")
    monkeypatch.setattr(command, "measure", lambda _, progress: [row])
    monkeypatch.setattr(command, "trace_scene", lambda _: row.gated)
    assert main(["fpga", "activity"]) == status
    assert f"{gated}.00 %" in capsys.readouterr().out
    assert (tmp_path / "activity.json").exists()


def test_nothing_counted_is_an_error():
    ports = {"a_i": 1, "b_i": 1, "product_o": 1}
    good = Activity(1, {"u_mul": ports, "u_mul/g_product[0]": {"piece_q": 2}})
    assert multiplier_toggles(good) == MultiplierToggles(1, 2, 2, 1)
    for instances in ({}, {"u_mul": ports}, {"u_mul": {**ports, "product_o": 0}, "u_mul/g": {"piece_q": 2}}):
        with pytest.raises(InputError, match="nothing was measured"):
            multiplier_toggles(Activity(1, instances))


def test_wrong_answers_are_no_measurement(tmp_path, stream, monkeypatch):
    class Broken:
        def __init__(self, *_):
            pass

        def run(self, pairs, _margins, _file):
            return np.zeros(len(pairs), np.uint16)

    monkeypatch.setattr(measuring, "TracedCore", Broken)
    with pytest.raises(InputError, match="answers wrong"):
        trace(stream, GATED, tmp_path / "core.saif")


@pytest.mark.parametrize(("gated", "passed"), [(3, True), (4, False)])
def test_result_file(tmp_path, monkeypatch, gated, passed):
    monkeypatch.setattr(measuring, "RESULT", tmp_path / "activity.json")
    counted = MultiplierToggles(1, gated, 0, 0)
    row = Row("pairs", 1000, 10, 5, counted, MultiplierToggles(1, 50, 30, 20))
    content = json.loads(write_result([row], counted, 1, 2.0).read_text())
    assert content["passed"] is passed
    assert content["streams"][0]["ratio"] == gated / 100
    assert bool(content["problems"]) is not passed
    assert content["worst"] == gated / 100
