"""An elaborated module as a graph of words and registers, some modules left closed."""

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.sim.paths import DUT, rtl_sources
from triaxis.sim.programs import read_slang, run_to_result, yosys

# A bit of the netlist: the number of its net, or the constants "0", "1", "x", "z".
Bit = int | str
# Cells that put out at Q what was at D; others put out at Y.
REGISTERS = ("$dff", "$aldff")


class NetlistError(Exception):
    """The netlist is not what the argument is about; one line says where."""


@dataclass(frozen=True)
class Cell:
    """A cell: its name, its type, its parameters as numbers, and the bits at its ports."""

    name: str
    kind: str
    parameters: Mapping[str, int]
    ports: Mapping[str, tuple[Bit, ...]]


@dataclass(frozen=True)
class Netlist:
    """The cells of a module, its ports, its named nets, and the cell, port and place that drive each bit."""

    top: str
    cells: tuple[Cell, ...]
    inputs: Mapping[str, tuple[Bit, ...]]
    outputs: Mapping[str, tuple[Bit, ...]]
    nets: Mapping[str, tuple[Bit, ...]]
    drivers: Mapping[Bit, tuple[Cell, str, int]]


def elaborate(
    dut: Path, top: str, parameters: Mapping[str, int], boxes: Sequence[str], folder: Path
) -> Netlist:
    """Elaborate a module of ``dut`` with yosys, the modules ``boxes`` left closed.

    ``folder`` takes a copy of the RTL, the log and the netlist. Raises InputError where yosys gives none.
    """
    names = [source.relative_to(DUT).as_posix() for source in rtl_sources()]
    closed = " ".join(f"--blackboxed-module {name}" for name in boxes)
    reading = read_slang(flat(names), top, parameters, f"--no-implicit-memories {closed}")
    script = f"{reading}; opt_clean; write_json netlist.json"
    path = run_yosys(script, dut, names, folder, "netlist.json")
    return read_netlist(top, json.loads(path.read_text(encoding="utf-8"))["modules"][top], boxes)


def flat(names: Sequence[str]) -> list[str]:
    """Return RTL files by their names alone: tools see files through a sandbox, so they get copies."""
    return [Path(name).name for name in names]


def run_yosys(script: str, dut: Path, names: Sequence[str], folder: Path, result: str) -> Path:
    """Run yosys on copies of RTL files in ``folder``; return the file ``result`` that it must write there.

    Raises InputError where there is none: nothing is decided then.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name in (*names, "core/triaxis_stage.svh"):
        shutil.copy(dut / name, folder)
    # A file: a command line has an end.
    commands, path = folder / "commands.ys", folder / result
    commands.write_text(script.replace("; ", "\n") + "\n", encoding="utf-8")
    run_to_result([str(yosys()), "-s", commands.name], path, folder / "yosys.log", folder)
    return path


def read_netlist(top: str, module: Mapping[str, Any], boxes: Sequence[str]) -> Netlist:
    """Return the netlist of a module as yosys writes it, the modules ``boxes`` left closed in it.

    Raises NetlistError where a register takes what it holds at anything but the rising edge of clk_i.
    """
    cells, drivers = [], {}
    clock = module["ports"]["clk_i"]["bits"] if "clk_i" in module["ports"] else None
    for name, found in module["cells"].items():
        kind = found["type"]
        cell = Cell(
            name,
            kind,
            {key: _number(value) for key, value in found["parameters"].items()},
            {port: tuple(bits) for port, bits in found["connections"].items()},
        )
        if kind in REGISTERS and not (cell.parameters["CLK_POLARITY"] and list(cell.ports["CLK"]) == clock):
            raise NetlistError(f"{name}: a register at another edge than the rising one of clk_i")
        cells.append(cell)
        for port, bits in cell.ports.items():
            driven = port.endswith("_o") if kind in boxes else port == ("Q" if kind in REGISTERS else "Y")
            if driven:
                drivers.update({bit: (cell, port, place) for place, bit in enumerate(bits)})
    ports = {name: (port["direction"], tuple(port["bits"])) for name, port in module["ports"].items()}
    return Netlist(
        top,
        tuple(cells),
        {name: bits for name, (direction, bits) in ports.items() if direction == "input"},
        {name: bits for name, (direction, bits) in ports.items() if direction == "output"},
        {name: tuple(net["bits"]) for name, net in module["netnames"].items()},
        drivers,
    )


def _number(value: str) -> int:
    return int(value, 2) if set(value) <= {"0", "1"} else 0
