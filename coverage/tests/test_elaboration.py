"""The design as Verilator elaborates it: instances, the bits of their signals, parameters and conditions."""

import json

import pytest

from triaxis.coverage.elaboration import read_elaboration
from triaxis.golden.errors import InputError


def variable(name, kind, dtype, **more):
    return {"type": "VAR", "name": name, "varType": kind, "dtypep": dtype, "loc": "a,1:1,1:2", **more}


def block(name, *items, **more):
    return {"type": "GENBLOCK", "name": name, "itemsp": list(items), **more}


TYPES = [
    {"type": "BASICDTYPE", "addr": "bit", "keyword": "logic"},
    {"type": "BASICDTYPE", "addr": "byte", "keyword": "logic", "range": "7:0"},
    {"type": "REFDTYPE", "addr": "ref", "dtypep": "byte", "refDTypep": "UNLINKED"},
    {"type": "UNPACKARRAYDTYPE", "addr": "array", "declRange": "[3:4]", "refDTypep": "ref"},
    {"type": "PACKARRAYDTYPE", "addr": "packed", "declRange": "[1:0]", "refDTypep": "byte"},
    {"type": "ENUMDTYPE", "addr": "enum", "refDTypep": "byte"},
    {"type": "STRUCTDTYPE", "addr": "struct",
     "membersp": [{"name": "near", "refDTypep": "bit"}, {"name": "axis", "refDTypep": "byte"}]},
]  # fmt: skip
LEAF = [
    variable("N", "GPARAM", "byte", valuep=[{"name": "32'sh1f"}]),
    variable("result", "VAR", "struct"),
    {"type": "ALWAYS", "stmtsp": [
        {"type": "LOGAND", "loc": "a,17:3,17:9"},
        # Operators on vectors and checks of cases are no conditions.
        {"type": "AND", "loc": "a,3:1,3:9", "dtypep": "ref"},
        {"type": "AND", "loc": "a,4:1,4:9", "dtypep": "bit"},
        # What is bound to the module stands elsewhere.
        {"type": "LOGOR", "loc": "b,6:3,6:9"},
        {"type": "INITIALSTATIC", "loc": "a,12:1,12:9"},
        {"type": "CASE", "loc": "a,5:1,9:9", "notParallelp": [{"type": "NOT", "loc": "a,5:1,5:9"}]},
    ]},
]  # fmt: skip
TOP = [
    variable("clk_i", "PORT", "bit"),
    variable("table_q", "VAR", "array"),
    variable("state_q", "VAR", "enum"),
    block("g_x", variable("i", "GENVAR", "byte"), implied=True),
    block("g_x[2]", variable("x", "VAR", "packed"), {"type": "CELL", "name": "u_leaf", "modp": "leaf"}),
]


def test_instances_signals_parameters_and_conditions(tmp_path):
    modules = [
        {"type": "MODULE", "addr": n, "origName": n, "loc": "a,1:8,1:9", "stmtsp": s}
        for n, s in (("top", TOP), ("leaf", LEAF))
    ]
    path = tmp_path / "tree.json"
    path.write_text(json.dumps({"modulesp": modules, "miscsp": [{"type": "TYPETABLE", "typesp": TYPES}]}))
    instances = read_elaboration(path, "top")
    assert list(instances) == ["TOP.top", "TOP.top.g_x[2].u_leaf"]
    top, leaf = instances.values()
    assert [(s.name, len(s.bits)) for s in top.signals] == [
        ("clk_i", 0), ("table_q[3]", 8), ("table_q[4]", 8), ("state_q", 8),
        ("g_x[2].x[0]", 8), ("g_x[2].x[1]", 8),
    ]  # fmt: skip
    assert [(s.name, s.bits) for s in leaf.signals] == [("result.near", range(0)), ("result.axis", range(8))]
    assert (leaf.module, leaf.parameters, leaf.conditions) == ("leaf", {"N": 31}, {4, 17})
    assert (leaf.initial, top.initial) == ({12}, set())
    assert (top.conditions, top.blocks) == (set(), {"g_x"})
    with pytest.raises(InputError, match="with a module other"):
        read_elaboration(path, "other")
    path.write_text(path.read_text()[:-20])
    with pytest.raises(InputError, match="damaged"):
        read_elaboration(path, "top")
