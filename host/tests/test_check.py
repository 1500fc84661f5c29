"""``triaxis check``: poses of the first mesh, engines, reports."""

import json
from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from triaxis.host import scenes
from triaxis.host.cli import main
from triaxis.host.engines import NO_PAIRS, STILL, MeshEngineScene
from triaxis.host.scenes import mesh_data
from triaxis.host.tests.published import SCHEMA, read_published
from triaxis.host.tests.test_cli import meshes
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshRun, Status

__all__ = ["meshes"]


LONG = [pytest.mark.regress, pytest.mark.simulator]


@pytest.fixture
def check(meshes, capsys, tmp_path):
    """Return a function that runs the command: what it printed, or the error, where it is refused."""

    def run(*options, status=0, files=meshes):
        report = ("--json", tmp_path / "new" / "report.json") if "--json" not in options else ()
        assert main(["check", *map(str, (*files, *options, *report))]) == status
        printed = capsys.readouterr()
        return printed.out + printed.err

    return run


@pytest.fixture
def report(tmp_path):
    """Return a function that reads the report."""
    return lambda: read_published(tmp_path / "new" / "report.json", "check")


def test_the_schema_takes_reports_and_nothing_else():
    jsonschema = pytest.importorskip("jsonschema")
    published = jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text()))
    assert published.is_valid({"verdict": "unknown"})
    assert not any(published.is_valid(other) for other in (42, [], {}, {"verdict": "clear"}, {"a": "b"}))


@pytest.mark.simulator
def test_all_engines_say_the_same(check, report):
    said, found = {}, {}
    for engine in ("rtl", "bulk", "golden"):
        lines = check("--clearance", 2, "--engine", engine, status=1).splitlines()
        said[engine] = [line for line in lines if not line.startswith("building ")]
        found[engine] = report()
    rtl = found["rtl"]
    assert (rtl["verdict"], rtl["margin"], rtl["facet_pairs"]) == ("near", 2001, 144)
    skipped = rtl["pairs_skipped_in_groups"] + rtl["pairs_skipped_by_their_boxes"]
    assert skipped + rtl["pairs_tested"] == 144
    assert rtl["pairs_near"] == len(rtl["near"]) > 0 and rtl["cycles"]
    # Only the simulated engine knows groups and cycles.
    (line,) = [line for line in said["rtl"] if "cycles" in line]
    said["rtl"].remove(line)
    assert any(line.endswith("exact distance 2") for line in said["rtl"])
    certified = f"; clears certified: {rtl['pairs_tested'] - rtl['pairs_near']}"
    assert said["golden"] == said["rtl"] and any(line.endswith(certified) for line in said["rtl"])
    # The bulk checker has no certificates.
    assert said["bulk"] == [line.removesuffix(certified) for line in said["rtl"]]
    for engine in ("bulk", "golden"):
        assert found[engine]["near"] == rtl["near"]
    assert [found[engine]["clears_certified"] is None for engine in found] == [False, True, False]


def test_a_pose(check):
    bulk = ("--engine", "bulk", "--move")
    # The gap of 2 mm along z is a gap along y, x for A turned about the origin.
    assert "A is moved by 0 0 -1.5" in check(*bulk, 0, 0, -1.5, "--clearance", 3.4)
    assert "exact distance 0.25\n" in check(*bulk, 0, 0, 1.75, "--clearance", 0.25, status=1)
    check(*bulk, 0, 0, 1.7, "--clearance", 0.25)
    # By 90 degrees about x: y becomes z, and -z y. Then 10 to y puts it back under B.
    turned = ("--rotate", "x", 90, *bulk, 0, 10, 0)
    check(*turned, "--clearance", 1.9)
    out = check(*turned, "--clearance", 2, status=1)
    assert "A is turned by 90 degrees about x, moved by 0 10 0" in out
    assert "exact distance 2\n" in out
    # About z by 45: A's corner reaches 10 sqrt 2 along y; turned back, it is as it was.
    there = ("--rotate", "z", 45, "--rotate", "z", -45, "--engine", "bulk")
    assert "distance as turned 2\n" in check(*there, "--clearance", 2, status=1)
    check(*there, "--clearance", 1.99)


@pytest.fixture
def nested(tmp_path):
    """Return the files of a small box, of a large one around it, and of the large one without a facet."""
    files = [tmp_path / f"{name}.stl" for name in ("small", "large", "open")]
    large = scenes.box((-10, -10, -10), (20, 20, 20))
    for file, facets in zip(files, (scenes.box((0, 0, 0), (5, 5, 5)), large, large[1:]), strict=True):
        scenes.write_stl(file, facets)
    return files


@pytest.mark.parametrize(
    ("a", "b", "options", "status", "verdict", "state", "line"),
    [
        (0, 1, "", 1, "near", "inside", "NEAR: no facets come within 0.5, but A is inside B\n"),
        (1, 0, "", 1, "near", "inside", "but B is inside A\n"),
        (0, 1, "--surfaces-only", 0, "clear", "not asked", "(surfaces only: one may be inside the other)"),
        (0, 1, "--move 30 0 0", 0, "clear", "outside", "and neither is inside the other"),
        # Near facets leave nothing to ask.
        (0, 2, "--move 14.6 0 0", 1, "near", "not asked", "NEAR: "),
        # Of an open mesh no inside can be told.
        (0, 2, "", 2, "unknown", "undecided", "open.stl: not closed: 3 edges"),
        (2, 0, "", 2, "unknown", "undecided", "small.stl may be inside"),
        # It is named, as another pose would be unknown.
        (0, 2, "--move 30 0 0", 0, "clear", "outside", "note: B is not closed: 3 edges"),
    ],
)
def test_inside_is_near(check, report, nested, a, b, options, status, verdict, state, line):
    files = nested[a], nested[b]
    said = check("--engine", "bulk", *options.split(), status=status, files=files)
    assert line in said
    assert ("CLEAR" in said) == (status == 0)
    found = report()
    assert (found["verdict"], found["enclosure"]["state"]) == (verdict, state)
    assert found["surfaces_only"] == ("--surfaces-only" in options)
    asked = state != "not asked"
    assert found["enclosure"]["open_edges"] == [3 * asked * (number == 2) for number in (a, b)]
    assert ("is not closed" in said) == (asked and 2 in (a, b) and status == 0)


def test_check_never_misses_and_alarms_only_in_the_band(check):
    # The gap is 2; at resolution 0.25 alarms may begin three steps early.
    for clearance, status in ((2, 1), (1.999, 1), (1.2, 0), (0, 0)):
        check("--resolution", 0.25, "--clearance", clearance, "--engine", "bulk", status=status)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"near_count": 0}, "counts 0 near pairs of 1 tested, tells of 1"),
        ({"near": NO_PAIRS}, "counts 1 near pairs of 1 tested, tells of 0"),
        ({"tested": 0, "pairs_skipped": 6}, "counts 1 near pairs of 0 tested, tells of 1"),
        ({"group_pairs_skipped": 1}, "3 of 2 pairs of groups decided"),
        ({"pairs_skipped": 4}, "5 pairs in 2 pairs of groups decided"),
        *(({"status": end}, f"status {end.name} at translation") for end in Status if end > Status.COMPLETE),
    ],
    ids=str,
)
def test_a_simulated_engine_that_contradicts_itself_is_not_believed(monkeypatch, changes, said):
    a, b = np.zeros((3, 3, 3), np.int64), np.zeros((2, 3, 3), np.int64)
    run = MeshRun(Status.COMPLETE, 9, 0, 2, 5, 1, 1, 0, near=np.zeros((1, 2), np.int64))
    configuration = MeshConfiguration(8, 8, depth=4, group=2, lanes=2)
    engine = Mock(configuration=configuration, **{"run.return_value": run})
    monkeypatch.setattr("triaxis.host.engines.MeshEngine", lambda _: engine)
    scene = MeshEngineScene(a, b, configuration)
    assert scene.run(STILL, 0).near_count == 1
    engine.run.return_value = replace(run, **changes)
    with pytest.raises(CoreError, match=f"^mesh engine: {said}"):
        scene.run(STILL, 0)


@pytest.mark.skipif(mesh_data() is None, reason="no real meshes: set TRIAXIS_DATA to a folder with vmc/*.stl")
@pytest.mark.parametrize("engine", ["bulk", pytest.param("rtl", marks=LONG)])
def test_real_meshes(check, engine):
    data = mesh_data()
    assert data is not None
    arm, options = data / "vmc/arm.stl", ("--clearance", 0, "--engine", engine)
    assert "facet pairs: 1208024" in check(*options, files=(data / "vmc/carousel.stl", arm), status=1)
    # This binary file's header begins with "solid".
    assert "12 facets" in check(*options, files=(data / "parts/unit_cube.STL", arm))
