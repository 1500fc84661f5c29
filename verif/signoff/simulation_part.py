"""The simulations of a sign-off: builds, tests, scenes, the wrapper, functional coverage."""

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import TypeVar

from triaxis.coverage.counts import CoverageDatabase, load
from triaxis.coverage.page import write_page
from triaxis.coverage.report import ModelReport, report
from triaxis.sim.build import library
from triaxis.sim.core_engine import configuration_for
from triaxis.sim.provenance import provenance
from triaxis.verif.core.detector_check import check_detector
from triaxis.verif.counterexample.explaining import run_and_explain
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.signoff.folder import FOLDER
from triaxis.verif.signoff.mesh_plan import mesh_plan
from triaxis.verif.signoff.plan import VOLUME, plan
from triaxis.verif.signoff.scene_checks import check_real_meshes, check_scenes
from triaxis.verif.signoff.simulation_result import SimulationResult
from triaxis.verif.testbench.settings import RunSettings
from triaxis.verif.testbench.simulation import RunResult, build_for

Answer = TypeVar("Answer")

_JOBS = min(2, os.cpu_count() or 1)
# Scenes, real meshes, the wrapper.
_CHECKS = 3


def step_count(seed: int, volume: int) -> int:
    """Return how many steps the simulations have."""
    runs = _plan(seed, volume)
    return len(_builds(runs)) + len(runs) + _CHECKS


def _plan(seed: int, volume: int) -> list[RunSettings]:
    """Return the runs of the core and of the mesh engine, the short ones first."""
    return [*mesh_plan(seed), *plan(seed, volume)]


def simulate(seed: int, progress: Callable[[int], None], volume: int = VOLUME) -> SimulationResult:
    """Run everything; ``progress`` is told of each step done."""
    start = time.monotonic()
    before = provenance()
    runs = _plan(seed, volume)
    builds = _builds(runs)

    def one_build(build: Callable[[], Path]) -> None:
        build()
        progress(1)

    def one_check(check: Callable[[], Answer]) -> Answer:
        answer = check()
        progress(1)
        return answer

    def one_run(settings: RunSettings) -> RunResult:
        result = run_and_explain(settings)
        progress(1)
        return result

    with ThreadPoolExecutor(_JOBS) as pool:
        built = [pool.submit(one_build, build) for build in builds]
        results = [pool.submit(one_run, settings) for settings in runs]
        try:
            # Here, in the main thread: the solver's handler of interrupts works in no other.
            made = one_check(partial(check_scenes, FOLDER / "scenes"))
            real = one_check(partial(check_real_meshes, FOLDER / "scenes"))
            detector = one_check(partial(check_detector, seed))
            for future in (*built, *results):
                future.result()
        except BaseException:
            # An error or an interrupt: start nothing more.
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    ran = [future.result() for future in results]
    seconds = time.monotonic() - start
    return SimulationResult(
        ran,
        made,
        real,
        detector,
        collect_coverage(ran),
        max(volume, VOLUME),
        before,
        seconds,
    )


def _builds(runs: list[RunSettings]) -> list[Callable[[], Path]]:
    """Return the builds that the runs and scenes need; the widest take longest and come first."""
    wanted = {(r.config, r.agent): r for r in runs}.values()
    widest_first = sorted(wanted, key=lambda r: (-r.width, r.agent, r.config))
    return [partial(build_for, r) for r in widest_first] + [partial(library, configuration_for(24, 1))]


def collect_coverage(results: list[RunResult]) -> list[ModelReport]:
    """Return the coverage of each configuration, over the runs that passed; write its data and its page.

    A run that passed has written its coverage: a missing file is an error here.
    """
    database = CoverageDatabase(model_of(config) for config in {r.settings.config: None for r in results})
    for result in results:
        if result.passed:
            # Of its own configuration, and of no other.
            database.add(load(result.coverage, model_of(result.settings.config)))
    database.save(FOLDER / "coverage.json")
    write_page(FOLDER / "coverage.html", database)
    return [report(model, counts) for model, counts in database]
