"""Scenes on the bare engine without a simulator, with the same stimulus and checks: for broken engines."""

from collections.abc import Iterable
from pathlib import Path
from random import Random

from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine
from triaxis.sim.paths import DUT
from triaxis.verif.mesh import bare_bfm
from triaxis.verif.mesh.bare_bfm import BareBfm
from triaxis.verif.mesh.checking import SceneChecker
from triaxis.verif.mesh.items import LoadItem, RunItem, Scene
from triaxis.verif.mesh.matching import RunMatcher


def check_directly(
    configuration: MeshConfiguration, scenes: Iterable[Scene], seed: int = 1, dut: Path = DUT
) -> list[str]:
    """Load and run scenes; return what was wrong, a line each. ``dut``: another folder of the RTL's files.

    Ends at the first scene in which something is wrong. Raises CoreError where the engine hangs.
    """
    bfm = BareBfm(MeshEngine(configuration, dut))
    checker = SceneChecker(configuration, judged_one_in=100, seed=seed)
    matcher = RunMatcher(configuration.depth, checker.check)
    bfm.publish = {
        bare_bfm.LOAD: matcher.load,
        bare_bfm.RUN: matcher.run,
        bare_bfm.NEAR: matcher.near,
        bare_bfm.CORE: matcher.core,
        bare_bfm.SUMMARY: matcher.summary,
    }
    random = Random(seed)
    for scene in scenes:
        for mesh, triangles in enumerate((scene.a, scene.b)):
            if triangles is not None:
                bfm.load(LoadItem(mesh, triangles, scene.gaps), random)
        for request, traffic in scene.runs:
            bfm.run(RunItem(request, traffic), random)
        found = [failure.message for failure in checker.failures] + matcher.stray
        if found:
            return found
    return []
