"""Checks runs of the engine against the exact answer for their scene, free of the simulator.

Every pair is accounted for: it reached the core, or a box axis separates it, or its groups, or its group of A
from the whole of B, by more than the margin. What the summary says is compared with what follows from the
definition; the golden model judges a share of the pairs, which shares nothing with the bulk checker.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from triaxis.coverage.mesh_sample import UNKNOWN, Before, MeshRow
from triaxis.golden.judge import CertificateError, judge_pairs
from triaxis.golden.scene import SceneAnswer, scene_answer
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Mode, Status
from triaxis.verif.mesh.expectation import (
    Tried,
    begins,
    difference,
    expected_signature,
    expected_status,
    first_of,
    in_order_of,
    moved,
    scrub_finds,
    tried,
    walked,
)
from triaxis.verif.mesh.items import Integers, ObservedRun, Summary
from triaxis.verif.mesh.sampling import row_of
from triaxis.verif.testbench.failures import DESCRIBED, Blame, ends_at_first, report_failure

_NO_MESH = np.empty((0, 3, 3), np.int64)
# Pairs of a run that the golden model judges at most, near ones and others each.
_JUDGED = 4


@dataclass(frozen=True)
class SceneFailure:
    """One thing that went wrong, and the run it went wrong in: its number, and the clock of its summary.

    ``pairs``: those of the complete runs before it.
    """

    message: str
    run: ObservedRun
    number: int
    clock: int
    pairs: int
    blame: Blame = Blame.DESIGN

    def record(self) -> dict[str, Any]:
        """Return it as it stands among the counts of a test's run."""
        kept = ("blame", "message", "number", "clock", "pairs")
        return {name: getattr(self, name) for name in kept}


class SceneChecker:
    """Checks runs, in order; calls ``on_checked`` with the row of each for coverage.

    ``judged_one_in``: of so many runs one has pairs judged by the golden model.
    """

    def __init__(
        self,
        configuration: MeshConfiguration,
        judged_one_in: int = 1,
        seed: int = 0,
        on_checked: Callable[[MeshRow], None] = lambda _: None,
    ) -> None:
        """Start with nothing checked."""
        self.configuration = configuration
        self.runs = self.complete_runs = self.pairs = self.skipped = self.tested = self.near = 0
        self.judged = self.failed = 0
        self.failures: list[SceneFailure] = []
        self.judged_one_in = judged_one_in
        self.rng = np.random.default_rng([seed, *b"scenes"])
        self._on_checked = on_checked
        # Whether the engine has met a fault that was not acknowledged.
        self._faulted = False
        # What the run before tried, where that is found by scrubbing: time enough has been for it.
        self._scrubbed = UNKNOWN
        self._known: tuple[Integers, Integers, tuple[int, ...], tuple[SceneAnswer, ...]] = (
            _NO_MESH, _NO_MESH, (), (),
        )  # fmt: skip

    def check(self, run: ObservedRun, summary: Summary) -> None:
        """Check a run that has ended."""
        due = expected_status(run, self.configuration)
        answers = self._answers(run) if due == Status.COMPLETE else ()
        # What is skipped is further than the widest zone, and what is near within the margin.
        answer = replace(answers[-1], near=answers[0].near) if answers else None
        outcome, before = tried(run, answer, self.configuration), self._before(run)
        if before is Before.STAYS:
            outcome = replace(outcome, fails=True, may_fail=True)
        scrubbed, self._scrubbed = self._scrubbed, UNKNOWN
        if scrub_finds(run):
            self._scrubbed = run.request.tries[1]
        self._faulted = summary.status == Status.FAULT
        wrong = [(message, Blame.DESIGN) for message in self._problems(run, summary, due, outcome)]
        wrong += [(message, Blame.DESIGN) for message in zone_problems(run, summary, answers)]
        if answers:
            wrong += [(message, Blame.JUDGES) for message in self._judge(run, answers)]
        for message, blame in wrong:
            self.failed += 1
            report_failure(message, self.pairs)
            if len(self.failures) < DESCRIBED:
                place = self.runs + 1, summary.clock, self.pairs
                self.failures.append(SceneFailure(message, run, *place, blame))
        self.runs += 1
        if summary.status == Status.COMPLETE and answer is not None:
            self.complete_runs += 1
            self.pairs += answer.near.size
            self.skipped += answer.near.size - answer.tested
            self.tested += answer.tested
            self.near += summary.near
        # What else is not a status has no place in the coverage model.
        if summary.status in list(Status) and not ends_at_first():
            self._on_checked(row_of(self.configuration, run, summary, answer, before, scrubbed))

    def _before(self, run: ObservedRun) -> Before:
        """Return what became of a fault of the run before."""
        if not self._faulted and self._scrubbed == UNKNOWN:
            return Before.NO_FAULT
        if run.after_reset:
            return Before.RESET
        return Before.ACKNOWLEDGED if run.accepted.acknowledged else Before.STAYS

    def _answers(self, run: ObservedRun) -> tuple[SceneAnswer, ...]:
        """Return the exact answer for each zone; those of the run before where it was asked the same."""
        a, margins = moved(run.a, run.request.translation), run.request.margins
        known_a, known_b, known_margins, answers = self._known
        if margins != known_margins or not _same(a, known_a) or not _same(run.b, known_b):
            group = self.configuration.group
            found = {margin: scene_answer(a, run.b, margin, group) for margin in set(margins)}
            answers = tuple(found[margin] for margin in margins)
            self._known = a, run.b, margins, answers
        return answers

    def _problems(self, run: ObservedRun, summary: Summary, due: Status, outcome: Tried) -> list[str]:
        answer = outcome.answer
        found = [*self._status_problems(run, summary, due, outcome), *self._pin_problems(run, summary)]
        if answer is None:
            ran = (len(run.near_pairs), len(run.core_pairs), summary.tested, summary.near)
            if any(ran):
                found.append(f"near pairs, pairs in the core, tested, near: {ran}: nothing was to be run")
            return found
        if summary.status == Status.FAULT and not run.aborts:
            # It went on to its end.
            stops = run.request.mode == Mode.FIRST and answer.near.any()
            summary = replace(summary, status=Status.FIRST if stops else Status.COMPLETE)
        found += self._stream_problems(run, summary, answer)
        if summary.status == Status.COMPLETE:
            found += self._account_problems(summary, answer)
        else:
            found += self._partial_problems(run, summary, answer)
        return found

    def _status_problems(self, run: ObservedRun, summary: Summary, due: Status, outcome: Tried) -> list[str]:
        """Return what is wrong with how the run ended."""
        answer = outcome.answer
        stops = due == Status.COMPLETE and run.request.mode == Mode.FIRST and answer and answer.near.any()
        ends = Status.FIRST if stops else due
        # Before the summary is offered an abort ends the run, unless it has stopped at a near pair.
        aborted = {Status.ABORTED, Status.FIRST} if stops else {Status.ABORTED}
        last = summary.last_abort
        allowed = aborted if any(at <= last for at in run.aborts) else {ends}
        if outcome.may_fail:
            allowed = {Status.FAULT} if outcome.fails else allowed | {Status.FAULT}
        if summary.status in allowed:
            return []
        names = " or ".join(sorted(status.name for status in allowed))
        return [f"status {summary.status}, {names} is due, aborts at {run.aborts}"]

    def _pin_problems(self, run: ObservedRun, summary: Summary) -> list[str]:
        found: list[str] = []
        held = (len(run.a), len(run.b))
        if summary.held != held:
            found.append(f"{summary.held} triangles held, {held} were given")
        signatures = tuple(expected_signature(mesh, self.configuration.width) for mesh in (run.a, run.b))
        if summary.signatures != signatures:
            found.append(f"signatures {summary.signatures}, {signatures} are due")
        overfull = run.overfull[0] | run.overfull[1] << 1
        if summary.overfull != overfull:
            found.append(f"overfull {summary.overfull}, {overfull} is due")
        fault = int(summary.status == Status.FAULT)
        if summary.fault != fault:
            found.append(f"fault {summary.fault}, {fault} is due with this status")
        if summary.cycles != min(summary.offered_after, self.configuration.max_cycles):
            found.append(f"{summary.cycles} cycles, {summary.offered_after} were seen")
        return found

    def _stream_problems(self, run: ObservedRun, summary: Summary, answer: SceneAnswer) -> list[str]:
        """Compare both streams of pairs with the scan: they are what it gives, up to where the run ended."""
        found: list[str] = []
        reached, due = run.core_pairs, answer.to_be_tested
        if not begins(due, reached):
            found.append(f"pairs in the core: {difference(reached, due)}")
        # Whatever the answer to it: a pair that is left out needs a proof of its own.
        if summary.status == Status.COMPLETE:
            left = np.ones(answer.near.shape, np.bool_)
            there = reached[((reached >= 0) & (reached < answer.near.shape)).all(1)]
            left[there[:, 0], there[:, 1]] = False
            unproven = left & ~answer.boxes_apart
            if unproven.any():
                found.append(f"{unproven.sum()} pairs skipped without a proof, first {first_of(unproven)}")
        near, near_due = run.near_pairs, answer.near_pairs
        if run.request.zoned:
            near_due = in_order_of(near, near_due)
            found += self._asking_problems(run)
        if run.request.mode == Mode.COUNT:
            near_due = near_due[:0]
        if run.request.mode == Mode.FIRST:
            near_due = near_due[:1]
        if not begins(near_due, near):
            found.append(f"near pairs: {difference(near, near_due)}")
        if summary.status in (Status.COMPLETE, Status.FIRST) and len(near) != len(near_due):
            found.append(f"{len(near)} near pairs sent, {len(near_due)} are due")
        return found

    def _asking_problems(self, run: ObservedRun) -> list[str]:
        """Compare how often, and in which order, the core was asked about pairs with the zones of a run."""
        found: list[str] = []
        times = run.times_asked
        zones = len(set(run.request.margins))
        if times.size and times.max() > zones:
            found.append(f"a pair was asked about {times.max()} times, in {zones} zones")
        last = {pair: number for number, pair in enumerate(map(tuple, run.asked.tolist()))}
        verdicts = [last.get(pair, -1) for pair in map(tuple, run.near_pairs.tolist())]
        if sorted(verdicts) != verdicts:
            found.append("near pairs came in another order than the core was asked about them last")
        return found

    def _account_problems(self, summary: Summary, answer: SceneAnswer) -> list[str]:
        """Compare all counters of a complete run with what follows from the definition."""
        due = {
            "group_pairs_skipped": answer.group_pairs_skipped,
            "group_pairs_opened": answer.group_pairs_opened,
            "pairs_skipped": answer.pairs_skipped,
            "tested": answer.tested,
            "near": int(answer.near.sum()),
        }
        return [
            f"{name} {getattr(summary, name)}, {count} is due"
            for name, count in due.items()
            if getattr(summary, name) != count
        ]

    def _partial_problems(self, run: ObservedRun, summary: Summary, answer: SceneAnswer) -> list[str]:
        """Compare the counters of a run that ended early with its part of the scan.

        The walk is ahead of the core, and the core of its verdicts, by no more than is in flight.
        """
        reached, in_flight = len(run.core_pairs), self.configuration.most_in_flight
        due = answer.to_be_tested
        near = answer.near[due[:, 0], due[:, 1]]
        least = {**walked(answer, min(reached, len(due))), "tested": max(0, reached - in_flight)}
        most = {name: getattr(answer, name) for name in least} | {"tested": reached}
        if run.request.zoned:
            # The verdicts are not in the order of the scan.
            most["near"] = min(int(near[:reached].sum()), summary.tested)
            least["near"] = (
                max(0, int(near[:reached].sum()) - in_flight) if run.request.mode != Mode.FIRST else 0
            )
        else:
            least["near"] = most["near"] = int(near[: summary.tested].sum())
        found = [
            f"{name} {getattr(summary, name)}, {low} to {most[name]} are due where {reached} reached the core"
            for name, low in least.items()
            if not low <= getattr(summary, name) <= most[name]
        ]
        if run.request.mode != Mode.COUNT and summary.near != len(run.near_pairs):
            found.append(f"near {summary.near}, {len(run.near_pairs)} were sent")
        last = near[max(0, summary.tested - 1) : summary.tested]
        if summary.status == Status.FIRST and not (summary.near if run.request.zoned else last.any()):
            found.append(f"stopped after {summary.tested} pairs, where none is near")
        return found

    def _judge(self, run: ObservedRun, answers: tuple[SceneAnswer, ...]) -> list[str]:
        """Let the golden model judge some pairs in one of the zones: near ones, tested ones, skipped ones."""
        zone = int(self.rng.integers(len(answers))) if run.request.zoned else 0
        answer, margin = answers[zone], run.request.margins[zone]
        if not answer.near.size or self.rng.integers(self.judged_one_in):
            return []
        chosen: list[Integers] = []
        for kind in (answer.near, ~answer.near & ~answer.boxes_apart, answer.boxes_apart):
            pairs = np.argwhere(kind)
            chosen.append(pairs[self.rng.integers(0, len(pairs), min(_JUDGED, len(pairs)))])
        i, j = np.concatenate(chosen).T
        pairs = np.stack([moved(run.a, run.request.translation)[i], run.b[j]], 1)
        self.judged += len(pairs)
        try:
            near = judge_pairs(pairs, np.full(len(pairs), margin))["near"]
        except CertificateError as error:
            return [f"golden model: {error}"]
        wrong = np.flatnonzero(near != answer.near[i, j])
        return [f"bulk checker and golden model disagree on pair {(int(i[n]), int(j[n]))}" for n in wrong[:1]]


def zone_problems(run: ObservedRun, summary: Summary, answers: tuple[SceneAnswer, ...]) -> list[str]:
    """Compare the zones in which something was found, or that are no wider than the one within, with answers.

    A run that ends early has found some of it, one that was refused nothing, one with a fault anything.
    """
    if summary.status == Status.FAULT:
        return []
    least = due = run.request.not_wider
    for bit, answer in enumerate(answers[1:]):
        due |= bool(answer.near.any()) << bit
    if summary.near:
        least = due
    elif summary.zones & ~least & 1:
        # What is in a zone is in all around it.
        least |= 2
    if summary.status == Status.COMPLETE:
        least = due
    if least & ~summary.zones or summary.zones & ~due:
        return [f"zones {summary.zones}, {due} are due, of {summary.near} near pairs"]
    return []


def _same(one: Integers, other: Integers) -> bool:
    return one.shape == other.shape and bool((one == other).all())
