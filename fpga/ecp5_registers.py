"""Moves registers beside a multiplier into the multiplier's block, in a netlist for the ECP5.

Blocks of both vendors have registers before and behind the multiplier. Vendors' tools use them, and yosys
does for the 7 series, but not for the ECP5: there it leaves all of them in the fabric, and the way to
and from the block is then the slowest of the design. Only plain registers move: no enable, no reset.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

_BLOCK, _REGISTER = "MULT18X18D", "TRELLIS_FF"
_OPERAND_BITS, _PRODUCT_BITS = 18, 36


@dataclass(frozen=True)
class Absorbed:
    """How many blocks there are, and how many of them took registers before and behind the multiplier."""

    blocks: int
    before: int
    behind: int


@dataclass
class _Netlist:
    """The cells of a module, what drives each net, and which pins each net drives."""

    cells: dict[str, Any]
    driver: dict[int, str] = field(default_factory=dict)
    users: defaultdict[int, set[tuple[str, str]]] = field(default_factory=lambda: defaultdict(set))

    def register_behind(self, net: int) -> str | None:
        """Return the plain register that alone takes a net."""
        if len(self.users[net]) != 1:
            return None
        ((name, pin),) = self.users[net]
        return name if pin == "DI" and self._is_plain(name) else None

    def register_before(self, net: int | str) -> str | None:
        """Return the plain register that drives a net."""
        name = self.driver.get(net) if isinstance(net, int) else None
        return name if name is not None and self._is_plain(name) else None

    def _is_plain(self, name: str) -> bool:
        cell = self.cells.get(name, {})
        if cell.get("type") != _REGISTER:
            return False
        parameters, pins = cell["parameters"], cell["connections"]
        return (
            parameters["CEMUX"] == "1 "
            and parameters["CLKMUX"] == "CLK"
            and parameters["LSRMUX"] == "LSR"
            and pins.get("LSR", ["0"]) == ["0"]
        )


def absorb_registers(module: dict[str, Any]) -> Absorbed:
    """Move registers into the blocks of a module, a flat netlist of yosys's ``write_json``, in place.

    A register that others need too stays, beside its copy in the block.
    """
    netlist = _read(module)
    blocks = [cell for cell in netlist.cells.values() if cell["type"] == _BLOCK]
    behind = sum(_absorb_behind(netlist, block) for block in blocks)
    before = sum(_absorb_before(netlist, block) for block in blocks)
    for name, cell in list(netlist.cells.items()):
        if cell["type"] == _REGISTER and not netlist.users[cell["connections"]["Q"][0]]:
            del netlist.cells[name]
    return Absorbed(len(blocks), before, behind)


def _read(module: dict[str, Any]) -> _Netlist:
    netlist = _Netlist(module["cells"])
    for name, cell in netlist.cells.items():
        for pin, nets in cell["connections"].items():
            for net in nets:
                if not isinstance(net, int):
                    continue
                if cell["port_directions"][pin] == "output":
                    netlist.driver[net] = name
                else:
                    netlist.users[net].add((name, pin))
    for name, port in module["ports"].items():
        for net in port["bits"]:
            netlist.users[net].add((name, "port"))
    return netlist


def _bits(block: dict[str, Any], port: str, width: int) -> Iterator[tuple[str, int | str]]:
    """Return the connected pins of a port of a block, and their nets or constants."""
    for place in range(width):
        for net in block["connections"].get(f"{port}{place}", []):
            yield f"{port}{place}", net


def _absorb_behind(netlist: _Netlist, block: dict[str, Any]) -> bool:
    product = [
        (pin, net)
        for pin, net in _bits(block, "P", _PRODUCT_BITS)
        if isinstance(net, int) and netlist.users[net]
    ]
    names = [netlist.register_behind(net) for _, net in product]
    registers = [netlist.cells[name] for name in names if name is not None]
    if not registers or len(registers) != len(product) or not _one_clock(block, registers):
        return False
    for (pin, _), name, register in zip(product, names, registers, strict=True):
        block["connections"][pin] = register["connections"]["Q"]
        del netlist.cells[str(name)]
    _clock(block, registers[0], ("OUTPUT",))
    return True


def _absorb_before(netlist: _Netlist, block: dict[str, Any]) -> bool:
    operands = [*_bits(block, "A", _OPERAND_BITS), *_bits(block, "B", _OPERAND_BITS)]
    # A register does not change a constant.
    pins = [(pin, net) for pin, net in operands if isinstance(net, int)]
    names = [netlist.register_before(net) for _, net in pins]
    registers = [netlist.cells[name] for name in names if name is not None]
    if not registers or len(registers) != len(pins) or not _one_clock(block, registers):
        return False
    own = next(name for name, cell in netlist.cells.items() if cell is block)
    for (pin, old), register in zip(pins, registers, strict=True):
        new = register["connections"]["DI"]
        block["connections"][pin] = new
        netlist.users[old].discard((own, pin))
        if isinstance(new[0], int):
            netlist.users[new[0]].add((own, pin))
    _clock(block, registers[0], ("INPUTA", "INPUTB"))
    return True


def _one_clock(block: dict[str, Any], registers: list[dict[str, Any]]) -> bool:
    clocks = [register["connections"]["CLK"] for register in registers]
    return all(clock == block["connections"].get("CLK0", clocks[0]) for clock in clocks)


def _clock(block: dict[str, Any], register: dict[str, Any], places: tuple[str, ...]) -> None:
    """Use the block's own registers: always enabled, never reset."""
    pins = {"CLK0": register["connections"]["CLK"], "CE0": ["1"], "RST0": ["0"]}
    block["connections"].update(pins)
    block["port_directions"].update(dict.fromkeys(pins, "input"))
    for place in places:
        block["parameters"].update({f"REG_{place}_{pin[:-1]}": pin for pin in pins})
