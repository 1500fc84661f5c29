"""The elaborated design as Verilator describes it: its instances, with parameters and signals.

Coverage counters are only worth something where it is known what has none. Verilator leaves signals
out without a word (above a width, of some types, with some names), so the signals that should have
counters are listed here from the elaborated design itself, its ``--json-only`` output.
"""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError

_Node = dict[str, Any]

_TOP = "TOP"
_SIGNAL_KINDS = ("PORT", "VAR", "WIRE")
_PARAMETER_KINDS = ("GPARAM", "LPARAM")
_LOGICAL = ("LOGAND", "LOGOR", "LOGNOT", "AND", "OR", "XOR", "NOT", "REDAND", "REDOR", "REDXOR")
_INITIAL = ("INITIAL", "INITIALAUTOMATIC", "INITIALSTATIC")
# What Verilator makes of `unique case`: a check of its own.
_ADDED = ("notParallelp",)
# Types whose width their keyword says.
_KEYWORD_WIDTHS = {"int": 32, "integer": 32, "byte": 8, "shortint": 16, "longint": 64}


@dataclass(frozen=True)
class Signal:
    """One vector or bit: an element of an array, or a member of a structure, is one of its own.

    ``bits`` are its bit numbers, empty for a single bit without a range.
    """

    instance: str
    name: str
    bits: range


@dataclass
class Instance:
    """One instance of a module: its path, the numbers among its parameters, its signals.

    ``blocks`` are the labels of the generate blocks in it, without loop indices; ``conditions`` the
    lines that hold a logical operator, ``initial`` those that give a register its value at power-up;
    ``named`` the labels of its statements, as assertions have one.
    """

    path: str
    module: str
    parameters: dict[str, int] = field(default_factory=dict)
    signals: list[Signal] = field(default_factory=list)
    blocks: set[str] = field(default_factory=set)
    conditions: set[int] = field(default_factory=set)
    initial: set[int] = field(default_factory=set)
    named: set[str] = field(default_factory=set)


def _range(text: str) -> range:
    """Return the numbers in a range as Verilator writes it: ``15:0`` or ``[0:2]``, ascending."""
    left, right = (int(number) for number in text.strip("[]").split(":"))
    return range(min(left, right), max(left, right) + 1)


def _referred(node: _Node) -> str:
    """Return the address of the type that a named type or an enumeration stands for."""
    inner = node.get("refDTypep", "UNLINKED")
    return node["dtypep"] if inner == "UNLINKED" else inner


def _constant(node: _Node) -> int | None:
    """Return the value of a constant such as ``32'sh1f``, None for text and the like."""
    match = re.fullmatch(r"(?:\d+)?'s?h([0-9a-f]+)", node.get("name", ""))
    return int(match[1], 16) if match else None


def _nodes(tree: Any) -> Iterator[_Node]:
    """Yield all nodes of a tree, in any order."""
    stack = [tree]
    while stack:
        node = stack.pop()
        if isinstance(node, list):
            stack += node
        elif isinstance(node, dict):
            yield node
            stack += [value for key, value in node.items() if key not in _ADDED]


class _Reader:
    def __init__(self, tree: _Node) -> None:
        self._modules = {module["addr"]: module for module in tree["modulesp"]}
        tables = (node for node in tree["miscsp"] if node["type"] == "TYPETABLE")
        self._types: dict[str, _Node] = {node["addr"]: node for table in tables for node in table["typesp"]}
        # Types are also declared inside modules.
        declared = (node for node in _nodes(tree["modulesp"]) if str(node.get("type", "")).endswith("DTYPE"))
        self._types |= {node["addr"]: node for node in declared}

    def elements(self, name: str, address: str) -> Iterator[tuple[str, range]]:
        """Yield the vectors that a variable of that type consists of, and their bits."""
        node = self._types[address]
        match node["type"]:
            case "BASICDTYPE":
                if "range" in node and node["keyword"] in ("logic", "bit"):
                    yield name, _range(node["range"])
                else:
                    yield name, range(_KEYWORD_WIDTHS.get(node["keyword"], 0))
            case "UNPACKARRAYDTYPE" | "PACKARRAYDTYPE":
                for index in _range(node["declRange"]):
                    yield from self.elements(f"{name}[{index}]", node["refDTypep"])
            case "STRUCTDTYPE":
                for member in node["membersp"]:
                    yield from self.elements(f"{name}.{member['name']}", member["refDTypep"])
            case "REFDTYPE" | "PARAMTYPEDTYPE" | "ENUMDTYPE":
                yield from self.elements(name, _referred(node))
            case other:
                raise InputError(f"{name}: type {other}: unknown to the reader of the elaborated design")

    def instances(self, path: str, module: _Node) -> Iterator[Instance]:
        """Yield the instance and those inside it."""
        # A place reads file, first line:column, last line:column; a bound instance stands in another file.
        file = module["loc"].split(",")[0]
        places = [
            (node["type"], int(place[1].partition(":")[0]))
            for node in _nodes(module["stmtsp"])
            if (place := str(node.get("loc", "")).split(","))[0] == file and self._is_placed(node)
        ]
        found = Instance(path, module["origName"])
        found.initial = {line for kind, line in places if kind not in _LOGICAL}
        found.conditions = {line for kind, line in places if kind in _LOGICAL}
        cells: list[tuple[str, str]] = []
        self._collect(module["stmtsp"], "", found, cells)
        yield found
        for name, address in cells:
            yield from self.instances(f"{path}.{name}", self._modules[address])

    def _is_placed(self, node: _Node) -> bool:
        """Return whether it is an initial value or a logical operator on bits: of vectors, toggles tell."""
        kind = node.get("type")
        return kind in _INITIAL or (kind in _LOGICAL and not self._is_vector(node.get("dtypep")))

    def _is_vector(self, address: str | None) -> bool:
        node = self._types.get(address or "", {})
        if node.get("type") == "REFDTYPE":
            return self._is_vector(_referred(node))
        return node.get("type") == "BASICDTYPE" and "range" in node and len(_range(node["range"])) > 1

    def _collect(
        self, nodes: list[_Node], prefix: str, found: Instance, cells: list[tuple[str, str]]
    ) -> None:
        """Add what nodes hold to an instance, and the instances inside it to ``cells``: name, module."""
        for node in nodes:
            match node["type"]:
                case "GENBLOCK":
                    if not node.get("implied"):
                        found.blocks.add(node["name"].partition("[")[0])
                    # The block around an `else if` has no name, and no place in a path.
                    inner = f"{prefix}{node['name']}." if node["name"] else prefix
                    self._collect(node["itemsp"], inner, found, cells)
                case "BEGIN":
                    found.named.add(node["name"])
                case "CELL":
                    cells.append((prefix + node["name"], node["modp"]))
                case "VAR" if node["varType"] in _SIGNAL_KINDS:
                    vectors = self.elements(prefix + node["name"], node["dtypep"])
                    found.signals += [Signal(found.path, name, bits) for name, bits in vectors]
                case "VAR" if node["varType"] in _PARAMETER_KINDS and not prefix:
                    value = _constant(node["valuep"][0]) if node.get("valuep") else None
                    if value is not None:
                        found.parameters[node["name"]] = value
                case _:
                    pass


def read_elaboration(path: Path, top: str) -> dict[str, Instance]:
    """Return the instances under the module ``top``, by their path, in the order of the design."""
    try:
        tree = json.loads(path.read_text())
        module = next(module for module in tree["modulesp"] if module["origName"] == top)
        found = list(_Reader(tree).instances(f"{_TOP}.{top}", module))
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot read: {error.strerror or error}") from error
    except (ValueError, KeyError, TypeError, StopIteration) as error:
        raise InputError(f"{path}: not an elaborated design with a module {top}, or damaged") from error
    return {instance.path: instance for instance in found}
