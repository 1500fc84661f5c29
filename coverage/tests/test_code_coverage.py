from dataclasses import replace
from pathlib import Path

import pytest

from triaxis.coverage.code_counters import FIRST_LINE, LAST_LINE, read_counters
from triaxis.coverage.code_coverage import (
    Assessment,
    ModelCoverage,
    Total,
    assess_model,
    conclude,
    generate_blocks,
)
from triaxis.coverage.elaboration import Instance, Signal
from triaxis.coverage.tests.counter_files import counter_line
from triaxis.coverage.waivers import Waiver, module_hash
from triaxis.golden.errors import InputError

TOP = "TOP.top"


def line(kind: str, what: str, count: int, path: str = TOP) -> str:
    lines = "7-9" if kind == "line" else ""
    return counter_line(Path("/somewhere/top.sv"), (7, 3, kind, what, lines), path, count)


def toggles(name: str, rises: int, falls: int) -> list[str]:
    return [line("toggle", f"{name}:0->1", rises), line("toggle", f"{name}:1->0", falls)]


GOOD = [
    line("line", "block", 5),
    line("line", "elsif", 2),
    line("branch", "if", 1),
    line("expr", "(a==1 && b==1) => 1", 4),
    *toggles("clk_i", 9, 9),
    *toggles("sum[0]", 1, 2),
    *toggles("sum[1]", 3, 4),
]


def file(tmp_path: Path, lines: list[str], name: str = "coverage.dat") -> Path:
    path = tmp_path / name
    path.write_text("\n".join([FIRST_LINE, *lines, LAST_LINE]) + "\n")
    return path


SIGNALS = [Signal(TOP, "clk_i", range(0)), Signal(TOP, "sum", range(2))]
DESIGN = Instance(TOP, "top", {"W": 4}, SIGNALS, {"g_block"}, {7})
NO_BLOCK = replace(DESIGN, blocks=set())


def assessed(
    tmp_path: Path, lines: list[str], waivers: list[Waiver] | None = None, design: Instance = DESIGN
) -> Assessment:
    model = ModelCoverage("model", read_counters(file(tmp_path, lines)), {TOP: design})
    source = tmp_path / "top.sv"
    source.write_text("module top;\n  if (W == 4) begin : g_block\n  end // begin : g_not\nendmodule\n")
    found = assess_model(model, waivers or [])
    return conclude(found, generate_blocks([source]), waivers or [])


def waiver(**changes: object) -> Waiver:
    usual = Waiver(
        1, "bounded", "because", "dut", module_hash(()), "toggle", ("top",), signals=("sum",), bits=("1",)
    )
    return replace(usual, **changes)  # pyright: ignore[reportArgumentType]


def without(what: str) -> list[str]:
    return [text for text in GOOD if what not in text]


def never(what: str) -> list[str]:
    return [text.rpartition(" ")[0] + " 0" if what in text else text for text in GOOD]


def test_everything_hit_passes(tmp_path: Path) -> None:
    found = assessed(tmp_path, GOOD)
    assert found.passed
    counts = {kind: (total.hit, total.total, total.percent) for kind, total in found.totals.items()}
    expected = {"line": 1, "branch": 2, "expression": 1, "toggle": 6, "generate": 1}
    assert counts == {kind: (count, count, 100.0) for kind, count in expected.items()}


@pytest.mark.parametrize(
    ("what", "kind"),
    [
        ("block", "line"),
        ("elsif", "branch"),
        ("\x02if\x01", "branch"),
        ("=> 1", "expression"),
        ("sum[1]:0->1", "toggle"),
        ("sum[1]:1->0", "toggle"),
    ],
)
def test_a_bin_that_is_not_hit_fails(tmp_path: Path, what: str, kind: str) -> None:
    found = assessed(tmp_path, never(what))
    assert not found.passed and not found.problems
    [bin_] = found.uncovered
    assert (bin_.kind, bin_.file, bin_.line, bin_.instance) == (kind, "top.sv", 7, TOP)
    percent = found.totals[kind].percent
    assert percent is not None and percent < 100
    assert str(bin_).startswith(f"top.sv:7: {kind} ")


@pytest.mark.parametrize("left_out", ["sum[1]:0->1", "sum[1]:1->0", "clk_i"])
def test_a_signal_that_verilator_leaves_out_fails(tmp_path: Path, left_out: str) -> None:
    found = assessed(tmp_path, without(left_out))
    assert not found.passed
    assert ["has no toggle counters" in problem for problem in found.problems] == [True]


def test_what_is_not_in_the_counters_or_not_in_the_design_fails(tmp_path: Path) -> None:
    assert [bin_.what for bin_ in assessed(tmp_path, without("=> 1")).uncovered] == [
        "condition without counters"
    ]
    other = line("branch", "if", 1, path="TOP.other")
    found = assessed(tmp_path, [*GOOD, *toggles("sum[2]", 1, 1), other])
    assert len(found.problems) == 2 and all("not in the design" in problem for problem in found.problems)
    [block] = assessed(tmp_path, GOOD, design=NO_BLOCK).uncovered
    assert (block.kind, block.what, block.line) == ("generate", "g_block", 2)


def test_a_waiver_covers_bins(tmp_path: Path) -> None:
    found = assessed(tmp_path, never("sum[1]"), [waiver()])
    assert found.passed and found.waived == {1: 2}
    total = found.totals["toggle"]
    assert (total.hit, total.waived, total.total, total.percent) == (4, 2, 6, 100.0)
    way = waiver(kind="branch", signals=(), bits=(), what=("if",), where="W == 4")
    assert assessed(tmp_path, never("\x02if\x01"), [way]).passed
    assert not assessed(tmp_path, never("\x02if\x01"), [replace(way, where="W == 5")]).passed
    block = waiver(kind="generate", signals=(), bits=(), what=("g_*",))
    assert assessed(tmp_path, GOOD, [block], NO_BLOCK).passed


def test_a_waiver_for_a_bin_that_is_hit_fails(tmp_path: Path) -> None:
    found = assessed(tmp_path, never("sum[1]:0->1"), [waiver()])
    assert not found.passed
    assert [": is hit: top.sv:7: toggle sum[1]:1->0" in problem for problem in found.problems] == [True]
    # What is hit is not counted as waived as well.
    assert found.totals["toggle"].hit + found.totals["toggle"].waived == found.totals["toggle"].total


@pytest.mark.parametrize(
    "change",
    [{"modules": ("other",)}, {"models": ("other",)}, {"signals": ("su",)}, {"instances": ("TOP.top.*",)}],
)
def test_a_waiver_for_nothing_fails(tmp_path: Path, change: dict[str, tuple[str]]) -> None:
    found = assessed(tmp_path, GOOD, [waiver(**change)])
    assert ["covers no bin" in problem for problem in found.problems] == [True]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"modules": ("top", "other")}, "modules: other"),
        ({"models": ("model", "w9_*")}, "models: w9_*"),
        ({"instances": ("TOP.top", "TOP.top.*")}, "instances: TOP.top.*"),
        ({"signals": ("sum", "difference")}, "signals: difference"),
        ({"kind": "branch", "signals": (), "bits": (), "what": ("if", "else")}, "what: else"),
        ({"kind": "generate", "signals": (), "bits": (), "what": ("g_*", "h_*")}, "what: h_*"),
    ],
)
def test_a_pattern_of_a_waiver_that_fits_nothing_fails(
    tmp_path: Path, change: dict[str, object], said: str
) -> None:
    lines = never("\x02if\x01" if change.get("kind") == "branch" else "sum[1]")
    hidden = change.get("kind") == "generate"
    found = assessed(tmp_path, GOOD if hidden else lines, [waiver(**change)], NO_BLOCK if hidden else DESIGN)
    assert [f": {said}: fits no bin" in problem for problem in found.problems] == [True]


def test_a_waiver_of_other_rtl_or_of_an_unknown_parameter_fails(tmp_path: Path) -> None:
    found = assessed(tmp_path, never("sum[1]"), [waiver(reviewed="0")])
    assert not found.passed and found.void == {1}
    assert ["waiver 1 (toggle, top): its modules changed" in problem for problem in found.problems] == [True]
    with pytest.raises(InputError, match=r"waiver 1 .*Width: no such parameter"):
        assessed(tmp_path, GOOD, [waiver(bits=(), values=("0", "Width"))])


@pytest.mark.parametrize(
    "damage",
    [
        "",
        "C '' 1",
        GOOD[0][:-1],
        GOOD[0].replace("\x01h", "h"),
        GOOD[0].replace("' 5", "' five"),
        line("fsm", "state", 1),
        line("toggle", "sum[0]", 1),
        line("toggle", "sum[0]:0->x", 1),
    ],
)
def test_a_damaged_line_is_named(tmp_path: Path, damage: str) -> None:
    with pytest.raises(InputError, match="line 3: damaged"):
        read_counters(file(tmp_path, [GOOD[0], damage, *GOOD[1:]]))


def test_a_damaged_file_is_an_error(tmp_path: Path) -> None:
    path = file(tmp_path, GOOD)
    whole = path.read_text()
    for cut in (whole[: -len(LAST_LINE) - 1], whole[:-50], FIRST_LINE + "\n" + LAST_LINE + "\n"):
        path.write_text(cut)
        with pytest.raises(InputError, match="cut short"):
            read_counters(path)
    path.write_text(whole[5:])
    with pytest.raises(InputError, match="not a coverage file"):
        read_counters(path)
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="not text"):
        read_counters(path)
    with pytest.raises(InputError, match="cannot read"):
        read_counters(tmp_path / "none.dat")


def test_a_percentage_never_rounds_up_to_all() -> None:
    assert Total(hit=1_880_006, total=1_880_096).percent == 99.99
    assert Total(hit=2, waived=1, total=3).percent == 100
    assert Total().percent is None
