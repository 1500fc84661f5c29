"""Broken engines are caught: by the account of pairs on the bare engine, by assertions on the pins."""

import shutil
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
import pytest

from triaxis.host.engine_scene import MeshEngineScene
from triaxis.sim.build import built, content_hash, rtl_files, rtl_hash
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine
from triaxis.sim.paths import BUILD, DUT
from triaxis.verif.mesh.direct import check_directly
from triaxis.verif.mesh.gap_scenes import gap_scenes
from triaxis.verif.mesh.random_scenes import random_scene
from triaxis.verif.mesh.shapes import Shapes
from triaxis.verif.testbench.settings import PIN
from triaxis.verif.testbench.simulation import run, run_settings

CONFIGURATION = MeshConfiguration(8, 4, 16, 4, 2, 8)
_SCENES = 60


@dataclass(frozen=True)
class Fault:
    """A file of dut/mesh, what of it is replaced, by what, and what is said of it."""

    file: str
    right: str
    wrong: str
    said: str


SKIPPED = "skipped without a proof"
FAULTS = {
    "lane dropped": Fault(
        "triaxis_pick.sv", "mask_q & (mask_q - mask_t'(1))", "mask_t'(0)", SKIPPED
    ),
    "group box never begun anew": Fault(
        "triaxis_mesh_store.sv", "!first_in_group && group_q[0][k] <", "group_q[0][k] <",
        "group_pairs_skipped",
    ),
}  # fmt: skip
ASSERTED = {
    "margin itself skipped": Fault(
        "triaxis_overlap.sv", "> grown_i[1][k]", ">= grown_i[1][k]",
        "no axis separates by more than the margin",
    ),
    "summary before the last near pair": Fault(
        "triaxis_near_pairs.sv", "in_flight_q == '0 && !m_axis_near_tvalid_o", "in_flight_q == '0",
        "before the last near pair was taken",
    ),
    "status of the run before": Fault(
        "triaxis_run_control.sv", "status_d = StatusNone;", "status_d = status_o;", "a status during a run"
    ),
}  # fmt: skip


def broken(fault):
    """Return a folder of RTL with the fault."""
    key = content_hash([], rtl_hash(), repr(fault))

    def make(partial):
        for source in rtl_files(DUT):
            place = partial / source.relative_to(DUT)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, place)
        path = partial / "mesh" / fault.file
        text = path.read_text()
        assert text.count(fault.right) == 1, "the RTL has changed: adapt the test"
        path.write_text(text.replace(fault.right, fault.wrong))

    return built(BUILD / "faults" / f"mesh-{key[:12]}", make)


def scenes(seed):
    shapes = Shapes(np.random.default_rng(seed), CONFIGURATION)
    return chain((random_scene(shapes) for _ in range(_SCENES)), gap_scenes(shapes))


def test_the_engine_as_it_is_passes(seed):
    assert check_directly(CONFIGURATION, scenes(seed), seed) == []


@pytest.mark.parametrize("name", FAULTS)
def test_a_broken_account_is_caught(seed, name):
    found = check_directly(CONFIGURATION, scenes(seed), seed, broken(FAULTS[name]))
    assert any(FAULTS[name].said in line for line in found), found


@pytest.mark.parametrize("name", ASSERTED)
def test_a_broken_rule_is_caught_on_the_pins(tmp_path, seed, name):
    config = f"mesh_{CONFIGURATION.name}"
    test = "MeshGapsTest" if "margin" in name else "MeshStallsTest"
    settings = run_settings(test, config, seed, 300, folder=tmp_path / "run", agent=PIN)
    result = run(settings, broken(ASSERTED[name]))
    assert not result.passed
    assert any(ASSERTED[name].said in line for line in result.errors), result.explain()


def _few_facets():
    return np.arange(45).reshape(5, 3, 3)


def test_an_engine_that_loses_triangles_is_not_believed(monkeypatch):
    kept = MeshEngine.load_unchecked
    monkeypatch.setattr(
        MeshEngine,
        "load_unchecked",
        lambda engine, mesh, facets, traffic: kept(engine, mesh, facets[1:], traffic),
    )
    scene = MeshEngineScene(_few_facets(), _few_facets(), CONFIGURATION)
    with pytest.raises(CoreError, match="holds 4 of the 5 triangles of A"):
        scene.run((0, 0, 0), 0)


def test_an_account_that_leaves_groups_out_is_not_believed(monkeypatch):
    kept = MeshEngine.run

    def with_one_less(engine, *options):
        run = kept(engine, *options)
        return replace(run, group_pairs_opened=run.group_pairs_opened - 1)

    monkeypatch.setattr(MeshEngine, "run", with_one_less)
    scene = MeshEngineScene(_few_facets(), _few_facets(), CONFIGURATION)
    with pytest.raises(CoreError, match="3 of 4 pairs of groups decided"):
        scene.run((0, 0, 0), 0)


def test_engines_come_and_go_in_any_order():
    first, second = MeshEngine(CONFIGURATION), MeshEngine(CONFIGURATION)
    del second
    third = MeshEngine(CONFIGURATION)
    del first
    third.load(_few_facets(), _few_facets())
    assert third.run().near_count
    del third
