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
)
from triaxis.bench.activity.saif import read_saif
from triaxis.bench.activity.streams import UNDECIDED, random_stream
from triaxis.fpga.board_build import ENGINE_INSTANCE, TOP_RTL
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.sim.configuration import Configuration
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine, Mode
from triaxis.sim.paths import DUT
from triaxis.sim.player import followed

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


@pytest.mark.simulator
@pytest.mark.regress
@pytest.mark.parametrize("configuration", [GATED, UNGATED], ids=lambda c: c.name)
def test_toggles_are_exactly_those_of_the_pairs_that_pass(tmp_path, stream, configuration):
    file = tmp_path / "core.saif"
    assert trace(stream, configuration, file).multipliers == 24 + 30
    passing = stream.pairs[stream.undecided] if configuration.gating else stream.pairs
    factors = list(cross_products(passing))
    measured = read_saif(file)
    found = [path for path in measured.instances if path.endswith(("/u_plus", "/u_minus"))]
    assert len(found) == len(factors) == 24
    bits = configuration.width + 1
    counted = {
        signal: sum(measured.inside(path, signal) for path in found) for signal in ("a_i", "b_i", "piece_q")
    }
    assert counted == {
        "a_i": sum(toggles(a, bits) for a, _ in factors),
        "b_i": sum(toggles(b, bits) for _, b in factors),
        "piece_q": sum(toggles(a * b, 2 * bits) for a, b in factors),
    }


@pytest.mark.simulator
@pytest.mark.regress
def test_gating_leaves_about_the_undecided_share_and_broken_gating_is_seen(tmp_path, stream):
    dut = tmp_path / "dut"
    shutil.copytree(DUT, dut)
    boxes, right = dut / "core" / "triaxis_boxes.sv", "assign open = valid && (!Gating || separated == '0);"
    assert boxes.read_text().count(right) == 1
    boxes.write_text(boxes.read_text().replace(right, "assign open = valid;"))
    file = tmp_path / "core.saif"
    gated, ungated, broken = (
        trace(stream, c, file, d) for c, d in ((GATED, DUT), (UNGATED, DUT), (GATED, dut))
    )
    rows = [Row(stream.name, len(stream.pairs), 20, 0, each, ungated) for each in (gated, broken)]
    assert rows[0].within_bound and 0.5 * UNDECIDED < rows[0].ratio < BOUND
    assert not rows[1].within_bound and rows[1].ratio > 0.9


@pytest.mark.simulator
@pytest.mark.regress
def test_the_mesh_engine_is_followed_while_it_runs(tmp_path, rng):
    a, b = rng.integers(-128, 127, (2, 20, 3, 3), endpoint=True)
    file = tmp_path / "mesh.saif"
    engine = MeshEngine(MeshConfiguration(8, 0, 64, 4, 2), traced=True)
    engine.load(a, b)
    with followed(engine.library, file):
        near = engine.run(mode=Mode.COUNT).near_count
    pairs = np.stack([np.repeat(a, 20, 0), np.tile(b, (20, 1, 1))], 1)
    assert near == bulk_facts(pairs, 0).near.sum() > 0
    measured = read_saif(file)
    assert measured.instances["TOP"]["clk_i"] * 5000 == measured.duration
    assert any(path.startswith("TOP/triaxis_mesh/u_core/") for path in measured.instances)
    assert multiplier_toggles(measured).total > 0


@pytest.mark.parametrize(("gated", "status"), [(3, 0), (4, 1)])
def test_command(tmp_path, monkeypatch, capsys, gated, status):
    row = Row("pairs", 1000, 10, 5, MultiplierToggles(1, gated, 0, 0), MultiplierToggles(1, 50, 30, 20))
    monkeypatch.setattr(measuring, "ACTIVITY", tmp_path / "activity.json")
    monkeypatch.setattr(measuring, "measure", lambda _: row)
    monkeypatch.setattr(measuring, "trace_scene", lambda: row.gated)
    assert main(["fpga", "activity"]) == status
    assert f"{gated}.00 %" in capsys.readouterr().out
    content = json.loads((tmp_path / "activity.json").read_text())
    assert content["passed"] is bool(status == 0) is not bool(content["problems"])
    assert content["streams"][0]["ratio"] == content["worst"] == gated / 100


GOOD = r"""// Generated by a simulator
(SAIFILE
(DURATION 840)
 (INSTANCE TOP
  (NET
   (clk_i (T0 420) (T1 420) (TZ 0) (TX 0) (TB 0) (TC 84))
  )
  (INSTANCE "triaxis_mul" u_mul
   (NET
    (a_i\[0\] (T0 1) (T1 2) (TX 0) (TC 3) (IG 0))
    (a_i\[1\]
       (T0 1) (T1 2) (TC 4))
   )
   (INSTANCE g_product[0]
    (NET (a_i (T0 0) (T1 0) (TC 10)))
   )
  )
 )
)
"""


def test_saif_files(tmp_path):
    path = tmp_path / "activity.saif"
    path.write_text(GOOD)
    activity = read_saif(path)
    assert activity.duration == 840 and activity.instances["TOP"] == {"clk_i": 84}
    assert activity.instances["TOP/u_mul"] == {"a_i": 7}
    assert [activity.inside(place, "a_i") for place in ("TOP/u_mul", "TOP")] == [17, 17]
    with pytest.raises(InputError, match="nothing was measured"):
        multiplier_toggles(activity)
    # In the board, the engine has its place.
    engine = "(SAIFILE (DURATION 1) (INSTANCE TOP (NET (clk_i (TC 2)))\n"
    engine += " (INSTANCE triaxis_mesh (NET (busy (TC 3))) (INSTANCE u_core (NET (a (TC 4)))))))"
    path.write_text(in_place(engine))
    places = {"nexys4ddr_top": {"clk_i": 2}, "nexys4ddr_top/u_mesh": {"busy": 3}}
    assert read_saif(path).instances == {**places, "nexys4ddr_top/u_mesh/u_core": {"a": 4}}
    assert re.search(rf"triaxis_mesh\s*#\([^;]*\)\s*{ENGINE_INSTANCE}\s*\(", TOP_RTL.read_text())
    for text, says in (
        (GOOD[:-3], "ends early"),
        (GOOD.replace("(DURATION 840)\n", ""), "no DURATION"),
        (GOOD + ")", "one closing parenthesis too many"),
        (GOOD.replace("(TC 84)", "(TC many)"), r":6: not SAIF: .*clk_i"),
        ("", "not a whole SAIF file"),
    ):
        path.write_text(text)
        with pytest.raises(InputError, match=says):
            read_saif(path)
