"""Advice on the width of a core: what it rests on is exact, and the smallest that will do is advised."""

import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from triaxis.fpga.board_build import Resources
from triaxis.fpga.dsp_count import DspCount
from triaxis.golden.errors import InputError
from triaxis.golden.judge import CertificateError
from triaxis.host.advice import widths
from triaxis.host.advice.choosing import advise
from triaxis.host.advice.measuring import EngineShape, TooManyError, exact_near, measure, positions_of
from triaxis.host.advice.wanted import NamedMesh, Wanted, advice_scene
from triaxis.host.advice.widths import Board, width_row, with_resources
from triaxis.host.cli import main
from triaxis.host.quantise import NOWHERE, Steps, margin_for, vector
from triaxis.host.scene import distance_of
from triaxis.host.scenes import box, tool, vise, write_stl
from triaxis.host.stl import StlMesh
from triaxis.host.tests.published import read_published
from triaxis.sim.paths import ROOT

BOARD = Board(dsps=240, depth=4096, group=8)
NARROW = Wanted(Fraction(1, 2), Fraction(1, 100))


def blocks(width, margin_bits, _shape):
    """Stand in for the counter: grows with both, 240 at 16 bits of coordinate and 16 of margin."""
    return 14 * width + margin_bits


def place(*numbers):
    return vector(Fraction(str(c)) for c in numbers)


def named(name, facets):
    return NamedMesh(name, StlMesh(facets, Fraction(0)))


def scene_of_tool(move=NOWHERE, travel=(NOWHERE, NOWHERE)):
    return advice_scene([named("tool", tool()), named("vise", vise())], move, travel)


def row_of(width, wanted=NARROW, board=BOARD, scene=None):
    return width_row(scene or scene_of_tool(), wanted, width, Steps.DECIMAL, board, blocks)


def truths(scene, wanted, count=2):
    return positions_of(scene, wanted, count, lambda _: None)


def advice_of(scene, wanted, board=BOARD):
    rows = [row_of(width, wanted, board, scene) for width in widths.WIDTHS]
    return advise(scene, wanted, board, rows, truths(scene, wanted))


def random_mesh(rng, count):
    centres = rng.uniform(-1, 1, (count, 1, 3))
    return StlMesh((centres + rng.uniform(-0.3, 0.3, (count, 3, 3))).astype(np.float32), Fraction(0))


def test_exact_nearness_is_that_of_the_golden_model(rng):
    a, b = random_mesh(rng, 14), random_mesh(rng, 9)
    move = place(0.1, -0.3, 0.25)
    distances = {(i, j): distance_of(a, i, b, j, move) for i in range(14) for j in range(9)}
    # A clearance that one pair has exactly.
    for clearance in (Fraction(0), Fraction(1, 4), sorted(distances.values())[60]):
        found = exact_near(a, b, move, clearance, 10**6, 10**4)
        assert found.near.tolist() == [9 * i + j for (i, j), d in distances.items() if d <= clearance]
        assert not len(found.undecided)
    # Each facet touches itself, which only the golden model can say; what it was not asked is told.
    found = exact_near(a, a, NOWHERE, Fraction(0), 10**6, 0)
    assert set(range(0, 14 * 14, 15)) <= set(found.undecided.tolist())
    assert not len(found.near)
    with pytest.raises(TooManyError):
        exact_near(a, a, NOWHERE, Fraction(0), 5, 0)


@pytest.mark.parametrize("clearance", ["0", "1.75"])
@pytest.mark.parametrize("travel", [(NOWHERE, NOWHERE), (place(-5, 0, -8), place(10, 0, 0))])
def test_no_pair_is_missed_and_alarms_are_within_the_band(clearance, travel):
    scene, wanted = scene_of_tool(place(3, 4, 0.7), travel), Wanted(Fraction(clearance), Fraction(1))
    positions = truths(scene, wanted)
    alarms, false_alarms = 0, 0
    for width in (8, 10, 13, 16, 32):
        row = row_of(width, wanted, scene=scene)
        # Raises where a pair is missed.
        measured = measure(scene, row, positions)
        assert measured and row.band is not None
        beyond = truths(scene, Wanted(wanted.clearance + row.band, Fraction(1)))
        within = sum(len(truth.near) for position in beyond for truth in position.truth or ())
        assert measured.alarms <= within
        alarms, false_alarms = alarms + measured.alarms, false_alarms + measured.false_alarms
    assert 0 < false_alarms <= alarms


def test_a_margin_that_does_not_cover_the_rounding_is_noticed(monkeypatch):
    scene, wanted = scene_of_tool(place(0.3, 0.2, 0.5)), Wanted(Fraction(1, 2), Fraction(1))
    monkeypatch.setattr(widths, "margin_for", lambda c, grid, _: int(c / grid.resolution) - 1)
    with pytest.raises(CertificateError, match=r"W = 12.*near pairs give no alarm"):
        measure(scene, row_of(12, wanted, scene=scene), truths(scene, wanted, 1))


def test_what_rules_a_width_out():
    assert ["band" in problem for problem in row_of(13).problems] == [True]
    assert ["DSP blocks of 240" in problem for problem in row_of(18).problems] == [True]
    assert "does not fit M = 3" in row_of(16, board=Board(240, 4096, 8, margin_bits=3)).problems[0]
    row = row_of(16)
    assert row.meets and with_resources(row, Resources(240, 63_400, 126_800, 135)).meets
    assert len(with_resources(row, Resources(240, 63_401, 126_800, 135.5)).problems) == 2


@pytest.mark.parametrize("travel", [(NOWHERE, NOWHERE), (NOWHERE, place(0, 0, 1))], ids=["still", "moving"])
def test_a_grid_is_as_fine_as_volume_and_clearance_allow(travel):
    """A clearance of more than the volume is the largest margin, or next to it."""
    scene, clearance = scene_of_tool(travel=travel), Fraction(500)
    row = row_of(8, Wanted(clearance, Fraction(10)), scene=scene)
    assert row.meets and 250 < row.margin < 256 and row.band < 4 * row.grid.resolution
    finer = row.grid.resolution * Fraction(98, 100)
    with pytest.raises(InputError, match="use a coarser resolution"):
        margin_for(clearance, replace(row.grid, resolution=finer), scene.reading(finer))


def test_a_travel_to_one_place_is_a_move_that_is_rounded_by_itself():
    there = place(0, 0, 0.25)
    moved, travelled = scene_of_tool(there), scene_of_tool(travel=(there, there))
    assert travelled.positions(4) == [there] and travelled.volume == moved.volume
    assert travelled.reading(Fraction(1)) == moved.reading(Fraction(1)) + Fraction(1, 2)
    found, wanted = (measure(one, row_of(13, scene=one), truths(one, NARROW)) for one in (travelled, moved))
    assert found and wanted and found.tested >= wanted.tested > 0


TENTH, LARGE = Fraction(1, 10), Board(10**4, 4096, 8)


@pytest.mark.parametrize(
    ("board", "band", "count", "chosen", "told"),
    [
        (BOARD, Fraction(10), blocks, 8, ["no smaller width exists: 8 is the least"]),
        (LARGE, Fraction(11, 10**8), blocks, 32, ["no larger width exists: 32 is the most"]),
        (LARGE, TENTH, lambda width, *_: 300 - width, 13,
         ["W = 14 takes 1 DSP blocks fewer, 286, and", "; up to W = 32 no more blocks are needed, with"]),
        (LARGE, Fraction(1, 10**9), blocks, None, ["no width up to 32 has a band within 1e-09 mm"]),
        (Board(1, 4096, 8), TENTH, blocks, None,
         ["no width fits the board: W = 8: its band is 1.855 mm; it takes 114 DSP blocks of 1",
          "take a smaller clearance, or a part with more DSP blocks (--dsps)"]),
        (Board(240, 4096, 8, margin_bits=1), TENTH, blocks, None, ["clearance, or more --margin-bits"]),
    ],
)  # fmt: skip
def test_reasons_at_the_ends_of_what_there_is(monkeypatch, board, band, count, chosen, told):
    monkeypatch.setitem(globals(), "blocks", count)
    advice = advice_of(scene_of_tool(), Wanted(Fraction(1, 2), band), board)
    assert (advice.chosen and advice.chosen.width) == chosen
    said = "\n".join((*advice.reasons, *advice.changes))
    assert all(what in said for what in told), said
    monkeypatch.setattr("triaxis.host.advice.measuring._MOST_PAIRS", 5)
    last = advice_of(scene_of_tool(), Wanted(Fraction(1, 2), band), board).reasons[-1]
    assert not chosen or last == "not measured on the scene: too many pairs come near"


def test_points_that_are_one_are_near():
    point = named("point", np.zeros((1, 3, 3), np.float32))
    with pytest.raises(InputError, match="scene: one mesh: name at least two STL files"):
        advice_scene([point], NOWHERE)
    scene = advice_scene([point, point], NOWHERE, volume=(NOWHERE, place(9, 9, 9)))
    (found,) = positions_of(scene, Wanted(Fraction(0), Fraction(1)), 1, lambda _: None)
    assert found.truth and found.truth[0].near.tolist() == [0]


def test_where_no_width_fits_the_reasons_say_what_to_change():
    scene, wanted = scene_of_tool(place(0, 0, 2)), Wanted(Fraction(1, 2), Fraction(1, 10**4))
    advice = advice_of(scene, wanted)
    assert advice.chosen is None
    assert "needs W = 23: it takes 337 DSP blocks" in advice.reasons[0]
    # Each change does help: a larger band, a larger part, a smaller volume.
    band = next(row.band for row in advice.rows if row.width == 16)
    assert band and advice_of(scene, Wanted(wanted.clearance, band)).chosen
    assert advice_of(scene, wanted, Board(337, 4096, 8)).chosen
    small = named("small", box((0, 0, 0), (1, 1, 1)))
    assert advice_of(advice_scene([small, small], place(0, 0, 0.1)), wanted).chosen
    told = ("a part with 337 DSP blocks", "in a volume of at most")
    assert all(any(what in change for change in advice.changes) for what in told)


@pytest.fixture
def advise_files(tmp_path, monkeypatch, capsys):
    """Return a function that runs the command: its exit code and output. Counting blocks takes seconds."""

    class Counts:
        def __init__(self, *_):
            pass

        def board(self, width, margin_bits, depth, group, lanes):
            return DspCount(0, 0, blocks(width, margin_bits, EngineShape(depth, group, lanes)))

    monkeypatch.setattr("triaxis.host.cli.scene.DspCounts", Counts)
    paths = [tmp_path / "tool.stl", tmp_path / "vise.stl"]
    write_stl(paths[0], tool())
    write_stl(paths[1], vise())

    def run(*words):
        code = main(["scene", "advise", *map(str, paths), *map(str, words)])
        return code, *capsys.readouterr()

    return run


def test_the_command_advises(advise_files, tmp_path):
    written = tmp_path / "advice.json"
    words = ["--clearance", 0.5, "--move", 0, 0, 2, "--travel", "z", -4, 0, "--positions", 2]
    code, said, _ = advise_files(*words, "--json", written)
    report = read_published(written, "advice")
    assert code == 0
    assert f"ADVICE: W = {report['chosen']}, " in said
    chosen = next(row for row in report["widths"] if row["width"] == report["chosen"])
    assert chosen["meets"]
    assert not any(row["meets"] for row in report["widths"] if row["width"] < report["chosen"])
    assert chosen["band_mm"] <= report["wanted_band_mm"] == 0.05
    assert chosen["measured"]["positions"] == 2 and chosen["measured"]["tested"] > 0
    # Lengths are millimetres, whatever the unit.
    assert f"ADVICE: W = {report['chosen']}, " in advise_files("--clearance", 5, "--scale", 10)[1]
    code, said, _ = advise_files("--clearance", 0.5, "--band", "0.00001", "--positions", 1)
    assert code == 1
    assert "NO WIDTH FITS" in said
    assert "change: accept false alarms up to" in said


def test_the_next_width_is_synthesised_where_one_does_not_fit(advise_files, monkeypatch):
    left = [Resources(1, 63_401, 1), Resources(1, 63_400, 1)]
    monkeypatch.setattr("triaxis.host.cli.scene.known_resources", lambda _: None)
    monkeypatch.setattr("triaxis.host.cli.scene.synthesised_resources", lambda _: left.pop(0))
    words = ("--clearance", 0.5, "--positions", 1, "--dsps", 999, "--steps", "binary", "--synthesise")
    code, said, told = advise_files(*words)
    first, then = map(int, re.findall(r"W = (\d+): minutes", told))
    assert (code, left, then) == (0, [], first + 1) and f"ADVICE: W = {then}, " in said
    assert re.search(r"resolution 2\^-(\d+) = 0\.\d+ mm", said)


@pytest.mark.long
@pytest.mark.simulator
def test_the_simulated_engine_keeps_within_the_bounds(advise_files, tmp_path, rng):
    """The width that other tests have built, and meshes in parts."""
    written = tmp_path / "advice.json"
    words = ["--clearance", 0.5, "--band", "0.009", "--move", 10, 5, 0.25, "--margin-bits", 16]
    code, *_ = advise_files(*words, "--depth", 64, "--lanes", 8, "--engine", "rtl", "--json", written)
    report = read_published(written, "advice")
    assert (code, report["chosen"]) == (0, 16)
    measured = next(row["measured"] for row in report["widths"] if row["width"] == 16)
    assert measured["parts"] == 6
    assert measured["least_cycles"] <= report["cycles_simulated"] <= measured["most_cycles"]
    # One facet between many: its group is nearly empty, all groups are opened, and no pair is tested.
    write_stl(tmp_path / "tool.stl", np.array([[[-50, -50, 0], [50, -50, 0], [0, 50, 0]]], np.float32))
    heights = np.where(np.arange(448) % 2, 4, -4)[:, None, None] * np.array([0, 0, 1])
    between = rng.uniform(-1, 1, (448, 3, 3)) * (50, 50, 1) + heights
    write_stl(tmp_path / "vise.stl", between.astype(np.float32))
    words = ["--clearance", 0.5, "--band", "0.0065", "--margin-bits", 16, "--depth", 64, "--lanes", 8]
    code, *_ = advise_files(*words, "--engine", "rtl", "--json", written)
    report = read_published(written, "advice")
    measured = next(row["measured"] for row in report["widths"] if row["width"] == 16)
    assert (code, report["chosen"], measured["tested"]) == (0, 16, 0)
    assert measured["least_cycles"] <= report["cycles_simulated"] <= measured["most_cycles"]


@pytest.mark.regress
def test_the_page_shows_what_the_command_says(tmp_path, monkeypatch, capsys):
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
