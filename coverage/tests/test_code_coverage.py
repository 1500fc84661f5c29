"""Code coverage: everything hit passes, nothing else does; wrong counters and waivers are named."""

from dataclasses import replace
from pathlib import Path

import pytest

from triaxis.coverage.code_counters import FIRST_LINE, LAST_LINE, read_counters
from triaxis.coverage.code_coverage import ModelCoverage, Total, assess_model, conclude, generate_blocks
from triaxis.coverage.elaboration import Instance, Signal
from triaxis.coverage.tests.counter_files import counter_line
from triaxis.coverage.waivers import Waiver
from triaxis.golden.errors import InputError

TOP = "TOP.top"


def line(kind, what, count, path=TOP):
    lines = "7-9" if kind == "line" else ""
    return counter_line(Path("/somewhere/top.sv"), (7, 3, kind, what, lines), path, count)


def prop(module, label, count, path):
    """Return the counter of a cover property: of a module that is bound to the top."""
    return counter_line(
        Path(f"/somewhere/{module}.sv"), (2, 1, "user", label, ""), f"{TOP}.{path}.{label}", count
    )


def toggles(name, rises, falls):
    return [line("toggle", f"{name}:0->1", rises), line("toggle", f"{name}:1->0", falls)]


GOOD = [
    line("line", "block", 5),
    line("line", "elsif", 2),
    line("branch", "if", 1),
    line("expr", "(a==1 && b==1) => 1", 4),
    *toggles("clk_i", 9, 9),
    *toggles("sum[0]", 1, 2),
    *toggles("sum[1]", 3, 4),
    prop("top_states", "Idle_to_Busy", 2, "u_states"),
    prop("top_sva", "HeldAntecedent", 1, "u_sva"),
    prop("top_sva", "KeptAntecedent", 1, "u_sva.g_lane__BRA__3__KET____DOT__g_in"),
]
SIGNALS = [Signal(TOP, "clk_i", range(0)), Signal(TOP, "sum", range(2))]
DESIGN = Instance(TOP, "top", {"W": 4}, SIGNALS, {"g_block"}, {7})
NO_BLOCK = replace(DESIGN, blocks=set())


def file(tmp_path, lines):
    path = tmp_path / "coverage.dat"
    path.write_text("\n".join([FIRST_LINE, *lines, LAST_LINE]) + "\n")
    return path


@pytest.fixture
def assessed(tmp_path):
    """Return a function that assesses counters against a design and waivers."""

    def assess(lines, waivers=(), design=DESIGN):
        model = ModelCoverage("model", read_counters(file(tmp_path, lines)), {TOP: design})
        source = tmp_path / "top.sv"
        source.write_text("module top;\n  if (W == 4) begin : g_block\n  end // begin : g_not\nendmodule\n")
        return conclude(assess_model(model, list(waivers)), generate_blocks([source]), list(waivers))

    return assess


def waiver(**changes):
    usual = Waiver(1, "bounded", "because", "toggle", ("top",), signals=("sum",), bits=("1",))
    made = replace(usual, **changes)
    return made if "reviewed" in changes else replace(made, reviewed=made.hashes({}))


def without(what):
    return [text for text in GOOD if what not in text]


def never(what):
    return [text.rpartition(" ")[0] + " 0" if what in text else text for text in GOOD]


def test_everything_hit_passes(assessed):
    found = assessed(GOOD)
    assert found.passed
    counts = {kind: (total.hit, total.total, total.percent) for kind, total in found.totals.items()}
    expected = {
        "line": 1, "branch": 2, "expression": 1, "toggle": 6, "fsm": 1, "antecedent": 2, "generate": 1,
    }  # fmt: skip
    assert counts == {kind: (count, count, 100.0) for kind, count in expected.items()}
    # A percentage never rounds up to all.
    assert Total(hit=1_880_006, total=1_880_096).percent == 99.99
    assert Total(hit=2, waived=1, total=3).percent == 100


def test_a_bin_that_is_not_hit_fails(assessed):
    for what, kind in (
        ("block", "line"),
        ("elsif", "branch"),
        ("\x02if\x01", "branch"),
        ("=> 1", "expression"),
        ("sum[1]:0->1", "toggle"),
        ("sum[1]:1->0", "toggle"),
    ):
        found = assessed(never(what))
        [bin_] = found.uncovered
        assert (bin_.kind, bin_.file, bin_.line, bin_.instance) == (kind, "top.sv", 7, TOP)
        assert not found.passed and found.totals[kind].percent < 100
    for label, said in (
        ("\x02Idle_to_Busy\x01", f"top_states.sv:2: fsm Idle_to_Busy, {TOP}.u_states, model"),
        ("\x02HeldAntecedent\x01", f"top_sva.sv:2: antecedent Held, {TOP}.u_sva, model"),
        ("\x02KeptAntecedent\x01", f"top_sva.sv:2: antecedent Kept, {TOP}.u_sva.g_lane[3].g_in, model"),
    ):
        assert [str(bin_) for bin_ in assessed(never(label)).uncovered] == [said]


def test_what_happens_at_power_up_is_no_bin(assessed):
    unhit = never("\x02block\x01")
    assert not assessed(unhit).passed
    found = assessed(unhit, design=replace(DESIGN, initial={7}))
    assert found.totals["line"].total == 0 and not found.uncovered


def test_what_is_not_in_the_counters_or_not_in_the_design_fails(assessed):
    for left_out in ("sum[1]:0->1", "sum[1]:1->0", "clk_i"):
        found = assessed(without(left_out))
        assert not found.passed and "has no toggle counters" in found.problems[0]
    assert [bin_.what for bin_ in assessed(without("=> 1")).uncovered] == ["condition without counters"]
    found = assessed([*GOOD, *toggles("sum[2]", 1, 1), line("branch", "if", 1, path="TOP.other")])
    assert len(found.problems) == 2 and all("not in the design" in problem for problem in found.problems)
    [block] = assessed(GOOD, design=NO_BLOCK).uncovered
    assert (block.kind, block.what, block.line) == ("generate", "g_block", 2)


def test_a_waiver_covers_bins(assessed):
    found = assessed(never("sum[1]"), [waiver()])
    assert found.passed and found.waived == {1: 2}
    total = found.totals["toggle"]
    assert (total.hit, total.waived, total.total, total.percent) == (4, 2, 6, 100.0)
    way = waiver(kind="branch", signals=(), bits=(), what=("if",), where="W == 4")
    assert assessed(never("\x02if\x01"), [way]).passed
    assert not assessed(never("\x02if\x01"), [replace(way, where="W == 5")]).passed
    arc = waiver(kind="fsm", modules=("top_states",), signals=(), bits=(), what=("Idle_*",), where="W == 4")
    assert assessed(never("Idle_to_Busy"), [arc]).passed
    # The source is not there to be read: no line fits but with any.
    assert not assessed(never("\x02if\x01"), [replace(way, at=("if (taken)",))]).passed
    block = waiver(kind="generate", signals=(), bits=(), what=("g_*",))
    assert assessed(GOOD, [block], NO_BLOCK).passed


@pytest.mark.parametrize(
    ("unhit", "change", "said"),
    [
        ("sum[1]:0->1", {}, ": is hit: top.sv:7: toggle sum[1]:1->0"),
        ("", {"modules": ("other",)}, "covers no bin"),
        ("", {"models": ("other",)}, "covers no bin"),
        ("", {"signals": ("su",)}, "covers no bin"),
        ("", {"instances": ("TOP.top.*",)}, "covers no bin"),
        # A pattern among others that fits nothing.
        ("sum[1]", {"modules": ("top", "other")}, ": modules: other: fits no bin"),
        ("sum[1]", {"models": ("model", "w9_*")}, ": models: w9_*: fits no bin"),
        ("sum[1]", {"signals": ("sum", "difference")}, ": signals: difference: fits no bin"),
        (
            "\x02if\x01",
            {"kind": "branch", "signals": (), "bits": (), "what": ("if",), "at": ("*", "gone")},
            ": at: gone: fits no bin",
        ),
        ("sum[1]", {"reviewed": {"top": "0"}}, "waiver 1 (toggle, top): its modules changed"),
    ],
)
def test_a_waiver_that_does_not_hold_fails(assessed, unhit, change, said):
    found = assessed(never(unhit) if unhit else GOOD, [waiver(**change)])
    assert not found.passed and [said in problem for problem in found.problems] == [True]


def test_a_waiver_of_an_unknown_parameter_is_refused(assessed):
    with pytest.raises(InputError, match=r"waiver 1 .*Width: no such parameter"):
        assessed(GOOD, [waiver(bits=(), values=("0", "Width"))])


def test_damaged_counters_are_refused(tmp_path):
    for damage in (
        "",
        GOOD[0][:-1],
        GOOD[0].replace("\x01h", "h"),
        GOOD[0].replace("' 5", "' five"),
        line("fsm", "state", 1),
        line("toggle", "sum[0]:0->x", 1),
    ):
        with pytest.raises(InputError, match="line 3: damaged"):
            read_counters(file(tmp_path, [GOOD[0], damage, *GOOD[1:]]))
    path = file(tmp_path, GOOD)
    whole = path.read_text()
    for cut, said in (
        (whole[: -len(LAST_LINE) - 1], "cut short"),
        (FIRST_LINE + "\n" + LAST_LINE + "\n", "cut short"),
        (whole[5:], "not a coverage file"),
        ("\ufffd", "not a coverage file"),
        ("\xff", "damaged: not text"),
    ):
        path.write_bytes(cut.encode("latin-1" if cut == "\xff" else "utf-8"))
        with pytest.raises(InputError, match=said):
            read_counters(path)
