"""Broken engines are caught: by the account of pairs, by assertions on the pins, by the host."""

import numpy as np
import pytest

from triaxis.host.engines import MeshEngineScene
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine
from triaxis.verif.core.tests.broken_rtl import broken_rtl
from triaxis.verif.testbench.settings import BURST, PIN
from triaxis.verif.testbench.simulation import run, run_settings

CONFIG = "mesh_w8_m4_d16_g4_l2_c8"

pytestmark = pytest.mark.simulator


# Each a file of dut/mesh, what of it is replaced, by what; the test and the agent that say what of it.
FAULTS = {
    "summary before the last near pair": (
        "triaxis_near_pairs.sv", "in_flight_q == '0 && !m_axis_near_tvalid_o", "in_flight_q == '0",
        "MeshStallsTest", BURST, "before the last near pair was taken",
    ),
    "slower": (
        "triaxis_walk.sv", "QueueDepth = 16;", "QueueDepth = 2;",
        "MeshClocksTest", BURST, "are kept; if that is as it should be",
    ),
    "status of the run before": (
        "triaxis_run_control.sv", "status_d = StatusNone;", "status_d = status_o;",
        "MeshStallsTest", PIN, "a status during a run",
    ),
    "never ready": (
        "triaxis_mesh.sv", "s_axis_run_tready_o = run_ready[0];", "s_axis_run_tready_o = 1'b0;",
        "MeshStallsTest", PIN, "s_axis_load: not accepted in 45600 clocks: the design hangs",
    ),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("name", FAULTS)
def test_a_broken_engine_is_caught(tmp_path, seed, name):
    file, right, wrong, test, agent, said = FAULTS[name]
    settings = run_settings(test, CONFIG, seed, 2000, folder=tmp_path / "run", agent=agent)
    result = run(settings, broken_rtl(tmp_path, (f"mesh/{file}", right, wrong)))
    assert not result.passed
    assert said in result.log.read_text(), result.explain()


# Two groups of triangles, and an engine that others build as well.
FACETS = np.arange(81).reshape(9, 3, 3)
ENGINE = MeshConfiguration(16, 16, 64, 8, 8)


@pytest.mark.long
def test_an_engine_that_loses_triangles_is_not_believed(monkeypatch):
    load = MeshEngine.load_unchecked

    def with_one_triangle_less(engine, mesh, facets):
        return load(engine, mesh, facets[1:])

    monkeypatch.setattr(MeshEngine, "load_unchecked", with_one_triangle_less)
    with pytest.raises(CoreError, match="holds 8 of the 9 triangles of A"):
        MeshEngineScene(FACETS, FACETS, ENGINE).run((0, 0, 0), 0)
