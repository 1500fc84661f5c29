"""Waivers: read, refused where not well formed, and of what bits they say are constant."""

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from triaxis.coverage.waivers import BoundError, Waiver, evaluate, fit, read_waivers
from triaxis.golden.errors import InputError

GOOD = """
[[waiver]]
category = "bounded"
kind = "toggle"
modules = ["m"]
signals = ["s[{k}]"]
range = ["0", "2**W - 1 - k"]
reason = "A reason that is long enough to be one."
owner = "dut"
reviewed = "0123456789ab"
"""


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "waivers.toml"
    path.write_text(text)
    return path


def waiver(low: str, high: str, step: str = "1", where: str = "1") -> Waiver:
    given = Waiver(1, "bounded", "because", "dut", "0123456789ab", "toggle", ("m",), signals=("s",))
    return replace(given, values=(low, high), step=step, where=where)


def test_those_of_the_core_are_well_formed() -> None:
    waivers = read_waivers()
    assert waivers and all(len(w.reason) > 30 for w in waivers)


def test_a_file_is_read(tmp_path: Path) -> None:
    [read] = read_waivers(written(tmp_path, GOOD))
    assert read.reviewed == "0123456789ab"
    assert read.constant_bits("s[1]", range(6), {"W": 4}) == [4, 5]
    assert read.constant_bits("other", range(6), {"W": 4}) == []


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('owner = "dut"', "", "owner is missing"),
        ('"dut"', '" "', "owner: must be a text"),
        ('"bounded"', '"because"', "category because: one of: constant by contract, .*elaboration guard"),
        ('"toggle"', '"toggles"', "kind toggles"),
        ('modules = ["m"]', "modules = []", "modules: must be a list"),
        ("A reason that is long enough to be one.", "known", "say why"),
        ("range = ", "rnage = ", "rnage: no such field"),
        ("range = ", "bits = ['1']\nrange = ", "either `range` or `bits`"),
        ("signals = ", "what = ", "either `range` or `bits`"),
        ('"toggle"', '"line"', "no toggle waiver"),
        ("[[waiver]]", "[[weaver]]", "nothing else"),
    ],
)
def test_what_is_not_well_formed_is_named(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in GOOD
    with pytest.raises(InputError, match=said) as caught:
        read_waivers(written(tmp_path, GOOD.replace(old, new)))
    assert "\n" not in str(caught.value) and "waivers.toml: " in str(caught.value)


@given(st.integers(-70, 70), st.integers(0, 140), st.integers(0, 4))
def test_constant_bits_are_those_that_no_value_changes(low: int, span: int, log_step: int) -> None:
    step, high, width = 1 << log_step, low + span, 9
    values = [value for value in range(low, high + 1) if value % step == 0]
    constant = waiver(str(low), str(high), str(step)).constant_bits("s", range(width), {})
    for bit in range(width):
        changes = len({value >> bit & 1 for value in values}) > 1
        # Never more is waived than no value changes; without a step, exactly that.
        assert not (changes and bit in constant)
        assert step > 1 or changes == (bit not in constant)


def test_bits_that_are_listed_must_exist() -> None:
    listed = replace(waiver("0", "0"), values=None, bits=("2..3", "W - 1"))
    assert listed.constant_bits("s", range(8), {"W": 8}) == [2, 3, 7]
    with pytest.raises(BoundError, match="s has no bit 8"):
        listed.constant_bits("s", range(8), {"W": 9})


@pytest.mark.parametrize(
    ("high", "where", "bits", "parameters", "constant"),
    [
        # A signal without range has bit 0; others are numbered as declared; a condition must hold.
        ("0", "1", range(0), {}, [0]),
        ("1", "1", range(0), {}, []),
        ("3", "1", range(14, 18), {}, [16, 17]),
        ("0", "M == 0", range(2), {"M": 4}, []),
        ("0", "M == 0", range(2), {"M": 0}, [0, 1]),
    ],
)
def test_constant_bits(
    high: str, where: str, bits: range, parameters: dict[str, int], constant: list[int]
) -> None:
    assert waiver("0", high, where=where).constant_bits("s", bits, parameters) == constant


@pytest.mark.parametrize(
    ("low", "high", "step"), [("1", "0", "1"), ("0", "9", "3"), ("0", "9", "0"), ("x", "1", "1")]
)
def test_a_bound_that_makes_no_sense_is_an_error(low: str, high: str, step: str) -> None:
    with pytest.raises(ValueError):
        waiver(low, high, step).constant_bits("s", range(4), {})


def test_patterns() -> None:
    assert fit(("top.g[{i}].*.u_{n}",), "top.g[12].a.b.u_3") == {"i": 12, "n": 3}
    assert fit(("top.g[{i}]",), "top.g[x]") is None
    assert fit(("a", "b*"), "bc") == {}
    assert fit(("a",), "ab") is None


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3 * L**3 + 1", 3 * 7**3 + 1),
        ("-(L // 2) % 4", -(7 // 2) % 4),
        ("1 << W", 8),
        ("L >> 1", 3),
        ("2 + (W > 2)", 3),
        ("W == 3 and not L == 3", 1),
        ("W == 4 or 0", 0),
    ],
)
def test_values(text: str, value: int) -> None:
    assert evaluate(text, {"W": 3, "L": 7}) == value


@pytest.mark.parametrize(
    "text",
    ["L", "1 +", "open('x')", "W.real", "1.5", "W / 2", "1 // 0", "1 << -1", "'a'", "2**-1", "[1]"],
)
def test_what_is_no_whole_number_arithmetic_is_refused(text: str) -> None:
    with pytest.raises(BoundError):
        evaluate(text, {"W": 3})
