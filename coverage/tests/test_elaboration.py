import json
from pathlib import Path
from typing import Any

import pytest

from triaxis.coverage.elaboration import read_elaboration
from triaxis.golden.errors import InputError


def variable(name: str, kind: str, dtype: str, **more: Any) -> dict[str, Any]:
    return {"type": "VAR", "name": name, "varType": kind, "dtypep": dtype, "loc": "a,1:1,1:2", **more}


TYPES = [
    {"type": "BASICDTYPE", "addr": "bit", "keyword": "logic"},
    {"type": "BASICDTYPE", "addr": "byte", "keyword": "logic", "range": "7:0"},
    {"type": "REFDTYPE", "addr": "ref", "dtypep": "byte", "refDTypep": "UNLINKED"},
    {"type": "UNPACKARRAYDTYPE", "addr": "array", "declRange": "[3:4]", "refDTypep": "ref"},
    {
        "type": "STRUCTDTYPE",
        "addr": "struct",
        "membersp": [{"name": "near", "refDTypep": "bit"}, {"name": "axis", "refDTypep": "byte"}],
    },
]
LEAF = {
    "type": "MODULE",
    "addr": "leaf",
    "origName": "leaf",
    "stmtsp": [
        variable("N", "GPARAM", "byte", valuep=[{"name": "32'sh1f"}]),
        variable("result", "VAR", "struct"),
        {"type": "ALWAYS", "stmtsp": [{"type": "LOGAND", "loc": "a,17:3,17:9"}]},
    ],
}
TOP = {
    "type": "MODULE",
    "addr": "top",
    "origName": "top",
    "stmtsp": [
        variable("clk_i", "PORT", "bit"),
        variable("table_q", "VAR", "array"),
        {"type": "GENBLOCK", "name": "g_x", "implied": True, "itemsp": [variable("i", "GENVAR", "byte")]},
        {
            "type": "GENBLOCK",
            "name": "g_x[2]",
            "itemsp": [variable("inner", "VAR", "bit"), {"type": "CELL", "name": "u_leaf", "modp": "leaf"}],
        },
    ],
}


def design(tmp_path: Path, **changes: Any) -> Path:
    tree = {"modulesp": [TOP, LEAF], "miscsp": [{"type": "TYPETABLE", "typesp": TYPES}], **changes}
    path = tmp_path / "tree.json"
    path.write_text(json.dumps(tree))
    return path


def test_instances_signals_and_parameters(tmp_path: Path) -> None:
    instances = read_elaboration(design(tmp_path), "top")
    assert list(instances) == ["TOP.top", "TOP.top.g_x[2].u_leaf"]
    top, leaf = instances.values()
    assert [(s.name, s.bits) for s in top.signals] == [
        ("clk_i", range(0)),
        ("table_q[3]", range(8)),
        ("table_q[4]", range(8)),
        ("g_x[2].inner", range(0)),
    ]
    assert [(s.name, s.bits) for s in leaf.signals] == [("result.near", range(0)), ("result.axis", range(8))]
    assert leaf.parameters == {"N": 31}
    assert (leaf.module, leaf.conditions, top.conditions) == ("leaf", {17}, set())
    assert top.blocks == {"g_x"}


@pytest.mark.parametrize(
    ("of", "signals"),
    [
        ({"type": "PACKARRAYDTYPE", "declRange": "[1:0]"}, ["x[0]", "x[1]"]),
        ({"type": "ENUMDTYPE"}, ["x"]),
    ],
)
def test_types_made_of_others_have_the_bits_of_these(
    tmp_path: Path, of: dict[str, Any], signals: list[str]
) -> None:
    types = [*TYPES, {"addr": "made", "refDTypep": "byte", **of}]
    tree = {
        "modulesp": [{**TOP, "stmtsp": [variable("x", "VAR", "made")]}],
        "miscsp": [{"type": "TYPETABLE", "typesp": types}],
    }
    found = read_elaboration(design(tmp_path, **tree), "top")["TOP.top"]
    assert [(s.name, s.bits) for s in found.signals] == [(name, range(8)) for name in signals]


def test_operators_on_vectors_and_checks_of_cases_are_no_conditions(tmp_path: Path) -> None:
    masks = {"type": "AND", "loc": "a,3:1,3:9", "dtypep": "ref"}
    bits = {"type": "AND", "loc": "a,4:1,4:9", "dtypep": "bit"}
    case = {"type": "CASE", "loc": "a,5:1,9:9", "notParallelp": [{"type": "NOT", "loc": "a,5:1,5:9"}]}
    module = {**TOP, "stmtsp": [{"type": "ALWAYS", "stmtsp": [masks, bits, case]}]}
    assert read_elaboration(design(tmp_path, modulesp=[module]), "top")["TOP.top"].conditions == {4}


def test_what_is_no_design_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="with a module other"):
        read_elaboration(design(tmp_path), "other")
    path = tmp_path / "tree.json"
    path.write_text(path.read_text()[:-20])
    with pytest.raises(InputError, match="damaged"):
        read_elaboration(path, "top")
    with pytest.raises(InputError, match="cannot read"):
        read_elaboration(tmp_path / "none.json", "top")
