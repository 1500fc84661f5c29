"""``triaxis check``: poses of the first mesh, engines, reports."""

import json

import pytest

from triaxis.host import scenes
from triaxis.host.cli import main
from triaxis.host.scenes import mesh_data


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


@pytest.mark.simulator
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


@pytest.mark.simulator
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


def test_check_never_misses_and_alarms_only_in_the_band(check):
    # The gap is 2; at resolution 0.25 alarms may begin three steps early.
    for clearance, status in (("2", 1), ("1.999", 1), ("1.2", 0), ("0", 0)):
        check("--resolution", "0.25", "--clearance", clearance, "--engine", "bulk", status=status)


@pytest.mark.simulator
def test_check_says_the_same_with_every_engine(check):
    out = check()
    assert "CLEAR" in out
    assert "facet pairs: 144; skipped by boxes: 144; tested: 0" in out
    out = check("--clearance", "2", status=1)
    assert "NEAR: " in out
    assert "exact distance 2\n" in out
    # Only the simulated engine knows groups and cycles.
    lines = [line for line in out.splitlines(keepends=True) if "cycles" not in line]
    assert len(lines) == len(out.splitlines()) - 1
    for engine in ("golden", "bulk"):
        assert check("--clearance", "2", "--engine", engine, status=1) == "".join(lines)


def test_check_refuses_bad_input(check, meshes):
    for clearance in ("-0.5", "-1e-3"):
        assert "must not be negative" in check("--clearance", clearance, status=2)
    line = check("--resolution", "0.0001", "--width", "16", status=2)
    assert "facet" in line
    assert "does not fit 16 bits at resolution 0.0001" in line
    assert str(meshes[0]) in line or str(meshes[1]) in line
    for options, why in (
        (("--resolution", "0"), "resolution"),
        (("--resolution", "nan"), "not a finite decimal number"),
        (("--width", "5"), "8..32"),
        (("--clearance", "99", "--width", "16"), "width 16 allows 65535"),
        (("--rotate", "w", "90"), "--rotate w: must be x, y or z"),
        (("--rotate", "xy", "90"), "--rotate xy: must be x, y or z"),
        (("--rotate", "x", "inf"), "--rotate x inf: not a finite decimal number"),
        (("--move", "0", "0", "up"), "--move: up: not a finite decimal number"),
        (("--width", "16", "--move", "0", "0", "90"), "does not fit 16 bits"),
        (("--engine", "board"), "--engine board: name its serial port with --port"),
        (("--port", "/dev/ttyUSB1"), "--port and --any-bitstream go with --engine board"),
    ):
        assert why in check(*options, status=2)
    whole = meshes[0].read_bytes()
    for content, why in ((whole[:-10], f"{meshes[0]}: "), (b"", "empty file")):
        meshes[0].write_bytes(content)
        assert why in check(status=2)
    meshes[0].unlink()
    assert "cannot read" in check(status=2)


@pytest.mark.simulator
def test_real_meshes(capsys):
    data = mesh_data()
    if data is None:
        pytest.skip("no real meshes here: set TRIAXIS_DATA to a folder with vmc/*.stl")
    arm = str(data / "vmc/arm.stl")
    assert main(["check", str(data / "vmc/carousel.stl"), arm, "--clearance", "0"]) == 1
    assert "facet pairs: 1208024" in capsys.readouterr().out
    # This binary file's header begins with "solid".
    assert main(["check", str(data / "parts/unit_cube.STL"), arm]) == 0
    assert "12 facets" in capsys.readouterr().out
