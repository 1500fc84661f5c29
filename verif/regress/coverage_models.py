"""Functional coverage by configuration: its model, of core, mesh engine or board; what runs add up to."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from triaxis.coverage.board_coverage import board_model
from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import CoverageDatabase, load
from triaxis.coverage.cover_model import CoverModel
from triaxis.coverage.html import write_page
from triaxis.coverage.mesh_coverage import mesh_model
from triaxis.coverage.report import ModelReport, report
from triaxis.golden.errors import InputError
from triaxis.sim.board_parameters import is_board_configuration
from triaxis.sim.configuration import parse_configuration
from triaxis.sim.mesh_configuration import is_mesh_configuration, parse_mesh_configuration
from triaxis.verif.mesh.sampling import mesh_build
from triaxis.verif.testbench.settings import coverage_file

_CORE = "core_"


def model_of(config: str) -> CoverModel[Any]:
    """Return the model of a configuration; several of the core, or of the board, may share one.

    Raises InputError for other names.
    """
    if is_board_configuration(config):
        return board_model()
    if is_mesh_configuration(config):
        return mesh_model(mesh_build(parse_mesh_configuration(config)))
    return core_model(parse_configuration(config))


def model_named(name: str) -> CoverModel[Any]:
    """Return the model of that name; those of the engine have the names of their configurations."""
    board = board_model()
    return board if name == board.name else model_of(name.removeprefix(_CORE))


def has_coverage(config: str, run: Path) -> bool:
    """Return whether a run in a folder left its coverage, whole."""
    try:
        load(coverage_file(run), model_of(config))
    except InputError:
        return False
    return True


def illegal_hits(passed: Iterable[tuple[str, Path]]) -> list[str]:
    """Return what was hit in runs and must not be, a line each; ``passed``: see `merge_coverage`."""
    return [
        line
        for config, run in passed
        for line in report(model_of(config), load(coverage_file(run), model_of(config))).illegal
    ]


def merge_coverage(
    folder: Path, configs: Iterable[str], passed: Iterable[tuple[str, Path]]
) -> list[ModelReport]:
    """Return the coverage of each configuration; write it as coverage.json and coverage.html into ``folder``.

    ``passed``: configuration and folder of each run that passed, and so has left its coverage; raises
    InputError where it is missing, or of another model.
    """
    models = {config: model_of(config) for config in dict.fromkeys(configs)}
    database = CoverageDatabase(models.values())
    for config, run in passed:
        if config in models:
            # Of its own configuration, and of no other.
            database.add(load(coverage_file(run), models[config]))
    database.save(folder / "coverage.json")
    write_page(folder / "coverage.html", database)
    return [report(model, counts) for model, counts in database]
