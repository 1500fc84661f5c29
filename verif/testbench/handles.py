"""What components find in the ConfigDB, and the pins of a stream, with their types."""

from typing import Any, Protocol, TypeVar, cast

from cocotb.handle import LogicArrayObject, LogicObject
from pyuvm import ConfigDB, uvm_component

from triaxis.verif.testbench.settings import RunSettings

Component = TypeVar("Component", bound=uvm_component)

_SETTINGS, _DUT, _BFM = "SETTINGS", "DUT", "BFM"


class StreamPins(Protocol):
    """The pins of an AXI4-Stream, as cocotb-bus finds them."""

    tvalid: LogicObject
    tready: LogicObject
    tdata: LogicArrayObject
    tuser: LogicArrayObject


def publish(settings: RunSettings, dut: Any, bfm: Any) -> None:
    """Put the settings, the top level's handle and the burst model where every component finds them."""
    ConfigDB().set(None, "*", _SETTINGS, settings)
    ConfigDB().set(None, "*", _DUT, dut)
    ConfigDB().set(None, "*", _BFM, bfm)


def settings_of(component: uvm_component) -> RunSettings:
    """Return the settings of the run."""
    return cast(RunSettings, ConfigDB().get(component, "", _SETTINGS))


def dut_of(component: uvm_component) -> Any:
    """Return the handle of the core; its attributes are its pins."""
    return ConfigDB().get(component, "", _DUT)


def create(kind: type[Component], name: str, parent: uvm_component) -> Component:
    """Create a component by the factory, so that overrides apply."""
    return cast(Component, kind.create(name, parent))


def bfm_of(component: uvm_component) -> Any:
    """Return the bus-functional model; there is one where the run is for bursts."""
    return ConfigDB().get(component, "", _BFM)
