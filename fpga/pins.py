"""The board's pins as its maker publishes them, and which of them each port of the top uses."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

from triaxis.golden.errors import InputError

PINS = Path(__file__).resolve().with_name("nexys4ddr_pins.toml")


@dataclass(frozen=True)
class BoardPins:
    """The board's data: part, source, I/O standard, and the package pin of each port's bits by name.

    ``ports``: ``{"go_o": "C17", "led_o[0]": "H17", ..}``. ``pins``: the package pin of every pin of the
    board that is listed, ``{"JA1": "C17", "LED[0]": "H17", ..}``.
    """

    part: str
    source: str
    io_standard: str
    clock_mhz: float
    pins: dict[str, str]
    ports: dict[str, str]


def read_pins(path: Path = PINS) -> BoardPins:
    """Read the board's data; raise InputError where two names share a pin, or a port uses none of them."""
    content = tomllib.loads(path.read_text(encoding="utf-8"))
    pins: dict[str, str] = {}
    for name, places in content["pins"].items():
        pins.update(_bits(name, places))
    shared = sorted(pin for pin in pins.values() if list(pins.values()).count(pin) > 1)
    if shared:
        raise InputError(f"{path}: {shared[0]}: given to more than one name")
    ports: dict[str, str] = {}
    for port, names in content["ports"].items():
        if isinstance(names, str) and names not in pins:
            # A whole vector of the board.
            names = [name for name in pins if name.startswith(f"{names}[")]
        for bit, name in _bits(port, names).items():
            if name not in pins:
                raise InputError(f"{path}: port {bit}: no pin called {name}")
            ports[bit] = pins[name]
        if not names:
            raise InputError(f"{path}: port {port}: no such pin")
    return BoardPins(
        content["part"], content["source"], content["io_standard"], content["clock_mhz"], pins, ports
    )


def _bits(name: str, values: str | list[str]) -> dict[str, str]:
    """Return the values by bit: ``name`` alone for a single one."""
    if isinstance(values, str):
        return {name: values}
    return {f"{name}[{bit}]": value for bit, value in enumerate(values)}
