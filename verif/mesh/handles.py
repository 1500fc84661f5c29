"""What the engine's components find in the ConfigDB beside what all find there."""

from typing import cast

from pyuvm import ConfigDB, uvm_component

from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.verif.mesh.bare_bfm import BareBfm
from triaxis.verif.testbench.handles import settings_of

_BARE = "BARE_MESH"


def publish_bare(bfm: BareBfm | None) -> None:
    """Put the bare engine's model where every component finds it; None: the run is one on the pins."""
    ConfigDB().set(None, "*", _BARE, bfm)


def bare_bfm_of(component: uvm_component) -> BareBfm:
    """Return the bare engine's model; there is one where the run is not one on the pins."""
    return cast(BareBfm, ConfigDB().get(component, "", _BARE))


def mesh_configuration_of(component: uvm_component) -> MeshConfiguration:
    """Return the parameters of the engine under test."""
    return settings_of(component).mesh_configuration
