"""What the tracefile says is what the counters say, and genhtml reads it so."""

from pathlib import Path

import pytest

from triaxis.coverage.interchange.lcov import write_lcov
from triaxis.coverage.tests.counter_files import BINS, FIRST, SECOND, SOURCE, write_counters
from triaxis.golden.errors import InputError


def read_back(path: Path) -> dict[str, list[str]]:
    """Return the values in a tracefile by their keys."""
    found: dict[str, list[str]] = {}
    for line in path.read_text().splitlines():
        key, _, value = line.partition(":")
        found.setdefault(key, []).append(value)
    return found


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "dut" / "leaf.sv"
    path.parent.mkdir()
    path.write_text(SOURCE)
    return path


@pytest.fixture
def models(tmp_path: Path, source: Path) -> list[Path]:
    """Counters of two models: the arm in line 10, and the way of line 14, are hit in no instance of any."""
    one = {
        FIRST: [10, 4, 6, 9, 0, 2, 7, 0, 5, 1, 2, 8, 3],
        SECOND: [10, 0, 10, 9, 0, 9, 0, 0, 5, 1, 2, 8, 3],
    }
    two = {FIRST: [100, 0, 100, 50, 0, 0, 50, 0, 1, 1, 0, 60, 5]}
    return [
        write_counters(tmp_path / f"{name}.dat", source, counts)
        for name, counts in {"one": one, "two": two}.items()
    ]


def test_counts_are_added_over_instances_and_models(models: list[Path], tmp_path: Path) -> None:
    lines = {2: 120, 3: 120, 4: 4, 5: 4, 6: 116, 7: 120, 9: 68, 10: 0, 11: 68, 12: 57, 14: 11, 15: 76}
    # By line, block and way.
    ways = ["3,0,0,4", "3,0,1,116", "10,0,0,0", "11,0,0,11", "11,0,1,57"]
    ways += ["14,0,0,0", "14,0,1,11", "14,1,0,3", "14,1,1,4"]
    assert read_back(write_lcov(tmp_path / "t.info", models, tmp_path)) == {
        "TN": ["triaxis"], "SF": ["dut/leaf.sv"], "end_of_record": [""],
        "DA": [f"{line},{count}" for line, count in lines.items()], "BRDA": ways,
        "LF": ["12"], "LH": ["11"], "BRF": ["9"], "BRH": ["7"],
    }  # fmt: skip


def test_what_no_instance_hits_is_not_hit_and_a_way_without_statements_has_no_line(
    source: Path, tmp_path: Path
) -> None:
    idle = write_counters(tmp_path / "idle.dat", source, {FIRST: [0] * len(BINS), SECOND: [0] * len(BINS)})
    found = read_back(write_lcov(tmp_path / "t.info", [idle], tmp_path))
    assert (found["LF"], found["LH"], found["BRF"], found["BRH"]) == (["12"], ["0"], ["9"], ["0"])
    assert all(line.endswith(",0") for line in found["DA"] + found["BRDA"])
    idle.write_text(idle.read_text().replace("\x01S\x026\x01", "\x01"))
    found = read_back(write_lcov(tmp_path / "t.info", [idle], tmp_path))
    assert "6,0" not in found["DA"] and "3,0,1,0" in found["BRDA"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("\x01o\x02elsif", "\x01p\x02elsif", r"one\.dat: line 8: damaged"),
        ("# end\n", "", "cut short after line"),
        ("# SystemC", "# Another", "line 1 must read"),
    ],
)
def test_damaged_counters_are_refused(
    models: list[Path], old: str, new: str, said: str, tmp_path: Path
) -> None:
    text = models[0].read_text()
    assert old in text
    models[0].write_text(text.replace(old, new))
    with pytest.raises(InputError, match=said):
        write_lcov(tmp_path / "t.info", models, tmp_path)
    assert not list(tmp_path.glob("*.info*")) and not list(tmp_path.glob(".*"))


def test_counters_of_another_checkout_or_of_nothing_are_refused(models: list[Path], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="which is not below"):
        write_lcov(tmp_path / "t.info", models, tmp_path / "golden")
    empty = [
        line for line in models[0].read_text().splitlines() if "_line/" not in line and "_branch/" not in line
    ]
    models[0].write_text("\n".join(empty) + "\n")
    with pytest.raises(InputError, match="no line or branch counters"):
        write_lcov(tmp_path / "t.info", models, tmp_path)
    with pytest.raises(InputError, match=r"none\.dat: cannot read"):
        write_lcov(tmp_path / "t.info", [tmp_path / "none.dat"], tmp_path)
