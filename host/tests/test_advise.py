import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from triaxis.fpga.board_build import Resources
from triaxis.fpga.dsp_count import DspCount
from triaxis.golden.errors import InputError
from triaxis.golden.judge import CertificateError
from triaxis.host.advice import measuring, widths
from triaxis.host.advice.choosing import Advice, advise, all_rows
from triaxis.host.advice.measuring import (
    EngineShape,
    LoadedMesh,
    TooManyError,
    engine_work,
    exact_near,
    measure,
    positions_of,
)
from triaxis.host.advice.wanted import AdviceScene, NamedMesh, Wanted, advice_scene
from triaxis.host.advice.widths import Board, lanes_of_builds, width_row, with_resources
from triaxis.host.cli import main
from triaxis.host.engines import MeshEngineScene
from triaxis.host.quantise import NOWHERE, Box, Steps, Vector
from triaxis.host.scene import distance_of
from triaxis.host.scenes import box, mesh_data, tool, vise, write_stl
from triaxis.host.stl import StlMesh
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.paths import ROOT

BOARD = Board(dsps=240, depth=4096, group=8)


def blocks(width: int, margin_bits: int, _shape: EngineShape) -> int:
    """Stand in for the counter: grows with both, 240 at 16 bits of coordinate and 16 of margin."""
    return 14 * width + margin_bits


def vector(*numbers: float) -> Vector:
    x, y, z = (Fraction(str(c)) for c in numbers)
    return x, y, z


def scene_of_tool(move: Vector = NOWHERE, travel: Box = (NOWHERE, NOWHERE)) -> AdviceScene:
    meshes = [
        NamedMesh("tool", StlMesh(tool(), Fraction(0))),
        NamedMesh("vise", StlMesh(vise(), Fraction(0))),
    ]
    return advice_scene(meshes, move, travel)


def advice_of(scene: AdviceScene, wanted: Wanted, board: Board = BOARD, positions: int = 2) -> Advice:
    rows = all_rows(scene, wanted, Steps.DECIMAL, board, blocks)
    return advise(scene, wanted, board, rows, positions_of(scene, wanted, positions, lambda _: None))


def random_mesh(rng: np.random.Generator, count: int) -> StlMesh:
    centres = rng.uniform(-1, 1, (count, 1, 3))
    return StlMesh((centres + rng.uniform(-0.3, 0.3, (count, 3, 3))).astype(np.float32), Fraction(0))


# --- What is true -------------------------------------------------------------------------------------------


def test_exact_nearness_is_that_of_the_golden_model(rng: np.random.Generator):
    a, b = random_mesh(rng, 14), random_mesh(rng, 9)
    move = vector(0.1, -0.3, 0.25)
    distances = {(i, j): distance_of(a, i, b, j, move) for i in range(14) for j in range(9)}
    # A clearance that one pair has exactly.
    for clearance in (Fraction(0), Fraction(1, 4), sorted(distances.values())[60]):
        found = exact_near(a, b, move, clearance, 10**6, 10**4)
        assert found.near.tolist() == [9 * i + j for (i, j), d in distances.items() if d <= clearance]
        assert not len(found.undecided)


def test_pairs_that_were_not_judged_are_told(rng: np.random.Generator):
    a = random_mesh(rng, 10)
    found = exact_near(a, a, NOWHERE, Fraction(0), 10**6, 0)
    # Each facet touches itself, which only the golden model can say.
    assert set(range(0, 100, 11)) <= set(found.undecided.tolist())
    assert not len(found.near)
    with pytest.raises(TooManyError):
        exact_near(a, a, NOWHERE, Fraction(0), 5, 0)


# --- What the engine does -----------------------------------------------------------------------------------


@pytest.mark.simulator
@pytest.mark.parametrize("margin", [0, 300, 4000])
def test_work_of_the_engine_is_bounded_on_both_sides(rng: np.random.Generator, margin: int):
    """More facets than the engine holds: several parts."""
    configuration = MeshConfiguration(16, 16, 64, 8, 8)
    shape = EngineShape(64, 8, 8)
    a, b = (rng.integers(-9000, 9000, (n, 1, 3)) + rng.integers(-700, 700, (n, 3, 3)) for n in (150, 70))
    move = (500, -300, 20)
    run = MeshEngineScene(a, b, configuration).run(move, margin)
    work = engine_work(LoadedMesh(a, shape), LoadedMesh(b, shape), np.array(move), margin, shape)
    assert work.parts == 3 * 2
    assert work.near.tolist() == (run.near[:, 0] * len(b) + run.near[:, 1]).tolist()
    assert (work.tested, work.group_pairs_opened) == (run.tested, run.group_pairs_opened)
    assert run.cycles is not None
    assert work.least_cycles <= run.cycles <= work.most_cycles
    assert work.most_cycles <= 2.5 * work.least_cycles + 400


# --- What a width means -------------------------------------------------------------------------------------


@pytest.mark.parametrize("clearance", ["0", "0.3", "1.75"])
@pytest.mark.parametrize("travel", [(NOWHERE, NOWHERE), (vector(-5, 0, -8), vector(10, 0, 0))])
def test_no_pair_is_missed_and_alarms_are_within_the_band(clearance: str, travel: Box):
    scene, wanted = scene_of_tool(vector(3, 4, 0.7), travel), Wanted(Fraction(clearance), Fraction(1))
    positions = positions_of(scene, wanted, 2, lambda _: None)
    alarms, false_alarms = 0, 0
    for width in (8, 10, 13, 16, 21, 32):
        row = width_row(scene, wanted, width, Steps.DECIMAL, BOARD, blocks)
        # Raises where a pair is missed.
        measured = measure(scene, row, positions)
        assert measured is not None
        assert row.band is not None
        beyond = positions_of(scene, Wanted(wanted.clearance + row.band, Fraction(1)), 2, lambda _: None)
        within = sum(len(truth.near) for position in beyond for truth in position.truth or ())
        assert measured.alarms <= within
        alarms, false_alarms = alarms + measured.alarms, false_alarms + measured.false_alarms
    assert 0 < false_alarms <= alarms


def test_a_margin_that_does_not_cover_the_rounding_is_noticed(monkeypatch: pytest.MonkeyPatch):
    scene, wanted = scene_of_tool(vector(0.3, 0.2, 0.5)), Wanted(Fraction(1, 2), Fraction(1))
    positions = positions_of(scene, wanted, 1, lambda _: None)
    monkeypatch.setattr(widths, "margin_for", lambda c, grid, _: int(c / grid.resolution) - 1)
    row = width_row(scene, wanted, 12, Steps.DECIMAL, BOARD, blocks)
    with pytest.raises(CertificateError, match=r"W = 12.*near pairs give no alarm"):
        measure(scene, row, positions)


def test_a_width_too_small_for_the_clearance_says_so():
    scene = scene_of_tool()
    row = width_row(scene, Wanted(Fraction(500), Fraction(1)), 8, Steps.DECIMAL, BOARD, blocks)
    assert (row.margin, row.band, row.dsps) == (None, None, None)
    assert "clearance, 500 mm, is more than 8 bits" in row.problems[0]
    assert measure(scene, row, []) is None


def test_what_rules_a_width_out():
    scene, wanted = scene_of_tool(), Wanted(Fraction(1, 2), Fraction(1, 100))
    assert width_row(scene, wanted, 16, Steps.DECIMAL, BOARD, blocks).meets
    coarse = width_row(scene, wanted, 13, Steps.DECIMAL, BOARD, blocks)
    assert ["band" in problem for problem in coarse.problems] == [True]
    large = width_row(scene, wanted, 18, Steps.DECIMAL, BOARD, blocks)
    assert ["DSP blocks of 240" in problem for problem in large.problems] == [True]
    few = width_row(scene, wanted, 16, Steps.DECIMAL, Board(240, 4096, 8, margin_bits=3), blocks)
    assert "does not fit M = 3" in few.problems[0]


def test_lanes_are_those_of_the_boards_builds():
    assert [lanes_of_builds(width) for width in (8, 16, 17, 24, 32)] == [8, 8, 1, 1, 1]


def test_positions_lie_within_the_travel():
    low, high = vector(-1, 0, 2), vector(3, 0, 4)
    scene = scene_of_tool(NOWHERE, (low, high))
    places = scene.positions(20)
    assert len(set(places)) == 20
    assert all(a <= c <= b for place in places for a, c, b in zip(low, place, high, strict=True))
    assert scene_of_tool().positions(20) == [NOWHERE]


# --- The choice ---------------------------------------------------------------------------------------------


def test_the_smallest_width_that_will_do_is_advised_with_its_reasons():
    advice = advice_of(scene_of_tool(vector(0, 0, 2)), Wanted(Fraction(1, 2), Fraction(1, 20)))
    assert advice.chosen is not None
    assert [row.width for row in advice.rows] == list(range(8, 33))
    number = advice.rows.index(advice.chosen)
    assert not any(row.meets for row in advice.rows[:number])
    text = "\n".join(advice.reasons)
    assert f"W = {advice.chosen.width} is the smallest width" in text
    assert f"W = {advice.chosen.width - 1} is not enough: its band is" in text
    assert f"W = {advice.chosen.width + 1} costs 15 more DSP blocks" in text
    assert "each mesh fits the engine's 4,096 triangles" in text
    assert advice.chosen_measured is not None


def test_a_mesh_beyond_the_engines_memory_is_named():
    board = Board(240, 64, 8)
    advice = advice_of(scene_of_tool(vector(0, 0, 2)), Wanted(Fraction(1, 2), Fraction(1, 20)), board)
    assert any(
        "tool: 336 facets do not fit the engine's 64: it is run in 6 parts" in r for r in advice.reasons
    )


def test_where_no_width_fits_the_reasons_say_what_to_change():
    scene, wanted = scene_of_tool(vector(0, 0, 2)), Wanted(Fraction(1, 2), Fraction(1, 10**4))
    advice = advice_of(scene, wanted)
    assert advice.chosen is None
    assert "needs W = 23: it takes 337 DSP blocks" in advice.reasons[0]
    assert "the widest that fits the board is W = 16" in advice.reasons[1]
    band = next(row.band for row in advice.rows if row.width == 16)
    assert band is not None
    # Each change does help.
    accepted = Wanted(wanted.clearance, band)
    assert advice_of(scene, accepted).chosen is not None
    assert any("a part with 337 DSP blocks" in change for change in advice.changes)
    assert advice_of(scene, wanted, Board(337, 4096, 8)).chosen is not None
    assert any("in a volume of at most" in change for change in advice.changes)
    small = NamedMesh("small", StlMesh(box((0, 0, 0), (1, 1, 1)), Fraction(0)))
    at_hand = advice_scene([small, small], vector(0, 0, 0.1))
    assert advice_of(at_hand, wanted).chosen is not None


def test_a_board_that_is_full_rules_a_width_out():
    scene, wanted = scene_of_tool(), Wanted(Fraction(1, 2), Fraction(1, 100))
    row = width_row(scene, wanted, 16, Steps.DECIMAL, BOARD, blocks)
    assert with_resources(row, None) == row
    assert with_resources(row, Resources(240, 63_400, 126_800, 135)).meets
    full = with_resources(row, Resources(240, 63_401, 126_800, 135.5))
    assert len(full.problems) == 2
    assert "63,401 look-up tables of 63,400" in full.problems[0]


def test_a_synthesis_is_kept_for_its_own_build_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    scene, wanted = scene_of_tool(), Wanted(Fraction(1, 2), Fraction(1, 100))
    row = width_row(scene, wanted, 16, Steps.DECIMAL, BOARD, blocks)
    other = width_row(scene, wanted, 17, Steps.DECIMAL, BOARD, blocks)
    used = Resources(161, 27_035, 20_602, 57.5)
    made: list[int] = []

    class Made:
        def __init__(self) -> None:
            self.used = used

    def synthesise(
        _sources: object, _include: object, _top: str, parameters: dict[str, int], _f: Path
    ) -> Made:
        made.append(parameters["W"])
        return Made()

    monkeypatch.setattr(widths, "_FOLDER", tmp_path)
    monkeypatch.setattr(widths, "synthesise", synthesise)
    monkeypatch.setattr(widths, "yosys_version", lambda: "stand-in")
    assert widths.known_resources(row) is None
    assert widths.synthesised_resources(row) == used
    assert widths.synthesised_resources(row) == used == widths.known_resources(row)
    assert widths.known_resources(other) is None
    assert made == [16]


# --- Bad input ----------------------------------------------------------------------------------------------


def test_a_scene_of_one_mesh_is_none():
    with pytest.raises(InputError, match="at least two STL files"):
        advice_scene([NamedMesh("tool", StlMesh(tool(), Fraction(0)))], NOWHERE)


def test_what_stands_outside_the_volume_is_named():
    meshes = [NamedMesh(name, StlMesh(tool(), Fraction(0))) for name in ("one", "two")]
    volume = vector(-40, -40, -1), vector(40, 40, 90)
    advice_scene(meshes, NOWHERE, (NOWHERE, vector(0, 0, 5)), volume)
    with pytest.raises(InputError, match=r"^one: reaches from 0 to 90\.5 in z, beyond the volume's -1 to 90"):
        advice_scene(meshes, NOWHERE, (NOWHERE, vector(0, 0, 5.5)), volume)


# --- The command --------------------------------------------------------------------------------------------


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return tool and vise as files; the counter of blocks is a stand-in: it takes seconds."""

    class Counts:
        def __init__(self, *_: object) -> None:
            pass

        def board(self, width: int, margin_bits: int, depth: int, group: int, lanes: int) -> DspCount:
            return DspCount(0, 0, blocks(width, margin_bits, EngineShape(depth, group, lanes)))

    monkeypatch.setattr("triaxis.host.cli.scene.DspCounts", Counts)
    paths = [tmp_path / "tool.stl", tmp_path / "vise.stl"]
    write_stl(paths[0], tool())
    write_stl(paths[1], vise())
    return [str(path) for path in paths]


def test_the_command_advises(files: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    written = tmp_path / "advice.json"
    words = ["--clearance", "0.5", "--move", "0", "0", "2", "--travel", "z", "-4", "0", "--positions", "2"]
    assert main(["scene", "advise", *files, *words, "--json", str(written)]) == 0
    said = capsys.readouterr().out
    report = json.loads(written.read_text())
    assert f"ADVICE: W = {report['chosen']}, " in said
    chosen = next(row for row in report["widths"] if row["width"] == report["chosen"])
    assert chosen["meets"]
    assert chosen["band_mm"] <= report["wanted_band_mm"] == 0.05
    assert Fraction(chosen["resolution_exactly"]) == Fraction(str(chosen["resolution_mm"]))
    assert chosen["measured"]["positions"] == 2
    assert chosen["measured"]["tested"] > 0
    assert report["travel_mm"] == [[0, 0, -4], [0, 0, 0]]


def test_lengths_are_millimetres_whatever_the_unit(files: list[str], capsys: pytest.CaptureFixture[str]):
    assert main(["scene", "advise", *files, "--clearance", "0.5"]) == 0
    once = capsys.readouterr().out.splitlines()[2:]
    assert main(["scene", "advise", *files, "--clearance", "5", "--scale", "10"]) == 0
    tenfold = capsys.readouterr().out.splitlines()[2:]
    assert once[0].startswith("volume: 200 x 180 x 145 mm; clearance 0.5 mm")
    assert tenfold[0].startswith("volume: 2000 x 1800 x 1450 mm; clearance 5 mm")
    advised = [next(line for line in text if "ADVICE" in line) for text in (once, tenfold)]
    assert advised[0].split(",")[0] == advised[1].split(",")[0]


@pytest.mark.simulator
def test_the_simulated_engine_keeps_within_the_bounds(
    files: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    """The width that other tests have built, and meshes in parts."""
    written = tmp_path / "advice.json"
    words = ["--clearance", "0.5", "--band", "0.009", "--move", "10", "5", "0.25", "--margin-bits", "16"]
    rtl = ["--depth", "64", "--lanes", "8", "--engine", "rtl", "--json", str(written)]
    assert main(["scene", "advise", *files, *words, *rtl]) == 0
    report = json.loads(written.read_text())
    assert report["chosen"] == 16
    measured = next(row["measured"] for row in report["widths"] if row["width"] == 16)
    assert measured["parts"] == 6
    assert measured["least_cycles"] <= report["cycles_simulated"] <= measured["most_cycles"]
    assert f"simulated: {report['cycles_simulated']:,} cycles" in capsys.readouterr().out


def test_no_width_fits(files: list[str], capsys: pytest.CaptureFixture[str]):
    assert main(["scene", "advise", *files, "--clearance", "0.5", "--band", "0.00001"]) == 1
    said = capsys.readouterr().out
    assert "NO WIDTH FITS" in said
    assert "change: accept false alarms up to" in said


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--clearance", "-1"], "clearance -1: must not be negative"),
        (["--clearance", "0"], "band: a clearance of 0 gives none"),
        (["--clearance", "1", "--band", "0"], "band 0: must be positive"),
        (["--clearance", "1", "--scale", "0"], "scale 0: must be positive"),
        (["--clearance", "1", "--depth", "100"], "depth 100: must be a power of two"),
        (["--clearance", "1", "--depth", "65536"], "the board holds at most 32768"),
        (["--clearance", "1", "--lanes", "3"], "lanes 3: must be a power of two"),
        (["--clearance", "1", "--lanes", "0"], "lanes 0: must be a power of two"),
        (["--clearance", "1", "--margin-bits", "40"], "margin bits 40: must be 0..32"),
        (["--clearance", "1", "--dsps", "0"], "--dsps: 0: must be at least 1"),
        (["--clearance", "1", "--positions", "0"], "--positions: 0: must be at least 1"),
        (["--clearance", "1", "--travel", "w", "0", "1"], "--travel w: must be x, y or z"),
        (["--clearance", "1", "--travel", "z", "0", "up"], "--travel z up: not a finite decimal number"),
        (["--clearance", "1", "--volume", *"000011"], "volume: X0 Y0 Z0 must be below"),
        (["--clearance", "1", "--volume", *"000111"], "tool.stl: reaches from"),
    ],
)
def test_bad_options(files: list[str], capsys: pytest.CaptureFixture[str], words: list[str], complaint: str):
    assert main(["scene", "advise", *files, *words]) == 2
    caught = capsys.readouterr()
    assert complaint in caught.err
    assert caught.err.count("\n") == 1
    assert not caught.out


def test_scenes_with_too_many_near_pairs_are_not_measured(
    files: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(measuring, "_MOST_PAIRS", 50)
    assert main(["scene", "advise", *files, "--clearance", "0.5"]) == 0
    assert "not measured on the scene" in capsys.readouterr().out


@pytest.mark.regress
@pytest.mark.skipif(mesh_data() is None, reason="no folder $TRIAXIS_DATA or ../shared/data")
def test_a_machine(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Carousel and arm, in units of 10 mm, with the blocks of the real board."""
    data = mesh_data()
    assert data is not None
    meshes = [str(data / "vmc" / f"{name}.stl") for name in ("carousel", "arm")]
    written = tmp_path / "advice.json"
    assert (
        main(["scene", "advise", *meshes, "--clearance", "1", "--scale", "10", "--json", str(written)]) == 0
    )
    report = json.loads(written.read_text())
    chosen = next(row for row in report["widths"] if row["width"] == report["chosen"])
    assert chosen["width"] == 14
    assert chosen["dsps"] == 161
    assert chosen["measured"]["alarms"] >= 1
    assert chosen["measured"]["undecided"] == 0
    assert "do not fit the engine's 4,096" in capsys.readouterr().out


@pytest.mark.regress
def test_the_page_shows_what_the_command_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    """Run the commands of docs/choosing-w.md; each line shown must be a line said."""
    blocks_shown = (ROOT / "docs" / "choosing-w.md").read_text(encoding="utf-8").split("```\n")
    commands, shown = blocks_shown[1].splitlines(), blocks_shown[3].splitlines()
    monkeypatch.chdir(tmp_path)
    for command in commands:
        program, *words = command.split()
        assert program == ".venv/bin/triaxis"
        assert main(words) == 0
    said = capsys.readouterr().out.splitlines()
    assert len(shown) > 5
    assert [line for line in shown if line not in said] == []
