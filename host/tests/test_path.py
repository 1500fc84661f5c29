"""Whole paths: nothing is missed, alarms stay in their band, all engines agree."""

import json
from fractions import Fraction
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpl_toolkits.mplot3d import Axes3D

from triaxis.golden.errors import InputError
from triaxis.golden.judge import judge
from triaxis.host import scenes
from triaxis.host.cli import main
from triaxis.host.engines import MeshEngineScene, scene_engine
from triaxis.host.motion import picture
from triaxis.host.motion.clearance import clearances
from triaxis.host.motion.path_check import Effort, check_path
from triaxis.host.motion.path_scene import PathGrid, Wanted, prepare_path
from triaxis.host.motion.program import Move, Program
from triaxis.host.scenes import mesh_data
from triaxis.host.stl import StlMesh
from triaxis.sim.mesh_configuration import MeshConfiguration

RASTER = Path(__file__).with_name("data") / "raster_with_dive.nc"
DIVE = 1 + next(k for k, line in enumerate(RASTER.read_text().splitlines()) if "the dive" in line)


def vector(place):
    x, y, z = (Fraction(float(c)) for c in place)
    return x, y, z


def program_of(corners):
    moves = [
        Move(line, vector(start), vector(end), None) for line, (start, end) in enumerate(pairwise(corners), 1)
    ]
    return Program(Path("moves.nc"), tuple(moves), ())


def wanted_of(clearance: Any = Fraction(1, 2), resolution=Fraction(1, 1000), step=None, scale=1, width=None):
    return Wanted(Fraction(clearance), resolution, step or 4 * resolution, Fraction(scale), width)


def scene_of(tool, work, corners, wanted):
    a, b = (StlMesh(np.array(facets, np.float64), Fraction(0)) for facets in (tool, work))
    return prepare_path(a, b, ("tool.stl", "work.stl"), program_of(corners), wanted)


def checked(scene, engine="bulk"):
    return check_path(scene, scene_engine(engine, scene.a, scene.b, scene.grid.width))


def exact(facets, move=(0, 0, 0)):
    return [
        [[Fraction(float(x)) + m for x, m in zip(vertex, move, strict=True)] for vertex in facet]
        for facet in facets
    ]


def distance(scene, position):
    return min(
        judge(a, b, 0).distance
        for a in exact(scene.tool.facets, scene.in_files(position))
        for b in exact(scene.work.facets)
    )


def test_no_near_position_is_ever_missed(rng):
    """Fine subdivisions of random paths against the exact distance, with a grid so coarse that it matters."""
    resolution = Fraction(1, 4)
    found = {"clear": 0, "certain": 0, "band": 0}
    for trial in range(150):
        tool, work = (rng.uniform(-1, 1, (1, 3, 3)).astype(np.float32) for _ in "ab")
        # One path in five begins where the two are next to each other, and not in the band around.
        corners = rng.uniform(-4, 4, (3, 3)).round(3) * np.array([[trial % 5 > 0], [1], [1]])
        clearance = Fraction(int(rng.integers(0, 60)), 97)
        scene = scene_of(
            tool, work, corners, wanted_of(clearance, resolution, Fraction(int(rng.integers(1, 5)), 4))
        )
        result = checked(scene)
        for index, move in enumerate(scene.program.moves):
            for k in range(25):
                part = Fraction(k, 24)
                if result.near and (index, part + scene.wanted.step) >= (result.near.move, result.near.along):
                    break
                position = [a + (b - a) * part for a, b in zip(move.start, move.end, strict=True)]
                assert distance(scene, position) > clearance
        if result.near:
            real = distance(scene, result.near.position)
            assert real < clearance + scene.band
            assert result.near.certain == (real <= clearance)
            assert result.near.facets[0].distance == real
            found["certain" if result.near.certain else "band"] += 1
        else:
            found["clear"] += 1
    assert min(found.values()) > 5, found


# A tool at x = 1/2 that rounds to 0, a wall at 3/2 that rounds to 2, and a path that ends where they touch.
POINTS = (np.full((1, 3, 3), [0.5, 0, 0]), np.full((1, 3, 3), [1.5, 0, 0]))


def tight_scene():
    return scene_of(*POINTS, [(-3, 0, 0), (1, 0, 0)], wanted_of(0, Fraction(1), Fraction(1)))


def test_the_bound_is_tight(monkeypatch):
    near = checked(tight_scene()).near
    assert near is not None
    assert near.along > Fraction(3, 4)
    monkeypatch.setattr(PathGrid, "base", PathGrid.base.func(tight_scene().path) - Fraction(1, 100))
    assert checked(tight_scene()).near is None, "a smaller bound would do"


def vise_scene(corners, **options):
    return scene_of(scenes.tool(), scenes.vise(), corners, wanted_of(**options))


def summary(result):
    near = result.near and (
        result.near.line,
        result.near.position,
        result.near.near_count,
        result.near.facets,
    )
    levels = [(level.by_boxes, level.by_pose, level.halved) for level in result.levels]
    return near, levels, result.effort.poses


# Down beside a jaw with half a millimetre to spare, along it, closer, and into it.
BESIDE = [(0, 76.5, 60), (0, 76.5, -20), (10, 76.2, -20), (40, 74, -20)]


@pytest.mark.simulator
def test_engines_agree():
    scene = vise_scene(BESIDE, clearance=1, resolution=Fraction(1, 100))
    answers = {name: checked(scene, name) for name in ("bulk", "golden", "rtl")}
    assert summary(answers["rtl"]) == summary(answers["bulk"]) == summary(answers["golden"])
    near = answers["bulk"].near
    assert near is not None
    assert near.line == 3
    effort = answers["rtl"].effort
    assert effort.poses > 10
    assert effort.cycles is not None
    assert effort.most_cycles is not None
    assert 0 < effort.most_cycles <= effort.cycles
    assert answers["bulk"].effort.cycles is None


@pytest.mark.simulator
def test_meshes_larger_than_the_engine_run_part_by_part(rng):
    a, b = (rng.integers(-60, 60, (n, 1, 3)) + rng.integers(-25, 25, (n, 3, 3)) for n in (150, 70))
    small = MeshEngineScene(a, b, MeshConfiguration(16, 16, depth=64, group=8, lanes=8))
    whole = scene_engine("bulk", a, b, 16)
    for translation, margin in (((0, 0, 0), 3), ((5, -7, 2), 0), ((3, 3, 3), 20)):
        parts, wanted = small.run(translation, margin), whole.run(translation, margin)
        assert (parts.near == wanted.near).all()
        assert (parts.tested, parts.near_count) == (wanted.tested, wanted.near_count)
        assert parts.skipped_in_groups + parts.skipped + parts.tested == 150 * 70
        assert parts.near_count
        first = small.run(translation, margin, stop_at_first=True)
        assert first.near_count == 1
        assert first.near.tolist()[0] in wanted.near.tolist()


def test_clear_of_a_program_without_its_dive():
    scene = vise_scene([(0, 0, 60), (0, 0, 1), (35, 25, 1), (-35, 25, 1)])
    result = checked(scene)
    assert result.near is None
    # Passes at 1 mm above the face: no margin covers half of one, but the boxes do.
    assert sum(level.by_boxes for level in result.levels) == 2
    assert result.effort.poses == 3


def test_bounds_of_the_clearance_hold_the_clearance():
    scene = scene_of(*POINTS, [(-8, 0, 0), (0, 0, 3), (1, 0, 0)], wanted_of(1, Fraction(1, 100)))
    engine, effort = scene_engine("bulk", scene.a, scene.b, scene.grid.width), Effort()
    places = clearances(scene, engine, 12, effort)
    assert [place.along for place in places] == sorted(place.along for place in places)
    assert places[-1].proven == 0
    for place in places:
        real = float(distance(scene, [Fraction(c) for c in place.position]))
        assert place.proven < real + 1e-9 or place.proven == 0
        assert real <= place.seen + 1e-9
        assert place.seen - place.proven <= max(0.1, real / 10)
    assert effort.poses > len(places)


@pytest.mark.parametrize("height", [1, 170, 2000])
def test_the_picture_of_a_tall_path_keeps_its_words_apart(height):
    scene = scene_of(
        scenes.box((-5, -5, 0), (5, 5, height)), scenes.box((-20, -20, -30), (20, 20, 0)),
        [(0, 0, height + 60), (0, 0, 1), (10, 0, 1)], wanted_of(resolution=Fraction(1, 10)),
    )  # fmt: skip
    engine = scene_engine("bulk", scene.a, scene.b, scene.grid.width)
    figure = picture.figure_of(scene, checked(scene), clearances(scene, engine, 5, Effort()))
    assert "the tool is clear of the workpiece" in figure.texts[0].get_text()
    figure.canvas.draw()
    space = figure.axes[0]
    assert isinstance(space, Axes3D)
    words = [figure.texts[1]]
    for axis in (space.xaxis, space.yaxis, space.zaxis):
        low, high = axis.get_view_interval()
        # Asked for its labels, it would put them back to where they were before drawing.
        shown = [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
        words += [axis.label, *shown]
    assert len(words) > 9
    boxes = [word.get_window_extent() for word in words]
    page = figure.bbox
    assert not [
        (word.get_text(), box)
        for word, box in zip(words, boxes, strict=True)
        if not (page.x0 <= box.x0 and page.y0 <= box.y0 and box.y1 <= page.y1)
    ]
    # Corners of boxes may meet where the words, slanted, do not.
    assert not [
        (one.get_text(), other.get_text())
        for (one, a), (other, b) in combinations(zip(words, boxes, strict=True), 2)
        if a.expanded(0.8, 0.8).overlaps(b.expanded(0.8, 0.8))
    ]


def test_what_leaves_the_grid_is_named_by_its_line():
    with pytest.raises(InputError, match=r"moves\.nc: line 2: at X0 Y0 Z900 the tool leaves the 16-bit grid"):
        vise_scene([(0, 0, 60), (0, 0, 5), (0, 0, 900)], resolution=Fraction(1, 100), width=16)
    assert vise_scene([(0, 0, 60), (0, 0, 900)]).grid.width == 24
    assert vise_scene([(0, 0, 60), (0, 0, 9000)]).grid.width == 24
    assert vise_scene([(0, 0, 60), (0, 0, 90000)]).grid.width == 32


def test_bad_wishes_are_refused():
    for options, why in (
        ({"clearance": -1}, "must not be negative"),
        ({"scale": 0}, "scale 0: must be positive"),
        ({"step": Fraction(1, 2000)}, "step 0.0005: must be at least the resolution"),
        ({"clearance": 700, "resolution": Fraction(1, 100), "width": 16}, "width 16 allows 65535"),
        ({"resolution": Fraction(0), "step": Fraction(1)}, "resolution"),
    ):
        with pytest.raises(InputError, match=why):
            vise_scene([(0, 0, 60), (0, 0, 5)], **options)


@pytest.fixture
def files(tmp_path):
    scenes.write_stl(tmp_path / "tool.stl", scenes.tool())
    scenes.write_stl(tmp_path / "vise.stl", scenes.vise())
    return [str(tmp_path / "tool.stl"), str(tmp_path / "vise.stl")]


def test_a_dive_is_found(files, tmp_path, capsys):
    report, picture = tmp_path / "report.json", tmp_path / "picture.png"
    command = ["path", *files, str(RASTER), "--start", "0", "0", "60", "--engine", "bulk"]
    assert main([*command, "--json", str(report), "--picture", str(picture), "--profile", "20"]) == 1
    out = capsys.readouterr().out
    assert f"NEAR: line {DIVE}: at X-10.0000 Y5.0000 Z0.50" in out
    assert "facet 0 of the tool, facet 4" in out
    found = json.loads(report.read_text())
    assert found["verdict"] == "near"
    assert found["near"]["line"] == DIVE
    assert found["false_alarm_band"] == 0.006
    assert found["near"]["facets"][0]["distance"] < 0.506
    proven = sum(level["by_pose"] + level["by_boxes"] for level in found["levels"])
    assert found["effort"]["poses"] == proven + sum(level["halved"] for level in found["levels"]) + 1
    assert len(found["profile"]) >= 20
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main([*command, "--clearance", "0", "--block-delete"]) == 1
    assert main([*command[:3], str(tmp_path / "no.nc")]) == 2


def test_errors_leave_no_older_verdict(files, tmp_path, capsys):
    moves, report, picture = (tmp_path / name for name in ("moves.nc", "report.json", "picture.png"))
    moves.write_text("G21 G0 Z50\nG2 X5 I1\n")
    unrelated = tmp_path / "x.gif"
    unrelated.write_text("")
    command = ["path", *files, str(moves), "--engine", "bulk", "--json", str(report)]
    before = sorted([*tmp_path.iterdir(), report])
    for option, why in (
        ([], f"{moves}: line 2: word 'G2': arcs are not supported"),
        (["--picture", str(picture)], "arcs are not supported"),
        (["--picture", str(unrelated)], "must end in .png or .svg"),
        (["--picture", str(tmp_path / "report.json" / "x.png")], "cannot remove"),
        (["--profile", "1"], "at least 2 places"),
        (["--width", "40"], "8..32"),
    ):
        report.write_text('{"verdict": "clear"}')
        if str(picture) in option:
            picture.write_text("of an older path")
        assert main([*command, *option]) == 2
        assert why in capsys.readouterr().err
        assert json.loads(report.read_text()) == {"verdict": "unknown"}
        assert sorted(tmp_path.iterdir()) == before
    for option in ("--json", "--picture"):
        assert main([*command, option, files[0]]) == 2
    assert "is an input file" in capsys.readouterr().err


def test_a_start_that_nobody_gave_is_said(files, tmp_path, capsys):
    moves = tmp_path / "moves.nc"
    moves.write_text("G21 G0 Z500")
    command = ["path", *files, str(moves), "--engine", "bulk"]
    note = "note: line 1: the first move starts at X0 Y0 Z0, which is assumed: give --start"
    main(command)
    assert note in capsys.readouterr().out
    assert main([*command, "--start", "0", "0", "60"]) == 0
    assert "assumed" not in capsys.readouterr().out


def test_a_tool_that_starts_within_the_work_is_near(tmp_path, capsys):
    tool, outer, moves, report, picture = (
        tmp_path / name for name in ("tool.stl", "outer.stl", "moves.nc", "report.json", "picture.png")
    )
    scenes.write_stl(tool, scenes.box((-5, -5, 0), (5, 5, 20)))
    stock = scenes.box((-500, -500, -500), (500, 500, 500))
    moves.write_text("G21 G0 Z50")
    command = ["path", str(tool), str(outer), str(moves), "--engine", "bulk", "--json", str(report)]

    def checked(facets, *options):
        scenes.write_stl(outer, facets)
        status = main([*command, *options])
        said, found = "".join(capsys.readouterr()), json.loads(report.read_text())
        return status, said, found["verdict"], found["enclosure"]["state"]

    status, said, *found = checked(stock, "--picture", str(picture), "--profile", "2")
    assert (status, *found) == (1, "near", "inside")
    assert "NEAR: no facets come within 0.5 mm anywhere on the path, but the tool is inside the work" in said
    assert picture.exists()
    status, said, *found = checked(stock, "--surfaces-only")
    assert (status, *found) == (0, "clear", "not asked")
    assert "(surfaces only: one may be inside the other)" in said
    status, said, *found = checked(stock[1:])
    assert (status, *found) == (2, "unknown", "undecided")
    assert f"{outer}: not closed: 3 edges" in said
    # On its way out it comes near: what is so at the start is said first.
    moves.write_text("G21 G0 Z50\nG0 Z900")
    status, said, *found = checked(stock)
    assert (status, *found) == (1, "near", "inside")
    assert "NEAR: at the start the tool is inside the workpiece\nNEAR: line 2: at" in said
    moves.write_text("G21 G0 Z900")
    status, said, *found = checked(stock, "--start", "0", "0", "600")
    assert (status, *found) == (0, "clear", "outside")


def test_a_tool_that_comes_into_something_open_is_undecided():
    tool, bowl = scenes.box((-5, -5, 0), (5, 5, 20)), scenes.box((-50, -50, -50), (50, 50, 50))
    # Without its two upper facets.
    without_lid = bowl[~(bowl[..., 2] == 50).all(1)]
    inwards, above = [(0, 0, 100), (0, 0, 10)], [(0, 0, 100), (0, 0, 60)]
    assert checked(scene_of(tool, without_lid, inwards, wanted_of())).verdict == "unknown"
    assert checked(scene_of(tool, without_lid, above, wanted_of())).verdict == "clear"
    result = checked(scene_of(tool, bowl, inwards, wanted_of()))
    assert (result.verdict, result.insides.state) == ("near", "outside")


def test_the_head_of_a_real_machine(tmp_path, capsys):
    """The head, 10 mm a unit, comes down on the carousel: apart at Z = 0, in contact at Z = -250 mm."""
    data = mesh_data()
    if data is None:
        pytest.skip("no real meshes here: set TRIAXIS_DATA to a folder with vmc/*.stl")
    moves = tmp_path / "moves.nc"
    moves.write_text("G21 G90\nG0 X0 Y0 Z40\nG1 Z-210 F4800 (machine Z -250)\n")
    parts = [str(data / "vmc" / name) for name in ("head.stl", "carousel.stl")]
    command = ["path", *parts, str(moves), "--start", "0", "0", "40", "--scale", "10", "--engine", "bulk"]
    assert main(command) == 1
    assert "NEAR: line 3: at X0.0000 Y0.0000 Z" in capsys.readouterr().out
