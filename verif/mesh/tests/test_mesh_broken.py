"""Broken engines are caught: by the account of pairs, by assertions on the pins, by the host."""

import shutil
from dataclasses import dataclass, replace

import numpy as np
import pytest

from triaxis.host.engines import MeshEngineScene
from triaxis.sim.build import built, content_hash, rtl_files, rtl_hash
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine
from triaxis.sim.paths import BUILD, DUT
from triaxis.verif.testbench.settings import BURST, PIN
from triaxis.verif.testbench.simulation import run, run_settings

CONFIGURATION = MeshConfiguration(8, 4, 16, 4, 2, 8)
CONFIG = f"mesh_{CONFIGURATION.name}"

pytestmark = pytest.mark.simulator


@dataclass(frozen=True)
class Fault:
    """A file of dut/mesh, what of it is replaced, by what; the test and the agent that say what of it."""

    file: str
    right: str
    wrong: str
    test: str
    agent: str
    said: str


FAULTS = {
    "lane dropped": Fault(
        "triaxis_pick.sv", "mask_q & (mask_q - mask_t'(1))", "mask_t'(0)",
        "MeshVolumeTest", BURST, "skipped without a proof",
    ),
    "group box never begun anew": Fault(
        "triaxis_mesh_store.sv", "!first_in_group && group_q[0][k] <", "group_q[0][k] <",
        "MeshVolumeTest", BURST, "group_pairs_skipped",
    ),
    "margin itself skipped": Fault(
        "triaxis_overlap.sv", "> grown_i[1][k]", ">= grown_i[1][k]",
        "MeshGapsTest", BURST, "no axis separates by more than the margin",
    ),
    "summary before the last near pair": Fault(
        "triaxis_near_pairs.sv", "in_flight_q == '0 && !m_axis_near_tvalid_o", "in_flight_q == '0",
        "MeshStallsTest", BURST, "before the last near pair was taken",
    ),
    "slower": Fault(
        "triaxis_mesh.sv", "QueueDepth = 16;", "QueueDepth = 2;",
        "MeshClocksTest", BURST, "are kept; if that is as it should be",
    ),
    "status of the run before": Fault(
        "triaxis_run_control.sv", "status_d = StatusNone;", "status_d = status_o;",
        "MeshStallsTest", PIN, "a status during a run",
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


# One that the account of pairs finds is enough for every day: each needs a build of its own.
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.regress if n else ()) for n, name in enumerate(FAULTS)]
)
def test_a_broken_engine_is_caught(tmp_path, seed, name):
    fault = FAULTS[name]
    settings = run_settings(fault.test, CONFIG, seed, 2000, folder=tmp_path / "run", agent=fault.agent)
    result = run(settings, broken(fault))
    assert not result.passed
    assert fault.said in result.log.read_text(), result.explain()


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
