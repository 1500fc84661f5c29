"""Runs the sign-off: builds, tests, scenes, the wrapper, coverage."""

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.database import CoverageDatabase
from triaxis.coverage.page import write_page
from triaxis.coverage.report import ModelReport, report
from triaxis.verif.build import library
from triaxis.verif.engine import configuration_for
from triaxis.verif.settings import RunSettings
from triaxis.verif.signoff.detector_check import check_detector
from triaxis.verif.signoff.plan import VOLUME, plan
from triaxis.verif.signoff.provenance import provenance
from triaxis.verif.signoff.result import FOLDER, RESULT, SignoffResult
from triaxis.verif.signoff.scene_checks import check_real_meshes, check_scenes
from triaxis.verif.simulation import RunResult, build_for, run

_JOBS = min(2, os.cpu_count() or 1)


def signoff(
    seed: int,
    progress: Callable[[int], None],
    steps: Callable[[int], None],
    volume: int = VOLUME,
) -> SignoffResult:
    """Run everything; ``steps`` is told how many steps there are, ``progress`` of each done."""
    start = time.monotonic()
    # An old result must not outlive a run that ends early.
    RESULT.unlink(missing_ok=True)
    before = provenance()
    runs = plan(seed, volume)
    builds = _builds(runs)
    steps(len(builds) + len(runs) + 2)

    def one_build(build: Callable[[], Path]) -> None:
        build()
        progress(1)

    def one_run(settings: RunSettings) -> RunResult:
        result = run(settings)
        progress(1)
        return result

    with ThreadPoolExecutor(_JOBS) as pool:
        list(pool.map(one_build, builds))
        results = list(pool.map(one_run, runs))
    made, real = check_scenes(FOLDER / "scenes"), check_real_meshes(FOLDER / "scenes")
    progress(1)
    detector = check_detector(seed)
    progress(1)
    seconds = time.monotonic() - start
    return SignoffResult(results, made, real, detector, _coverage(results), volume, before, seconds)


def _builds(runs: list[RunSettings]) -> list[Callable[[], Path]]:
    """Return the builds that the runs and scenes need; the widest take longest and come first."""
    wanted = {(r.config, r.agent): r for r in runs}.values()
    widest_first = sorted(wanted, key=lambda r: (-r.configuration.width, r.agent, r.config))
    return [partial(build_for, r) for r in widest_first] + [partial(library, configuration_for(24, 1))]


def _coverage(results: list[RunResult]) -> list[ModelReport]:
    """Return the coverage of each configuration, over the runs that passed; write its data and its page.

    A run that passed has written its coverage: a missing file is an error here.
    """
    configurations = {r.settings.config: r.settings.configuration for r in results}
    database = CoverageDatabase(core_model(*c.covered) for c in configurations.values())
    for result in results:
        if result.passed:
            database.add_file(result.coverage)
    database.save(FOLDER / "coverage.json")
    write_page(FOLDER / "coverage.html", database)
    return [report(model, counts) for model, counts in database]
