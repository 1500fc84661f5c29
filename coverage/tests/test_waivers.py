"""Waivers: refused where not well formed; a waiver whose bin is hit or whose RTL changed is a problem."""

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.core_exclusions import ARGUMENTS
from triaxis.coverage.cover_model import Kind
from triaxis.coverage.waiver_upkeep import other_rtl, waiver_problems, waiver_records
from triaxis.coverage.waivers import (
    WAIVERS,
    BoundError,
    Waiver,
    confirm_waivers,
    evaluate,
    fit,
    module_code,
    read_waivers,
)
from triaxis.golden.errors import InputError
from triaxis.sim.configuration import Configuration

ROOT = Path(__file__).resolve().parents[2]
CORES = (
    Configuration(8),
    Configuration(8, 8),
    Configuration(edge_box=False),
    Configuration(13, 4, gating=False),
    Configuration(gating=False),
    Configuration(32, 32),
)


GOOD = """
[[waiver]]
category = "bounded"
kind = "toggle"
modules = ["m"]
signals = ["s[{k}]"]
range = ["0", "2**W - 1 - k"]
reason = "A reason that is long enough to be one."
"""


def waiver(low, high, step="1", where="1"):
    given = Waiver(1, "bounded", "because", "toggle", ("m",), signals=("s",))
    return replace(given, values=(low, high), step=step, where=where)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('kind = "toggle"', "", "kind is missing"),
        ('"bounded"', '"because"', "category because: one of: constant by contract, .*elaboration guard"),
        ('modules = ["m"]', "modules = []", "modules: must be a list"),
        ("A reason that is long enough to be one.", "known", "say why"),
        ("range = ", "rnage = ", "rnage: no such field"),
        ("range = ", "bits = ['1']\nrange = ", "either `range` or `bits`"),
        ('"toggle"', '"line"', "no toggle waiver"),
        ("[[waiver]]", "[[weaver]]", "nothing else"),
        ('"2**W - 1 - k"]', "]", "range: must be two texts, the smallest and the largest value"),
        ('"s[{k}]"', '"s[{k}][{k}]"', r"waiver 1: signals: s\[{k}\]\[{k}\]: redefinition of .*: no pattern"),
        ('"toggle"', '"togle"', "waiver 1: kind togle: one of: line, branch"),
        ('kind = "toggle"', "kind = 5", "waiver 1: kind: must be a text"),
        ("range = ", "let = 5\nrange = ", "waiver 1: let: must be a table"),
        (GOOD, "waiver = [1]", "waiver 1: must be a table"),
        ("[[waiver]]", "[reviewed]\nm = 5\n[[waiver]]", "waivers.toml: reviewed: must be a text"),
        ("[[waiver]]", "[[waiver]", "waivers.toml: not TOML"),
    ],
)
def test_what_is_not_well_formed_is_named(tmp_path, old, new, said):
    path = tmp_path / "waivers.toml"
    path.write_text(GOOD)
    [read] = read_waivers(path)
    assert read.constant_bits("s[1]", range(6), {"W": 4}) == [4, 5]
    assert read.constant_bits("other", range(6), {"W": 4}) == []
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(InputError, match=said) as error:
        read_waivers(path)
    assert waiver_problems(None, path) == [str(error.value)]


@given(st.integers(-70, 70), st.integers(0, 140), st.integers(0, 4))
def test_constant_bits_are_those_that_no_value_changes(low, span, log_step):
    step, high, width = 1 << log_step, low + span, 9
    values = [value for value in range(low, high + 1) if value % step == 0]
    constant = waiver(str(low), str(high), str(step)).constant_bits("s", range(width), {})
    for bit in range(width):
        changes = len({value >> bit & 1 for value in values}) > 1
        # Never more is waived than no value changes; without a step, exactly that.
        assert not (changes and bit in constant)
        assert step > 1 or changes == (bit not in constant)


def test_constant_bits():
    for high, where, bits, parameters, constant in (
        # A signal without range has bit 0; others are numbered as declared; a condition must hold.
        ("0", "1", range(0), {}, [0]),
        ("1", "1", range(0), {}, []),
        ("3", "1", range(14, 18), {}, [16, 17]),
        ("0", "M == 0", range(2), {"M": 4}, []),
        ("0", "M == 0", range(2), {"M": 0}, [0, 1]),
    ):
        assert waiver("0", high, where=where).constant_bits("s", bits, parameters) == constant
    for low, high, step in (("1", "0", "1"), ("0", "9", "3"), ("0", "9", "0"), ("x", "1", "1")):
        with pytest.raises(ValueError):
            waiver(low, high, step).constant_bits("s", range(4), {})
    listed = replace(waiver("0", "0"), values=None, bits=("2..3", "W - 1"))
    assert listed.constant_bits("s", range(8), {"W": 8}) == [2, 3, 7]
    # A name may be made of those before it.
    named = replace(listed, bits=("b..b + 1",), let={"a": "W // 4", "b": "2 * a"})
    assert named.constant_bits("s", range(8), {"W": 8}) == [4, 5]
    with pytest.raises(BoundError, match="s has no bit 8"):
        listed.constant_bits("s", range(8), {"W": 9})


def test_patterns_and_whole_number_arithmetic():
    assert fit(("top.g[{i}].*.u_{n}",), "top.g[12].a.b.u_3") == {"i": 12, "n": 3}
    assert fit(("a", "b*"), "bc") == {}
    assert fit(("top.g[{i}]",), "top.g[x]") is None is fit(("a",), "ab")
    assert evaluate("-(L // 2) % 4 + 3 * L**3 + (1 << W) + (W > 2)", {"W": 3, "L": 7}) == 1 + 1029 + 8 + 1
    assert evaluate("W == 3 and not L == 3 or 0", {"W": 3, "L": 7}) == 1
    for text in ("x", "1 +", "open('x')", "W.real", "1.5", "W / 2", "1 // 0", "1 << -1", "'a'", "2**-1"):
        with pytest.raises(BoundError) as error:
            evaluate(text, {"W": 3})
        assert str(error.value).count(text) == 1


def records():
    """What a measurement with the waivers of the core records."""
    waivers = read_waivers()
    return waiver_records(waivers, {waiver.number: 1 for waiver in waivers})


def test_those_of_the_core_hold_until_their_modules_change(tmp_path):
    assert waiver_problems(records()) == waiver_problems(None) == []
    path, source = tmp_path / "waivers.toml", tmp_path / "triaxis_core.sv"
    path.write_text(WAIVERS.read_text())
    source.write_text("module triaxis_core; endmodule\n")
    own = [waiver for waiver in read_waivers() if waiver.modules == ("triaxis_core",)]
    assert own and all(other_rtl(waiver, module_code(tmp_path)) for waiver in own)
    # Read again, which is written down; a comment voids nothing, code does.
    assert confirm_waivers(path, tmp_path) == len(read_waivers())
    [first, *_] = [waiver for waiver in read_waivers(path) if waiver.modules == ("triaxis_core",)]
    source.write_text("// A comment.\nmodule triaxis_core;\nendmodule\n")
    assert other_rtl(first, module_code(tmp_path)) is None
    source.write_text("module triaxis_core; wire a; endmodule\n")
    assert "--confirm-waivers" in (other_rtl(first, module_code(tmp_path)) or "")
    # So does what it includes.
    source.write_text('module triaxis_core;\n  `include "a.svh"\nendmodule\n')
    assert confirm_waivers(path, tmp_path) > 0
    [first, *_] = [waiver for waiver in read_waivers(path) if waiver.modules == ("triaxis_core",)]
    (tmp_path / "a.svh").write_text("// A comment.\n")
    assert other_rtl(first, module_code(tmp_path)) is None
    (tmp_path / "a.svh").write_text("wire b;\n")
    assert "--confirm-waivers" in (other_rtl(first, module_code(tmp_path)) or "")
    named = replace(first, rests_on=("triaxis_croe",))
    assert other_rtl(named, module_code()) == "triaxis_croe: no such module: correct its name"


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda r: r.pop(), "waivers, measured with"),
        (lambda r: r[0].update(owner="nobody"), "waiver 1 (toggle, triaxis_core): owner changed since"),
        (lambda r: r[0].pop("step"), "waiver 1 (toggle, triaxis_core): recorded without step"),
        (lambda r: r[1].update(bins=0), "waiver 2 (toggle, triaxis_mesh): covers no bin"),
    ],
)
def test_waivers_that_are_not_those_measured_are_a_problem(spoil, said):
    changed = records()
    spoil(changed)
    [problem] = waiver_problems(changed)
    assert said in problem


@pytest.mark.parametrize("core", CORES, ids=lambda core: core.name)
def test_every_exclusion_is_illegal_proved_owned_and_of_some_bin(core):
    for item in core_model(core).items:
        used = {id(one.exclusion) for one in item.bins}
        for exclusion in item.exclusions:
            assert exclusion.kind is Kind.ILLEGAL
            assert exclusion.category in ARGUMENTS and exclusion.owner and len(exclusion.reason) > 30
            assert id(exclusion) in used, f"{item.name}: excludes no bin: {exclusion.reason}"
            file, _, test = exclusion.test.partition("::")
            assert f"def {test}(" in (ROOT / file).read_text()
