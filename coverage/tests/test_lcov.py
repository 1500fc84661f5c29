"""What the tracefile says is what the counters say, and genhtml reads it so."""

import re
import shutil
import subprocess
from collections import Counter
from dataclasses import dataclass, field
from html import unescape
from pathlib import Path

import pytest

from triaxis.coverage.code_counters import Counters, read_counters
from triaxis.coverage.interchange.code_points import branch_statements, read_code_points
from triaxis.coverage.interchange.lcov import write_lcov
from triaxis.coverage.tests.counter_files import BINS, FIRST, SECOND, SOURCE, write_counters
from triaxis.golden.errors import InputError

ROOT = Path(__file__).resolve().parents[2]
# Those of the last measurement; counters older than the RTL may be of lines that are no more.
NEWEST = max(path.stat().st_mtime for path in (ROOT / "dut").iterdir())
COUNTERS = (ROOT / "build" / "coverage" / "counters").glob("*.dat")
MEASURED = sorted(path for path in COUNTERS if path.stat().st_mtime > NEWEST)
GENHTML = shutil.which("genhtml")

needs_genhtml = pytest.mark.skipif(GENHTML is None, reason="no genhtml here: apt-get install lcov")
needs_measured = pytest.mark.skipif(not MEASURED, reason="no counters of this RTL: triaxis coverage code")


@dataclass
class Record:
    """One file of a tracefile, read back: counts by line, counts by line, block and way, and totals."""

    lines: dict[int, int] = field(default_factory=dict)
    ways: dict[tuple[int, int, int], int] = field(default_factory=dict)
    totals: dict[str, int] = field(default_factory=dict)


def read_back(path: Path) -> dict[str, Record]:
    """Read a tracefile by the words of lcov's manual, refusing any line that it does not know."""
    records: dict[str, Record] = {}
    record = Record()
    for line in path.read_text().splitlines():
        key, _, value = line.partition(":")
        if key == "SF":
            assert value not in records
            record = records[value] = Record()
        elif key == "DA":
            number, count = map(int, value.split(","))
            assert number not in record.lines
            record.lines[number] = count
        elif key == "BRDA":
            number, block, way, count = map(int, value.split(","))
            assert (number, block, way) not in record.ways
            record.ways[number, block, way] = count
        elif key in ("LF", "LH", "BRF", "BRH"):
            record.totals[key] = int(value)
        else:
            assert line in ("TN:triaxis", "end_of_record")
    return records


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
    [(file, record)] = read_back(write_lcov(tmp_path / "t.info", models, tmp_path)).items()
    assert file == "dut/leaf.sv"
    assert record.ways == {
        (3, 0, 0): 4, (3, 0, 1): 116,
        (10, 0, 0): 0,
        (11, 0, 0): 11, (11, 0, 1): 57,
        (14, 0, 0): 0, (14, 0, 1): 11, (14, 1, 0): 3, (14, 1, 1): 4,
    }  # fmt: skip
    first = {2: 120, 3: 120, 4: 4, 5: 4, 6: 116, 7: 120}
    assert record.lines == {**first, 9: 68, 10: 0, 11: 68, 12: 57, 14: 11, 15: 76}
    assert record.totals == {"LF": 12, "LH": 11, "BRF": 9, "BRH": 7}


def test_what_no_instance_hits_is_not_hit(source: Path, tmp_path: Path) -> None:
    idle = write_counters(tmp_path / "idle.dat", source, {FIRST: [0] * len(BINS), SECOND: [0] * len(BINS)})
    [record] = read_back(write_lcov(tmp_path / "t.info", [idle], tmp_path)).values()
    assert record.totals == {"LF": 12, "LH": 0, "BRF": 9, "BRH": 0}
    assert not any(record.lines.values()) and not any(record.ways.values())


def test_a_way_without_statements_has_no_line(source: Path, tmp_path: Path) -> None:
    path = write_counters(tmp_path / "one.dat", source, {FIRST: [1] * len(BINS)})
    path.write_text(path.read_text().replace("\x01S\x026\x01", "\x01"))
    [record] = read_back(write_lcov(tmp_path / "t.info", [path], tmp_path)).values()
    assert 6 not in record.lines and (3, 0, 1) in record.ways


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


def added(counters: list[Counters]) -> Counter[tuple[str, int, str]]:
    """Return what our other reader says: counts by file, line and what, over instances and models."""
    found: Counter[tuple[str, int, str]] = Counter()
    for one in counters:
        for point in one.points.values():
            if point.kind != "expression":
                found[point.file, point.line, point.what] += point.count
    return found


def without_toggles(path: Path, folder: Path) -> Path:
    """Copy counters without toggles: the other reader takes its time over them."""
    copy = folder / path.name
    lines = path.read_text().splitlines(keepends=True)
    copy.write_text("".join(line for line in lines if "\x01t\x02toggle\x01" not in line))
    return copy


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The counters of the last measurement."""
    with MEASURED[0].open() as lines:
        if f"\x01f\x02{ROOT}/" not in [next(lines), next(lines)][1]:
            pytest.skip("the counters here are of another checkout: triaxis coverage code")
    folder = tmp_path_factory.mktemp("measured")
    return [without_toggles(path, folder) for path in MEASURED]


@needs_measured
def test_the_tracefile_of_the_core_says_what_the_counters_say(measured: list[Path], tmp_path: Path) -> None:
    records = read_back(write_lcov(tmp_path / "t.info", measured, ROOT))
    counts = added([read_counters(path) for path in measured])
    places = {point.place for path in measured for point in read_code_points(path, ROOT)}
    assert {(Path(p.file).name, p.line, p.what) for p in places} == set(counts)
    assert {file for file, record in records.items() if record.lines} == {p.file for p in places}
    statements = branch_statements(list(places))
    assert sum(map(len, statements)) == sum(r.totals["BRF"] for r in records.values())
    for file, record in records.items():
        name = Path(file).name
        assert (ROOT / file).is_file()
        ways = {
            (way.line, index): counts[name, way.line, way.what]
            for statement in statements
            for index, way in enumerate(statement)
            if way.file == file
        }
        assert {(line, index): n for (line, _, index), n in record.ways.items()} == ways
        for (found, line, what), count in counts.items():
            assert found != name or what != "block" or record.lines[line] >= count
        assert record.totals == {
            "LF": len(record.lines),
            "LH": sum(n > 0 for n in record.lines.values()),
            "BRF": len(record.ways),
            "BRH": sum(n > 0 for n in record.ways.values()),
        }


def page_of(folder: Path, info: Path, root: Path) -> str:
    """Make the pages; return what genhtml said."""
    command = [GENHTML, "--branch-coverage", "-o", str(folder), str(info)]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def check_pages(records: dict[str, Record], said: str, folder: Path) -> None:
    """Check that the totals that genhtml prints, and the counts in its pages, are those of the records."""
    for word, found, hit in (("lines", "LF", "LH"), ("branches", "BRF", "BRH")):
        whole = sum(record.totals[found] for record in records.values())
        covered = sum(record.totals[hit] for record in records.values())
        assert re.search(rf"{word}\.+: [\d.]+% \({covered} of {whole} {word}\)", said)
    for file, record in records.items():
        text = (folder / f"{file}.gcov.html").read_text()
        taken = [int(count) for count in re.findall(r"was taken (\d+) time", text)]
        assert taken == [count for _, count in sorted(record.ways.items()) if count]
        assert text.count("was not taken") == sum(not count for count in record.ways.values())
        plain = unescape(re.sub(r"<[^>]*>", "", text))
        lines = dict(re.findall(r"^ *(\d+) [^:]*: +(\d+) : ", plain, re.MULTILINE))
        assert {int(line): int(count) for line, count in lines.items()} == record.lines


@needs_genhtml
def test_genhtml_says_what_the_tracefile_says(models: list[Path], tmp_path: Path) -> None:
    info = write_lcov(tmp_path / "t.info", models, tmp_path)
    said = page_of(tmp_path / "html", info, tmp_path)
    assert "(11 of 12 lines)" in said and "(7 of 9 branches)" in said
    check_pages(read_back(info), said, tmp_path / "html")


@needs_genhtml
@needs_measured
def test_genhtml_says_of_the_core_what_the_counters_say(measured: list[Path], tmp_path: Path) -> None:
    info = write_lcov(tmp_path / "t.info", measured, ROOT)
    check_pages(read_back(info), page_of(tmp_path / "html", info, ROOT), tmp_path / "html")
