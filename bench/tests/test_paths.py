"""The benchmarks of paths: what is planted is there, and a miss is a problem; which programs are read."""

import shutil
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from triaxis.bench.paths import reading
from triaxis.bench.paths import report as paths
from triaxis.bench.paths.supervised import findings, supervised
from triaxis.bench.peers.peer import Peer, Question
from triaxis.golden.judge import judge
from triaxis.host.broadphase import candidates
from triaxis.host.cli import ERROR, main
from triaxis.host.motion.path_check import bulk_engine
from triaxis.host.shells import solid_of


@pytest.mark.long
def test_a_small_program_is_clear_and_what_is_planted_is_found(tmp_path):
    ours = paths.measured(tmp_path, 400, 30, 4, lambda _: None)
    assert (ours.clear, ours.missed, ours.moves, ours.facets) == (True, 0, 402, 2160)
    found = paths.findings(ours, [], [])
    # What the run took is told beside it, as of every benchmark.
    assert not found.problems and "seconds" not in found.content
    assert paths.findings(replace(ours, missed=1), [], []).problems == [
        "1 of 4 planted collisions were missed"
    ]
    assert paths.findings(replace(ours, clear=False), [], []).problems


@pytest.mark.long
def test_meshes_on_another_grid_are_no_evidence(tmp_path, monkeypatch):
    """A crash so deep that it is found anyway is not near where it is said to be, or a graze is missed."""

    def beside(scene):
        return bulk_engine(replace(scene, a=scene.a + np.array([0, 0, 2500])))

    monkeypatch.setattr(paths, "bulk_engine", beside)
    assert paths.measured(tmp_path, 400, 30, 4, lambda _: None).missed >= 2


@pytest.mark.long
@pytest.mark.simulator
def test_a_machine_is_supervised_without_a_false_stop_and_stopped_in_time(tmp_path):
    done = list[int]()
    found = supervised(tmp_path, 300, 3, done.append)
    assert sum(done) == 303
    assert (found.false_stops, found.planted, found.missed, found.late) == (0, 3, 0, 0)
    assert found.segments >= 300 and 100 < found.run_clocks < found.reaction_clocks < found.bound_clocks
    assert not findings(found).problems
    for wrong in ({"false_stops": 1}, {"missed": 1}, {"late": 1}, {"wanted": found.segments + 1}):
        assert len(findings(replace(found, **wrong)).problems) == 1


@pytest.mark.parametrize(
    ("segments", "planted", "why"),
    [
        ("-5", "1", "--segments: -5: must be at least 1"),
        ("300", "0", "--planted: 0: must be at least 1"),
        ("300", "4", "--planted 4: at most 3 in 300 segments"),
    ],
)
def test_more_is_not_planted_than_leaves_go_standing(capsys, segments, planted, why):
    assert main(["bench", "follow", f"--segments={segments}", f"--planted={planted}"]) == ERROR
    assert why in capsys.readouterr().err


def test_meshes_are_closed_and_turned_outwards():
    for mesh in (paths.relief(12), paths.ball_nosed(24)):
        found = solid_of(np.round(1000 * mesh).astype(np.int64)).shells
        assert (found.closed.tolist(), found.oriented.tolist()) == ([True], [True])
        # Six times the volume, positive where facets are turned outwards.
        assert np.linalg.det(mesh.astype(np.float64)).sum() > 0


def test_planted_moves_collide_between_ends_that_are_clear():
    tool, relief = paths.ball_nosed(24), paths.relief(40)

    def meet(place):
        a, b = (np.round(1000 * mesh).astype(np.int64) for mesh in (tool + place, relief))
        pairs = [(i, j) for blocks in candidates(a, b, 0) for i, j in zip(*blocks, strict=True)]
        return any(judge(a[i].tolist(), b[j].tolist(), 0).distance == Fraction(0) for i, j in pairs)

    for grazing in (False, True):
        for start, end in paths.planted(2, np.random.default_rng(3), grazing):
            # At the height at which it grazes it is not through the hill, but as near as it may not be.
            places = [place - [0, 0, 0.5 * grazing] for place in (start, (start + end) / 2, end)]
            assert [meet(place) for place in places] == [False, True, False]
            assert grazing != meet((start + end) / 2)


def test_answers_of_others_are_compared():
    moves, truth = paths.asked_moves(3)
    peer = Peer("x", "x", "x", lambda: "1", lambda a, b: Question(lambda: np.array([True, False] * 3)))
    found = paths.asked(peer, truth, 8)
    assert (len(moves), found.moves, found.missed, found.false) == (6, 6, 1, 1)


def test_programs_are_read_where_the_interpreter_completes_them(tmp_path):
    if shutil.which("rs274") is None:
        pytest.skip("rs274 is not installed")
    folder = tmp_path / "in" / "here"
    folder.mkdir(parents=True)
    for name, lines in {
        "plain.ngc": "G21 G0 X1 Y2\nM2", "tool.NC": "G21 T7 M6\nG43\nG0 Z9\nM2", "turn.nc": "G0 X1 C30\nM2",
        # Radius compensation takes the interpreter, a probe nobody knows; others it does not complete.
        "offset.nc": "G21 T3 M6\nG41\nG1 F100 X40\nY40\nG40\nM2", "probe.nc": "G38.2 Z-1 F9\nM2",
        "wrong.ngc": "G0 X\nM2", "still.ngc": "M2", "no.txt": "G0 X1\nM2",
    }.items():  # fmt: skip
        (folder / name).write_text(f"{lines}\n")
    files = sorted(path for path in tmp_path.rglob("*") if path.suffix.lower() in reading.SUFFIXES)
    assert len(files) == 7
    found = [one for path in files if (one := reading.read(tmp_path, path)) is not None]
    refused = {one.file.rsplit("/", 1)[1]: (bool(one.by_rs274), bool(one.by_own)) for one in found}
    both = (False, False)
    assert refused == {
        "plain.ngc": both, "tool.NC": both, "turn.nc": both,
        "offset.nc": (False, True), "probe.nc": (True, True),
    }  # fmt: skip
    told = reading.findings(found, 7)
    assert told.summary.startswith(
        "5 programs that rs274 completes, of 7 files: 4 accepted with it, 3 by our"
    )
    assert told.problems == [
        "with --reader rs274: 4 of 5 accepted: fewer than 95%",
        "by our own reader: 3 of 5 accepted: fewer than 75%",
    ]
    assert [len(table.rows) for table in told.tables] == [1, 2]
    assert not reading.findings([one for one in found if not one.by_own], 7).problems


def test_where_no_program_is_completed_nothing_is_shown():
    assert reading.findings([], 7).problems == [
        "none of the programs is completed by rs274: name another folder"
    ]
