"""Matching and checking of runs of the engine, without a simulator: right ones pass, wrong ones are said."""

from dataclasses import replace

import numpy as np
import pytest

from triaxis.golden.scene import scene_answer
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import NO_ZONES, Mode, Status, Trial
from triaxis.verif.core.items import ResetSeen
from triaxis.verif.mesh.checking import SceneChecker
from triaxis.verif.mesh.expectation import Memory, expected_signature, tried, walked
from triaxis.verif.mesh.items import (
    AbortAsked,
    CorePairs,
    Loaded,
    NearTaken,
    ObservedRun,
    RunAccepted,
    RunRequest,
    Summary,
)
from triaxis.verif.mesh.sampling import row_of
from triaxis.verif.mesh.scoreboard import RunMatcher

CONFIGURATION = MeshConfiguration(16, 16, 64, 4, 2, 8)
MOVE, MARGIN, COUNTS = (3, -2, 1), 5, (24, 23)


def summary_of(a, b, *numbers):
    """A summary of these numbers, with what else is due where A and B are held."""
    signatures = expected_signature(a, CONFIGURATION.width), expected_signature(b, CONFIGURATION.width)
    return Summary(
        *numbers, offered_after=numbers[1], wait=0, held=(len(a), len(b)), signatures=signatures, overfull=0,
        fault=0, clock=0,
    )  # fmt: skip


class Bench:
    """A scene with the answer that is due, and what a checker says of another one."""

    def __init__(self, seed, mode=Mode.ALL, zones=NO_ZONES):
        rng = np.random.default_rng(seed)
        self.a, self.b = (rng.integers(-50, 50, (n, 1, 3)) + rng.integers(-30, 31, (n, 3, 3)) for n in COUNTS)
        self.request = RunRequest(MOVE, MARGIN, int(mode), zones=zones)
        inner, answer = (
            scene_answer(self.a + np.array(MOVE), self.b, m, 4) for m in (MARGIN, max(MARGIN, *zones))
        )
        self.answer = answer
        self.core, self.near = answer.to_be_tested, inner.near_pairs
        assert len(self.near) > 3 and answer.pairs_skipped
        self.tested = len(self.core)
        if mode == Mode.FIRST:
            self.tested = int((self.core == self.near[0]).all(1).argmax()) + 1
            self.near, self.core = self.near[:1], self.core[: self.tested + 3]
        status = Status.FIRST if mode == Mode.FIRST else Status.COMPLETE
        self.summary = summary_of(
            self.a, self.b, status, 200, answer.group_pairs_skipped, answer.group_pairs_opened,
            answer.pairs_skipped, self.tested, len(self.near), 3,
        )  # fmt: skip
        if mode == Mode.COUNT:
            self.near = self.near[:0]

    def said(self, summary=None, near=None, core=None, aborts=()):
        """Return what is wrong with a run of the scene."""
        checker = SceneChecker(CONFIGURATION)
        matcher = RunMatcher(CONFIGURATION.depth, checker.check)
        matcher.load(Loaded(0, True, self.a))
        matcher.load(Loaded(1, True, self.b))
        matcher.run(RunAccepted(self.request))
        for at in aborts:
            matcher.run(AbortAsked(at))
        matcher.core(CorePairs(self.core if core is None else core))
        matcher.near(NearTaken(self.near if near is None else near))
        matcher.summary(summary or self.summary)
        assert checker.runs == 1 and not matcher.stray
        return [failure.message for failure in checker.failures]


NO = False, False
TRIANGLE = np.array([[[0, 0, 0], [9, 0, 9], [0, 9, 9]]])


def observed(b, tries=(0, 0)):
    """A run of one triangle and some others, and its answer."""
    request = RunRequest(tries=tries)
    return ObservedRun(RunAccepted(request), TRIANGLE, b, NO, NO), scene_answer(TRIANGLE, b, 0, 4)


@pytest.mark.parametrize("tries", [(Trial.CLAIM, 3), (Trial.PARITY, 0), (Trial.NUMBER, 2)])
def test_an_attempt_comes_to_be_tried_where_a_certified_core_is_asked(tries):
    certified = replace(CONFIGURATION, certified=True)
    assert tried(*observed(TRIANGLE, tries), certified).comes
    # The boxes decide; the core has no certifier; nothing is there; the run is refused.
    run, answer = observed(TRIANGLE, tries)
    assert not tried(*observed(TRIANGLE + 100, tries), certified).comes
    assert not tried(run, answer, CONFIGURATION).comes
    assert not tried(*observed(TRIANGLE[:0], tries), certified).comes
    assert not tried(run, None, certified).comes


def test_a_memory_comes_to_be_tried_where_the_scan_reads_it_or_scrubbing_does():
    apart = TRIANGLE + 100
    for memory in Memory:
        assert tried(*observed(TRIANGLE, (Trial.MEMORY, memory)), CONFIGURATION).comes
        found = tried(*observed(apart, (Trial.MEMORY, memory)), CONFIGURATION)
        assert found.comes == found.may_fail == (memory == Memory.GROUPS_A)
        assert tried(*observed(apart, (Trial.MEMORY, 8 + memory)), CONFIGURATION).comes
    # One that is no memory's is seen to do nothing by a scan.
    assert tried(*observed(apart, (Trial.MEMORY, 7)), CONFIGURATION).comes
    assert not tried(*observed(apart[:0], (Trial.MEMORY, 7)), CONFIGURATION).comes


def test_gaps_are_those_of_complete_runs():
    run, answer = observed(TRIANGLE + 9)
    ended = summary_of(run.a, run.b, Status.COMPLETE, 50, 0, 1, 0, 1, 1, 3)
    gaps = [row_of(CONFIGURATION, run, replace(ended, status=status), answer).row_gaps for status in Status]
    assert [bool(found) for found in gaps] == [status == Status.COMPLETE for status in Status]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"status": 7}, "status 7"),
        ({"cycles": 199}, "199 cycles, 200 were seen"),
        ({"group_pairs_opened": 0}, "group_pairs_opened 0"),
        ({"held": (23, 23)}, "triangles held"),
        ({"overfull": 1}, "overfull 1, 0 is due"),
    ],
)
def test_a_wrong_summary_is_said(seed, change, message):
    bench = Bench(seed)
    found = bench.said(replace(bench.summary, **change))
    assert any(message in line for line in found), found


def test_what_is_due_passes_in_every_mode_and_with_saturated_cycles(seed):
    for mode in Mode:
        assert Bench(seed, mode).said() == []
    bench = Bench(seed)
    long = replace(bench.summary, offered_after=9000)
    assert bench.said(replace(long, cycles=255)) == []
    assert bench.said(replace(long, cycles=254))


@pytest.mark.parametrize(("at", "due"), [(0, Status.ABORTED), (198, Status.ABORTED), (199, Status.COMPLETE)])
def test_an_abort_counts_up_to_the_clock_before_the_summary(seed, at, due):
    bench = Bench(seed)
    for status in (Status.COMPLETE, Status.ABORTED):
        found = bench.said(replace(bench.summary, status=status), aborts=[at])
        assert any("status" in line for line in found) == (status != due)


def test_an_aborted_run_is_a_part_of_the_scan(seed):
    bench = Bench(seed)
    tested = bench.tested // 2
    part = [tuple(pair) for pair in bench.core[:tested].tolist()]
    near = np.array([pair for pair in bench.near.tolist() if tuple(pair) in part])
    cut = replace(bench.summary, status=Status.ABORTED, tested=tested, near=len(near))
    assert bench.said(cut, near, bench.core[: tested + 2], [50]) == []
    assert bench.said(cut, near, bench.core[: tested - 1], [50])
    assert bench.said(replace(cut, near=len(near) + 1), near, bench.core[:tested], [50])
    assert bench.said(cut, near[:-1], bench.core[:tested], [50])
    assert bench.said(replace(cut, pairs_skipped=10_000), near, bench.core[:tested], [50])
    assert bench.said(cut, near, bench.core[:tested], [])
    # The walk was at the last pair there, and of those in the core so many can be without a verdict.
    for counter, least in walked(bench.answer, tested).items():
        assert bench.said(replace(cut, **{counter: least - 1}), near, bench.core[:tested], [50])
        assert not bench.said(replace(cut, **{counter: least}), near, bench.core[:tested], [50])
    none = replace(cut, tested=0, near=0)
    for reached in (CONFIGURATION.most_in_flight, CONFIGURATION.most_in_flight + 1):
        found = bench.said(none, near[:0], bench.core[:reached], [50])
        assert bool(found) == (reached > CONFIGURATION.most_in_flight)


def test_what_a_walk_has_counted_at_least_is_what_the_scan_passes(seed):
    answer = Bench(seed).answer
    group, counts, found = answer.group, [0, 0, 0], []
    for row, column in np.ndindex(answer.groups_apart.shape):
        counts[0 if answer.groups_apart[row, column] else 1] += 1
        if answer.groups_apart[row, column]:
            continue
        inside = (slice(group * n, group * (n + 1)) for n in (row, column))
        for boxes_apart in answer.boxes_apart[tuple(inside)].flat:
            counts[2] += int(boxes_apart)
            if not boxes_apart:
                found.append(list(counts))
    assert [list(walked(answer, n + 1).values()) for n in range(answer.tested)] == found
    assert not any(walked(answer, 0).values())


def test_first_is_the_first_of_the_scan(seed):
    bench, whole = Bench(seed, Mode.FIRST), Bench(seed)
    assert bench.said(near=whole.near[1:2])
    assert bench.said(replace(bench.summary, status=Status.COMPLETE))
    assert bench.said(replace(bench.summary, tested=bench.tested + 1, near=1))
    assert bench.said(aborts=[100]) == []
    assert bench.said(replace(bench.summary, group_pairs_opened=0))


ZONES = 12, 20


def test_with_zones_a_pair_may_be_asked_again_and_near_pairs_come_as_they_were_asked_last(seed):
    bench = Bench(seed, zones=ZONES)
    last = np.concatenate([bench.core, bench.near[::-1]])
    assert bench.said() == [] and bench.said(near=bench.near[::-1], core=last) == []
    assert bench.said(core=last) and bench.said(near=bench.near[::-1])
    # In three zones three times.
    seldom = bench.core[~(bench.core[:, None] == bench.near).all(2).any(1)][:1]
    for times in range(3, 5):
        core = np.concatenate([bench.core, *[seldom] * (times - 1)])
        assert bool(bench.said(core=core)) == (times > 3)
    # What is asked first comes in the order of the scan all the same, and no near pair is lost or doubled.
    for core in (bench.core[::-1], bench.core[1:]):
        assert bench.said(core=core)
    for near in (bench.near[1:], np.concatenate([bench.near, bench.near[:1]])):
        assert bench.said(near=near)
    plain = Bench(seed)
    assert plain.said(core=np.concatenate([plain.core, plain.core[:3]])) and plain.said(near=plain.near[::-1])


@pytest.mark.parametrize(
    ("gap", "zones", "status", "right"),
    [
        (30, ZONES, Status.COMPLETE, {0}),
        (20, ZONES, Status.COMPLETE, {2}),
        (12, ZONES, Status.COMPLETE, {3}),
        (12, NO_ZONES, Status.COMPLETE, {3}),
        (20, (20, 0), Status.COMPLETE, {3}),
        (21, (20, 0), Status.COMPLETE, {2}),
        (21, (0, 20), Status.COMPLETE, {1}),
        (20, (0, 20), Status.ABORTED, {1, 3}),
        (20, ZONES, Status.ABORTED, {0, 2}),
        (12, ZONES, Status.ABORTED, {0, 2, 3}),
    ],
)
def test_zones_are_those_in_which_something_is(gap, zones, status, right):
    bench = Bench(1, zones=zones)
    bench.a, bench.b = np.zeros((1, 3, 3), np.int64), np.full((1, 3, 3), gap)
    bench.request = replace(bench.request, translation=(0, 0, 0))
    reaches = gap <= max(MARGIN, *zones)
    bench.core, bench.near = (np.zeros((n, 2), np.int64) for n in (int(reaches), 0))
    counts = 1 - reaches, int(reaches), 0, int(reaches), 0
    end = summary_of(bench.a, bench.b, status, 200, *counts, 3)
    aborts = [50] if status == Status.ABORTED else []
    passing = {found for found in range(4) if not bench.said(replace(end, zones=found), aborts=aborts)}
    assert passing == right


def test_what_is_refused_runs_nothing(seed):
    bench = Bench(seed)
    nothing = summary_of(bench.a, bench.b, Status.BAD_MODE, 4, 0, 0, 0, 0, 0, 3)
    bench.request = replace(bench.request, mode=3)
    none = bench.near[:0]
    assert bench.said(nothing, none, none) == []
    assert bench.said(nothing, bench.near, none) and bench.said(nothing, none, bench.core)
    bench.request = RunRequest((40_000, 0, 0))
    assert bench.said(replace(nothing, status=Status.OVERFLOW), none, none) == []
    assert bench.said(nothing, none, none)


def test_matching_follows_meshes_limits_and_resets(seed):
    runs = []
    matcher = RunMatcher(4, lambda run, summary: runs.append(run))
    triangles = np.random.default_rng(seed).integers(-9, 9, (6, 3, 3))
    for mesh, clear, part in ((0, True, triangles[:3]), (0, False, triangles[3:]), (1, True, triangles[:2])):
        matcher.load(Loaded(mesh, clear, part))
    summary = summary_of(triangles, triangles, 5, 4, 0, 0, 0, 0, 0, 0)
    matcher.run(RunAccepted(RunRequest()))
    # At the edge at which the run was accepted, told after it.
    matcher.load(Loaded(1, False, triangles[2:3], with_run=True))
    matcher.summary(summary)
    assert (runs[0].a == triangles[:4]).all() and (runs[0].b == triangles[:3]).all()
    assert runs[0].overfull == (True, False) and runs[0].loaded_with_run
    assert not matcher.stray and matcher.triangles == 9
    # A reset empties everything.
    matcher.run(RunAccepted(RunRequest()))
    matcher.summary(ResetSeen())
    assert not matcher.unfinished and matcher.ended_by_reset == 1
    matcher.run(RunAccepted(RunRequest()))
    matcher.summary(summary)
    assert len(runs[1].a) == 0 and runs[1].overfull == (False, False)
    # What belongs to no run is kept.
    matcher.near(NearTaken(np.array([[0, 0]])))
    matcher.core(CorePairs(np.array([[0, 0]])))
    matcher.summary(summary)
    assert len(matcher.stray) == 3
