"""Mutants of a module in which something is there twice, held against it with one of each two left.

From which of two instances that never differ an answer is taken changes nothing, and no test can tell.
Evidence of that:

1. the module is elaborated, with the mutant and without, its instances left closed;
2. two instances of one generate loop are twins where the same bits reach all their inputs, and each register
   and output of the one is that of the other for any inputs and registers, by induction;
3. of twins the second is left out, and the first drives what the second did, but for what the two show for
   comparison: that stays apart, so whatever weakens the comparison is not the same;
4. what goes into each instance that is left, and out of the module, is shown to be the same with the mutant,
   for anything that comes out of the instances and any registers, by induction.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError

# What twins show, so that they can be compared.
_SHOWN = "seen_o"
# Of an instance in a generate loop: where the second of two stands.
_SECOND = re.compile(r"^(.*)\[1\]([^\[\]]*)$")

Module = dict[str, Any]


def split(read: Sequence[str], names: Sequence[str], module: str) -> str:
    """Return the script that elaborates a module in some ways, ``read``, to ``names``.json."""
    return "; ".join(
        f"{command}; hierarchy -top {module}; proc; opt_clean; memory_map; opt_merge; opt_clean; "
        f"write_json {name}.json; design -reset"
        for command, name in zip(read, names, strict=True)
    )


def paired(folder: Path, names: Sequence[str], module: str) -> str:
    """Leave the second of all twins out of ``names``.json in the folder; return the script that is to hold.

    The first name is the original's. Raises InputError where there are no twins.
    """
    script: list[str] = []
    for name in names:
        design = json.loads((folder / f"{name}.json").read_text())
        twins = dict(_twins(design["modules"][module]["cells"]))
        if name == names[0]:
            if not twins:
                raise InputError(f"{module}: twins: no two instances that the same bits reach")
            for number, pair in enumerate(twins.items()):
                for side, instance in zip(("gold", "gate"), pair, strict=True):
                    _write_part(design, module, instance, folder / f"twin{number}_{side}.json", side)
                script += [_stashed(f"twin{number}_{side}", side, "flatten") for side in ("gold", "gate")]
                script.append("INDUCTION")
        _leave_out(design["modules"][module], twins)
        (folder / f"{name}.json").write_text(json.dumps(design))
    for number, name in enumerate(names[1:]):
        script += [
            _stashed(names[0], "gold", f"expose -evert {module}", module),
            _stashed(name, "gate", f"expose -evert {module}", module),
            "INDUCTION",
            f"log PROVED-{number}-.; design -reset",
        ]
    return "; ".join(script)


def _stashed(file: str, side: str, how: str, module: str = "") -> str:
    """Return the commands that read a file, and keep its module as one side of a comparison."""
    rename = f"rename {module} {side}; " if module else ""
    return f"design -reset; read_json {file}.json; hierarchy -top {module or side}; {how}; opt_clean; " + (
        f"{rename}design -stash {side}"
    )


def _twins(cells: Mapping[str, Module]) -> Iterator[tuple[str, str]]:
    for second, cell in cells.items():
        place = _SECOND.match(second)
        first = f"{place[1]}[0]{place[2]}" if place and not cell["type"].startswith("$") else ""
        if first in cells and _what(cells[first]) == _what(cell):
            yield first, second


def _what(cell: Module) -> tuple[str, dict[str, Any]]:
    """Return the module of an instance, without the place that stands behind its name, and its inputs."""
    directions = cell["port_directions"]
    inputs = {port: bits for port, bits in cell["connections"].items() if directions[port] == "input"}
    return cell["type"].split("$")[0], inputs


def _write_part(design: Module, module: str, instance: str, path: Path, name: str) -> None:
    """Write the design with the module of an instance as its top."""
    modules = dict(design["modules"])
    modules[name] = modules.pop(modules[module]["cells"][instance]["type"])
    del modules[module]
    modules[name]["attributes"].pop("top", None)
    path.write_text(json.dumps({**design, "modules": modules}))


def _leave_out(module: Module, twins: Mapping[str, str]) -> None:
    """Leave out the second of twins; what it drove is driven by the first."""
    cells, drives = module["cells"], dict[int, int]()
    for first, second in twins.items():
        gone = cells.pop(second)
        for port, direction in gone["port_directions"].items():
            if port == _SHOWN:
                shown = {"direction": "input", "bits": gone["connections"][port]}
                module["ports"][f"{second}.{port}"] = shown
            elif direction == "output":
                drives |= zip(gone["connections"][port], cells[first]["connections"][port], strict=True)
    for holder, key in (
        *((cell["connections"], port) for cell in cells.values() for port in cell["connections"]),
        *((port, "bits") for port in module["ports"].values()),
        *((net, "bits") for net in module["netnames"].values()),
    ):
        holder[key] = [drives.get(bit, bit) for bit in holder[key]]
