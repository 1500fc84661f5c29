"""``triaxis check``: poses of the first mesh, engines, reports."""

import json

import pytest

from triaxis.host import scenes
from triaxis.host.cli import main


@pytest.fixture
def meshes(tmp_path):
    """Return two STL files, 2 mm apart along z."""
    a, b = tmp_path / "a.stl", tmp_path / "b.stl"
    scenes.write_stl(a, scenes.box((0, 0, 0), (10, 10, 10)))
    scenes.write_stl(b, scenes.box((2, 2, 12), (8, 8, 20)))
    return a, b


@pytest.fixture
def check(meshes, capsys):
    """Return a function that runs the command and returns what it printed: the error, where it is refused."""

    def run(*options, status=0):
        assert main(["check", *map(str, (*meshes, *options))]) == status
        printed = capsys.readouterr()
        return printed.err if status == 2 else printed.out

    return run


def test_check_reports(check, meshes, tmp_path):
    report = tmp_path / "new" / "report.json"
    found = {}
    for engine in ("rtl", "bulk", "golden"):
        check("--clearance", "2", "--engine", engine, "--json", report, status=1)
        found[engine] = json.loads(report.read_text())
    rtl = found["rtl"]
    assert rtl["verdict"] == "near"
    assert rtl["margin"] == 2001
    assert rtl["facet_pairs"] == 144
    skipped = rtl["pairs_skipped_in_groups"] + rtl["pairs_skipped_by_their_boxes"]
    assert skipped + rtl["pairs_tested"] == 144
    assert rtl["pairs_near"] == len(rtl["near"]) > 0
    assert rtl["group_pairs_skipped"] + rtl["group_pairs_opened"] == 4
    assert rtl["milliseconds_at_100_MHz"] == rtl["cycles"] / 100_000
    for engine in ("bulk", "golden"):
        assert found[engine]["near"] == rtl["near"]
        assert found[engine]["pairs_tested"] == rtl["pairs_tested"]
        assert found[engine]["cycles"] is None
    assert "is an input file" in check("--json", meshes[0], status=2)


def test_check_in_a_pose(check, meshes, tmp_path):
    # The gap of 2 mm along z is a gap along y, x for A turned about the origin.
    moved = check("--move", "0", "0", "-1.5", "--clearance", "3.4")
    assert "A is moved by 0 0 -1.5" in moved
    out = check("--move", "0", "0", "1.75", "--clearance", "0.25", status=1)
    assert "exact distance 0.25\n" in out
    check("--move", "0", "0", "1.7", "--clearance", "0.25")
    # By 90 degrees about x: y becomes z, and -z y. Then 10 to y puts it back under B.
    turned = ("--rotate", "x", "90", "--engine", "bulk")
    check(*turned, "--move", "0", "10", "0", "--clearance", "1.9")
    out = check(*turned, "--move", "0", "10", "0", "--clearance", "2", status=1)
    assert "A is turned by 90 degrees about x, moved by 0 10 0" in out
    assert "exact distance 2\n" in out
    # About z by 45: A's corner reaches 10 sqrt 2 along y; turned back, it is as it was.
    report = tmp_path / "report.json"
    there = ("--rotate", "z", "45", "--rotate", "z", "-45", "--engine", "bulk")
    out = check(*there, "--clearance", "2", "--json", report, status=1)
    assert "distance as turned 2\n" in out
    turns = json.loads(report.read_text())["pose"]["rotate"]
    assert turns == [{"axis": "z", "degrees": 45.0}, {"axis": "z", "degrees": -45.0}]
    check(*there, "--clearance", "1.99")


def test_errors_leave_no_older_verdict(check, meshes, tmp_path):
    report = tmp_path / "report.json"
    for options in (
        ("--rotate", "w", "90"),
        ("--width", "40"),
        ("--clearance", "-1"),
        ("--width", "16", "--move", "0", "0", "90"),
    ):
        report.write_text('{"verdict": "clear"}')
        check("--json", report, *options, status=2)
        assert json.loads(report.read_text()) == {"verdict": "unknown"}


def test_check_refuses_bad_poses(check, meshes):
    assert "--rotate w: must be x, y or z" in check("--rotate", "w", "90", status=2)
    assert "--rotate xy: must be x, y or z" in check("--rotate", "xy", "90", status=2)
    assert "--rotate x inf: not a finite decimal number" in check("--rotate", "x", "inf", status=2)
    assert "--move: up: not a finite decimal number" in check("--move", "0", "0", "up", status=2)
    assert "does not fit 16 bits" in check("--width", "16", "--move", "0", "0", "90", status=2)


@pytest.fixture
def nested(tmp_path):
    """Return the files of a small box, of a large one around it, and of the large one without a facet."""
    files = [tmp_path / f"{name}.stl" for name in ("small", "large", "open")]
    large = scenes.box((-10, -10, -10), (20, 20, 20))
    for file, facets in zip(files, (scenes.box((0, 0, 0), (5, 5, 5)), large, large[1:]), strict=True):
        scenes.write_stl(file, facets)
    return files


@pytest.fixture
def nested_check(nested, tmp_path, capsys):
    """Return a function that checks two of the files: exit code, what was printed, the report."""
    report = tmp_path / "nested.json"

    def run(a, b, *options):
        names = [str(nested[k]) for k in (a, b)]
        status = main(["check", *names, "--engine", "bulk", "--json", str(report), *options])
        out, error = capsys.readouterr()
        return status, out + error, json.loads(report.read_text())

    return run


def test_inside_is_near(nested_check):
    status, said, report = nested_check(0, 1)
    assert (status, report["verdict"], report["enclosure"]["state"]) == (1, "near", "inside")
    assert "NEAR: no facets come within 0.5, but A is inside B\n" in said
    (part,) = report["enclosure"]["parts"]
    assert (part["mesh"], part["first_facet"], part["facets"]) == ("a", 0, 12)
    status, said, _ = nested_check(1, 0)
    assert status == 1
    assert "but B is inside A\n" in said
    status, said, report = nested_check(0, 1, "--surfaces-only")
    assert (status, report["verdict"]) == (0, "clear")
    assert (report["surfaces_only"], report["enclosure"]["state"]) == (True, "not asked")
    assert "(surfaces only: one may be inside the other)" in said
    status, said, report = nested_check(0, 1, "--move", "30", "0", "0")
    assert (status, report["verdict"], report["enclosure"]["state"]) == (0, "clear", "outside")
    assert "and neither is inside the other" in said
    # Near facets leave nothing to ask.
    status, said, report = nested_check(0, 2, "--move", "14.6", "0", "0")
    assert (status, report["enclosure"]["state"]) == (1, "not asked")


def test_inside_of_an_open_mesh_is_unknown(nested_check, nested):
    for a, b in ((0, 2), (2, 0)):
        status, said, report = nested_check(a, b)
        assert (status, report["verdict"], report["enclosure"]["state"]) == (2, "unknown", "undecided")
        (line,) = [line for line in said.splitlines() if "verdict unknown" in line]
        assert f"{nested[2]}: not closed: 3 edges" in line
        assert f"{nested[0]} may be inside" in line
        assert "CLEAR" not in said
    assert nested_check(0, 2, "--surfaces-only")[0] == 0
    assert nested_check(0, 2, "--move", "30", "0", "0")[0] == 0
