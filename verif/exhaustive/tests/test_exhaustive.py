"""Exhaustive runs: nothing is left out, nothing wrong is missed, and stopping loses nothing."""

import json
import shutil
from dataclasses import replace
from math import comb

import numpy as np
import pytest

from triaxis.golden.axes import separating
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.golden.judge import CertificateError, judge_pairs
from triaxis.host.cli import main
from triaxis.sim.core_engine import RtlEngine
from triaxis.sim.paths import DUT
from triaxis.sim.result import NEAR
from triaxis.sim.validity import standing
from triaxis.verif.commands import prove
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.failing_pairs import read_failing_pairs
from triaxis.verif.core.stimulus.symmetry import COORDINATES, REFLECTED
from triaxis.verif.exhaustive import run
from triaxis.verif.exhaustive.check import CONFIGURATION, check_class
from triaxis.verif.exhaustive.grid import Grid
from triaxis.verif.exhaustive.state import load, other_states, save, state_file


class Answers:
    """A core that answers what the oracle says, spoilt by a function of pairs, margins and words."""

    def __init__(self, spoil=lambda pairs, margins, words: words, oracle=bulk_facts):
        self.spoil, self.oracle = spoil, oracle

    def words(self, pairs, margins):
        words = expected_words(self.oracle(pairs, margins), CONFIGURATION)
        return self.spoil(pairs, margins, words), len(words)


def result_of(core, oracle=bulk_facts, classes=7):
    """Return the result of the first classes of grid 2."""
    return run._sum([check_class(Grid(2), core, oracle, 1, number) for number in range(classes)])


def equal(pairs):
    """Return which of the pairs are twice the same triangle."""
    return (np.sort(pairs[:, 0], 1) == np.sort(pairs[:, 1], 1)).all((1, 2))


def images(triangle, size):
    """Return the images of a triangle, a set of ascending point tuples, under the cube's symmetries."""
    found = set()
    for order, reflected in zip(COORDINATES.tolist(), REFLECTED.tolist(), strict=True):
        points = [
            tuple(size - 1 - p[k] if flip else p[k] for k, flip in zip(order, reflected, strict=True))
            for p in triangle
        ]
        found.add(tuple(sorted(points)))
    return found


@pytest.mark.parametrize(("size", "classes"), [(2, 7), (3, 136)])
def test_classes_cover_all_triangles_once(size, classes):
    grid = Grid(size)
    assert len(grid.classes) == classes
    points = [tuple(point) for point in grid.points.tolist()]
    triangles = {tuple(points[i] for i in triangle) for triangle in grid.triangles.tolist()}
    assert len(triangles) == len(grid.triangles) == comb(size**3 + 2, 3)
    covered = set()
    for representative, count in grid.classes:
        orbit = images([points[i] for i in grid.triangles[representative]], size)
        assert len(orbit) == count
        assert not orbit & covered
        covered |= orbit
    assert covered == triangles
    assert grid.arrangements.sum() == size**9
    assert (grid.arrangements[grid.classes.representatives] * grid.classes.sizes).sum() == size**9
    for triangle, orders in zip(grid.triangles.tolist(), grid.arrangements.tolist(), strict=True):
        assert orders == {1: 1, 2: 3, 3: 6}[len(set(triangle))]


def test_grid_2_counts_what_the_linear_program_counts():
    grid = Grid(2)
    result = result_of(Answers())
    total = 0
    for representative, count in grid.classes:
        a = grid.points[grid.triangles[representative]]
        pairs = np.stack([np.broadcast_to(a, (120, 3, 3)), grid.points[grid.triangles]], 1)
        near = judge_pairs(pairs.astype(np.int64), np.zeros(120, np.int64))["near"]
        total += int(grid.arrangements[near].sum() * grid.arrangements[representative]) * count
    counts = result.counts
    assert counts.ordered_near[0] == total == 197240
    # No two points of the grid are further apart than 1.
    assert counts.ordered_near[1] == counts.ordered[0] == counts.ordered[1] == 2**18
    assert (counts.pairs, counts.runs, counts.claims) == (840, 1680, 1680 - counts.near)


@pytest.mark.simulator
@pytest.mark.regress
def test_grid_3_passes_on_the_core_and_is_written(tmp_path, seed):
    assert run.run_grid(Grid(3), run.identity_of(3, seed), None, tmp_path).problems == []
    written = json.loads((tmp_path / "grid3.json").read_text())
    assert written["passed"] and written["counts"]["ordered"] == [3**18] * 2
    # Counted by the linear program alone: the distances of all 136 x 3654 pairs.
    assert written["counts"]["ordered_near"] == [202803363, 382838311]
    assert [path.name for path in tmp_path.iterdir()] == ["grid3.json"]


def flip_near_of_equal_triangles(pairs, margins, words):
    return words ^ (equal(pairs) & (margins == 1)).astype(np.uint16)


def claim_the_next_axis(pairs, margins, words):
    several = separating(pairs.astype(np.int64), margins).sum(1) > 1
    clear = (words & NEAR == 0) & several
    highest = 31 - separating(pairs.astype(np.int64), margins)[:, ::-1].argmax(1)
    return np.where(clear, words & 0xFF | highest << 8, words).astype(np.uint16)


def claim_a_zero_axis(pairs, margins, words):
    point_a = (pairs[:, 0] == pairs[:, 0, :1]).all((1, 2)) & (words & NEAR == 0)
    return np.where(point_a, words & 0xFF | 3 << 8, words).astype(np.uint16)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (flip_near_of_equal_triangles, "bulk checker"),
        (claim_the_next_axis, "bulk checker"),
        (claim_a_zero_axis, "does not separate"),
    ],
)
def test_a_wrong_core_is_caught(spoil, said):
    result = result_of(Answers(spoil))
    assert result.counts.mismatches > 0
    assert any(said in mismatch.message for mismatch in result.mismatches)


def test_near_at_one_margin_and_not_beyond_is_caught_without_an_oracle():
    def oracle(pairs, margins):
        # Box x is said to separate equal triangles at margin 1, by the core too.
        facts = bulk_facts(pairs, margins)
        return replace(facts, above=np.where(equal(pairs) & (margins == 1), 1, facts.above).astype(np.uint32))

    result = result_of(Answers(oracle=oracle), oracle)
    assert "near at margin 0 and not beyond" in {mismatch.message for mismatch in result.mismatches}


def test_an_oracle_that_the_linear_program_contradicts_is_an_error():
    def oracle(pairs, margins):
        return replace(bulk_facts(pairs, margins), rank_a=np.zeros(len(pairs), np.uint8))

    with pytest.raises(CertificateError, match="linear program"):
        result_of(Answers(), oracle)


def test_a_class_left_out_is_a_problem():
    grid, identity = Grid(2), run.identity_of(2, 1)
    for classes, problems in ((6, 2), (7, 0)):
        progress = run.Progress(result_of(Answers(), classes=classes))
        found = run.Outcome(identity, grid, progress, classes).problems
        assert len(found) == problems
        assert not found or "262144" in found[0]


def interrupt_after(classes):
    """Return a progress function that interrupts once so many classes are done."""
    done = 0

    def progress(step):
        nonlocal done
        done += step
        if done >= classes:
            raise KeyboardInterrupt

    return progress


@pytest.mark.simulator
@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.regress)])
def test_an_interrupted_run_is_continued(tmp_path, monkeypatch, workers):
    monkeypatch.setattr(run, "_RUNS_PER_REPORT", 1)
    grid, identity = Grid(2), run.identity_of(2, 7)
    whole = run.run_grid(grid, identity, None, tmp_path / "whole", 1)
    folder = tmp_path / "parts"
    with pytest.raises(KeyboardInterrupt):
        run.run_grid(grid, identity, interrupt_after(4), folder, workers)
    assert load(folder, identity).done == 4
    steps = []
    outcome = run.run_grid(grid, identity, steps.append, folder, workers)
    assert steps == [4, 1, 1, 1]
    assert outcome.new == 3
    assert outcome.progress.result == whole.progress.result
    assert outcome.problems == []
    assert not state_file(folder, identity).exists()


@pytest.mark.simulator
def test_what_was_written_to_meanwhile_leaves_neither_state_nor_result(tmp_path, monkeypatch):
    dut, folder = tmp_path / "dut", tmp_path / "runs"
    shutil.copytree(DUT, dut)
    monkeypatch.setattr(run, "standing", lambda sources: standing(sources, dut))
    monkeypatch.setattr(run, "_SECONDS_BETWEEN_SAVES", 0.0)
    file = dut / "core" / "triaxis_core.sv"
    with pytest.raises(InputError, match="was written to during the run"):
        run.run_grid(Grid(2), run.identity_of(2, 1), lambda _: file.write_text(file.read_text()), folder, 1)
    assert not list(folder.rglob("*.json"))
    other = replace(run.identity_of(2, 1), environment_hash="x")
    with pytest.raises(InputError, match="changed while the run started"):
        run.run_grid(Grid(2), other, None, folder, 1)


def test_states_of_other_runs_are_not_continued(tmp_path):
    identity = run.identity_of(2, 1)
    others = [replace(identity, **{name: "x"}) for name in ("seed", "rtl_hash", "environment_hash")]
    progress = run.Progress(result_of(Answers(), classes=1))
    for other in others:
        save(tmp_path, other, progress)
    assert load(tmp_path, identity).done == 0
    assert load(tmp_path, others[0]) == progress
    assert len(other_states(tmp_path, identity)) == 3
    # A state under the wrong name is no state of this run either.
    state_file(tmp_path, others[0]).rename(state_file(tmp_path, identity))
    with pytest.raises(InputError, match="another run"):
        load(tmp_path, identity)
    for text in ("", "[]", "{}", '{"identity": {"grid": 2}}'):
        state_file(tmp_path, identity).write_text(text)
        with pytest.raises(InputError, match="damaged"):
            load(tmp_path, identity)


class Broken(RtlEngine):
    """The core with a fault behind it: equal triangles are not near."""

    def words(self, pairs, margins):
        words, cycles = super().words(pairs, margins)
        return flip_near_of_equal_triangles(pairs, margins, words), cycles


@pytest.fixture
def broken(monkeypatch):
    monkeypatch.setattr(run, "RtlEngine", Broken)
    run._checker.cache_clear()
    yield
    run._checker.cache_clear()


@pytest.mark.simulator
def test_a_failing_run_says_what_failed(tmp_path, monkeypatch, capsys, broken):
    monkeypatch.setattr(prove, "WORKERS", 1)
    monkeypatch.setattr(prove, "FOLDER", tmp_path)
    # Many mismatches stop the run.
    monkeypatch.setattr(run, "ENOUGH_MISMATCHES", 3)
    monkeypatch.setattr(run, "_RUNS_PER_REPORT", 1)
    assert main(["prove", "exhaustive", "--grid", "2"]) == 1
    output, errors = capsys.readouterr()
    assert "FAILED: " in errors and "stopped after" in errors
    assert "ReplayTest --config w8_m1" in errors
    assert "passed" not in output
    written = json.loads((tmp_path / "grid2.json").read_text())
    assert not written["passed"]
    assert written["problems"]
    pairs, margins = read_failing_pairs(tmp_path / "grid2_failing_pairs.npz", CONFIGURATION)
    assert (margins == 1).all()
    assert equal(pairs).all()
    with np.load(tmp_path / "grid2_failing_pairs.npz") as file:
        assert file["context_counts"].max() == 64


@pytest.mark.simulator
def test_the_command_passes_and_refuses(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(prove, "FOLDER", tmp_path)
    assert main(["prove", "exhaustive", "--grid", "2", "--seed", "3"]) == 0
    output = capsys.readouterr().out
    assert "passed: 2^18 = 262144 ordered pairs" in output
    assert "margin 0: 197240 of 262144 ordered pairs are near" in output
    for words, said in (
        ("--grid 7", "grid 7: must be 2..6"),
        ("--seed -1", "--seed: -1: must not be negative"),
    ):
        assert main(["prove", "exhaustive", *words.split()]) == 2
        assert said in capsys.readouterr().err
