"""Functional coverage over the runs of a regression, configuration by configuration."""

from collections.abc import Iterable
from pathlib import Path

from triaxis.coverage.counts import CoverageDatabase, load
from triaxis.coverage.page import write_page
from triaxis.coverage.report import ModelReport, report
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.regress.planned_run import PlannedRun
from triaxis.verif.regress.run_record import RunRecord
from triaxis.verif.testbench.settings import coverage_file


def merge_coverage(
    folder: Path, planned: Iterable[PlannedRun], records: Iterable[RunRecord]
) -> list[ModelReport]:
    """Return the coverage of each planned configuration; write it as coverage.json and coverage.html.

    A run that passed has left its coverage; raise InputError where it is missing or of another model.
    """
    models = {config: model_of(config) for config in {run.config: None for run in planned}}
    database = CoverageDatabase(models.values())
    for record in records:
        if record.passed and record.run.config in models:
            database.add(load(coverage_file(Path(record.folder)), models[record.run.config]))
    database.save(folder / "coverage.json")
    write_page(folder / "coverage.html", database)
    return [report(model, counts) for model, counts in database]
