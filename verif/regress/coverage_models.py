"""The coverage model of a configuration, of the core or of the mesh engine, by its name."""

from typing import Any

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.cover_model import CoverModel
from triaxis.coverage.mesh_coverage import mesh_model
from triaxis.sim.configuration import parse_configuration
from triaxis.sim.mesh_configuration import is_mesh_configuration, parse_mesh_configuration
from triaxis.verif.mesh.sampling import mesh_build

_CORE = "core_"


def model_of(config: str) -> CoverModel[Any]:
    """Return the model of a configuration; several of the core may share one. InputError for other names."""
    if is_mesh_configuration(config):
        return mesh_model(mesh_build(parse_mesh_configuration(config)))
    return core_model(*parse_configuration(config).covered)


def model_named(name: str) -> CoverModel[Any]:
    """Return the model of that name; those of the engine have the names of their configurations."""
    return model_of(name.removeprefix(_CORE))
