import json

import pytest

from triaxis.fpga.logic_depth import LogicDepth, LogicPath, Tightest, logic_depth
from triaxis.golden.errors import InputError

_OUTPUTS = {"O", "Q", "P", "CO", "PCOUT", "DOA", "DOADO", "DOPADOP"}


class _Module:
    """Makes netlists as yosys writes them; nets are named by letters."""

    def __init__(self):
        self.nets: dict[str, int] = {}
        self.cells: dict[str, dict] = {}

    def net(self, name: str) -> int | str:
        return name if name in ("0", "1", "x") else self.nets.setdefault(name, len(self.nets) + 2)

    def add(self, kind: str, parameters: dict[str, int] | None = None, **pins: str) -> None:
        self.cells[f"c{len(self.cells)}"] = {
            "type": kind,
            "parameters": {key: f"{value:032b}" for key, value in (parameters or {}).items()},
            "port_directions": {pin: "output" if pin in _OUTPUTS else "input" for pin in pins},
            "connections": {pin: [self.net(net) for net in nets.split()] for pin, nets in pins.items()},
        }

    def register(self, d: str, q: str) -> None:
        self.add("FDRE", D=d, Q=q, C="clk", CE="1", R="0")

    def depth(self, folder) -> LogicDepth:
        module = {
            "attributes": {"top": "1"},
            "ports": {},
            "cells": self.cells,
            "netnames": {name: {"bits": [net], "hide_name": 0} for name, net in self.nets.items()},
        }
        path = folder / "netlist.json"
        path.write_text(json.dumps({"modules": {"m": module}}))
        return logic_depth(path)


def tightest(module: _Module, folder) -> Tightest:
    """Return the tightest path at 200 MHz."""
    return next(clock for clock in module.depth(folder).tightest if clock.mhz == 200)


def test_the_longest_chain_and_its_registers_are_named(tmp_path):
    module = _Module()
    module.register("in", "a_q")
    module.add("LUT2", I0="a_q", I1="a_q", O="x1")
    module.add("MUXF7", I0="x1", I1="a_q", S="a_q", O="x2")
    module.register("x2", "b_q")
    module.add("LUT1", I0="b_q", O="x3")
    module.register("x3", "c_q")
    found = module.depth(tmp_path)
    # From the register to the table runs a wire; the others do not leave the slice.
    assert found.most_levels == LogicPath("a_q", "b_q", ("LUT2", "MUXF7"), 2, cells_ns=0.782, wires=1)
    limits = [(clock.mhz, clock.wire_ns, clock.path) for clock in found.tightest]
    assert limits == [(100, 9.218, found.most_levels), (200, 4.218, found.most_levels)]


def branching() -> _Module:
    """Return a table between registers, of which two take what it gives."""
    module = _Module()
    module.register("in", "a_q")
    module.add("LUT1", I0="a_q", O="x1")
    module.register("x1", "b_q")
    module.register("x1", "c_q")
    return module


def test_a_net_that_several_take_is_a_wire(tmp_path):
    found = tightest(branching(), tmp_path)
    assert (found.path.cells_ns, found.path.wires, found.wire_ns) == (0.486, 2, 2.257)


def test_the_tightest_path_is_not_always_that_of_most_wires(tmp_path):
    module = branching()
    module.add("DSP48E1", {"AREG": 1, "BREG": 1, "MREG": 0, "PREG": 0}, A="0", P="p", CLK="clk")
    module.register("p", "d_q")
    assert module.depth(tmp_path).most_levels.end == "b_q"
    found = tightest(module, tmp_path)
    assert (found.path.end, found.path.wires, found.wire_ns) == ("d_q", 1, 0.991)


def test_a_carry_chain_is_one_level_as_many_cells_and_runs_upwards_only(tmp_path):
    module = _Module()
    module.register("in", "a_q")
    module.add("LUT1", I0="a_q", O="late")
    module.add(
        "CARRY4", CI="0", CYINIT="0", S="a_q a_q a_q late", DI="0 0 0 0", O="o0 o1 o2 o3", CO="u v w k"
    )
    module.register("o0", "b_q")
    assert tightest(module, tmp_path).path.cells == ("CARRY4",)
    module.add("CARRY4", CI="k", CYINIT="0", S="a_q a_q a_q a_q", DI="0 0 0 0", O="p0 p1 p2 p3")
    module.register("p3", "c_q")
    levels = module.depth(tmp_path).most_levels
    assert (levels.cells, levels.levels) == (("LUT1", "CARRY4", "CARRY4"), 2)
    # A lower bit of the first takes longer to the chain's end than the last one with a table before it.
    assert tightest(module, tmp_path).path == LogicPath("a_q", "c_q", ("CARRY4", "CARRY4"), 1, 1.203, 1)


@pytest.mark.parametrize(
    ("kind", "pins", "cells_ns", "wires"),
    [
        # From a register to what a cell stores, from there to the next register, or through the cell.
        ("RAMB36E1", {"DIADI": "a_q", "CLKARDCLK": "clk"}, 0.362 + 0.737, 1),
        ("RAMB36E1", {"DOADO": "given", "CLKARDCLK": "clk"}, 2.454, 1),
        ("RAMB36E1", {"DOPADOP": "given", "CLKARDCLK": "clk"}, 2.454, 1),
        ("RAM32M", {"DIA": "a_q", "WCLK": "clk"}, 0.362 + 0.654, 1),
        ("RAM32M", {"DOA": "given", "WCLK": "clk"}, 1.472, 1),
        ("RAM32M", {"ADDRA": "late", "DOA": "given", "WCLK": "clk"}, 0.362 + 0.124 + 0.124, 3),
        ("SRLC32E", {"D": "a_q", "CLK": "clk"}, 0.362 + 0.654, 1),
        ("SRLC32E", {"A": "late", "Q": "given", "CLK": "clk"}, 0.362 + 0.124 + 0.124, 3),
        # An inverted reset.
        ("FDCE", {"CLR": "late", "C": "clk"}, 0.362 + 0.124 + 0.404, 2),
        ("DSP48E1", {"P": "given", "CLK": "clk"}, 0.434, 1),
        ("DSP48E1", {"B": "late", "CLK": "clk"}, 0.362 + 0.124 + 0.450, 2),
    ],
)
def test_what_stores_takes_its_time(tmp_path, kind, pins, cells_ns, wires):
    module = _Module()
    module.register("in", "a_q")
    module.add("LUT1", I0="a_q", O="late")
    module.add(kind, {"CREG": 0}, **pins)
    module.register("given", "b_q")
    path = tightest(module, tmp_path).path
    assert (path.cells_ns, path.wires) == (pytest.approx(cells_ns), wires)


def test_a_chain_without_wires_may_be_too_slow(tmp_path):
    module = _Module()
    module.add("DSP48E1", {"MREG": 0, "PREG": 0}, A="0", PCOUT="sum", CLK="clk")
    module.add("DSP48E1", {"AREG": 0, "BREG": 0, "CREG": 0, "MREG": 0}, PCIN="sum", P="p", CLK="clk")
    module.register("p", "b_q")
    found = tightest(module, tmp_path)
    assert (found.path.cells_ns, found.path.wires, found.wire_ns) == (5.829, 0, -0.829)


def test_what_is_no_netlist_of_known_cells_is_refused(tmp_path):
    path = tmp_path / "netlist.json"
    for text in ("", "[]", "null", '{"modules": {}}', '{"modules": {"m": {"attributes": {"top": "1"}}}}'):
        path.write_text(text)
        with pytest.raises(InputError, match="no netlist of one top module"):
            logic_depth(path)
    circle, unknown = _Module(), _Module()
    circle.add("LUT2", I0="u", I1="y", O="y")
    with pytest.raises(InputError, match=r"logic in a circle at y$"):
        circle.depth(tmp_path)
    unknown.add("triaxis_mul", I0="u", O="y")
    with pytest.raises(InputError, match="c0: triaxis_mul: it is not known"):
        unknown.depth(tmp_path)
