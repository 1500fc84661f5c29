"""The arrays of a view, against the same said of one pair at a time in plain Python."""

from itertools import groupby

import numpy as np
import pytest

from triaxis.coverage.core_sample import Build, CoreSample, CoreView, Decision, Relation, classes
from triaxis.coverage.tests.core_pairs import (
    grid_pairs,
    margins_for,
    moved,
    pointing_pairs,
    related_pairs,
    samples,
)
from triaxis.golden.errors import InputError

BUILDS = (Build(8, 8, True, True), Build(16, 0, False, True), Build(32, 32, True, False))


@pytest.fixture(params=BUILDS, ids=lambda build: build.name)
def view(request, rng):
    build = request.param
    pairs = np.concatenate(
        [
            grid_pairs(rng, 1500, 3),
            grid_pairs(rng, 1500, 12),
            related_pairs(rng, 3000, 2),
            pointing_pairs(rng, 500),
            moved(rng, related_pairs(rng, 1500, 3), build.width, to_limits=True),
        ]
    )
    pairs = rng.permutation(pairs)
    (sample,) = samples(rng, build, pairs, margins_for(rng, build, pairs))
    waits = rng.integers(0, 2, (2, len(pairs)), np.uint8)
    return CoreView(build, CoreSample(sample.facts, sample.margins, sample.words, *waits))


def bits(mask):
    return {n for n in range(32) if int(mask) >> n & 1}


def of_build(view, mask):
    return {n for n in bits(mask) if view.build.edge_box or n < 14}


def each(view):
    """Number, facts of one pair, and the axes that separate it in this build."""
    for i in range(len(view.facts)):
        one = view.facts[i : i + 1]
        yield i, one, of_build(view, one.separating[0])


def test_axes_that_decide(view):
    none, kinds = view.build.axes, set()
    for i, one, separating in each(view):
        assert view.near[i] == (not separating)
        boxed = bool(separating & {0, 1, 2})
        decision = Decision.NEAR if not separating else Decision.BOX if boxed else Decision.OTHER
        kinds.add(decision)
        assert view.decision[i] == decision
        assert view.lowest[i] == min(separating, default=0)
        sole = separating if len(separating) == 1 else set()
        assert view.sole[i] == min(sole, default=none)
        assert view.sole_step[i] == min(sole & bits(one.clear_step[0]), default=none)
        if sole:
            assert view.side[i] == (min(sole) in bits(one.below[0]))
    assert kinds == set(Decision)


def test_masks_of_near_pairs(view):
    level, near_step = view.near_only(view.facts.level), view.near_only(view.facts.near_step)
    for i, one, separating in each(view):
        for masks, mask in ((level, one.level), (near_step, one.near_step)):
            assert bits(masks[i]) == (set() if separating else of_build(view, mask[0]))
        flat = set() if separating or view.sample.margins[i] else of_build(view, one.flat[0])
        assert bits(view.flat_at_zero[i]) == flat


def relation(one):
    if one.separating[0]:
        return Relation.CLEAR
    if one.level[0]:
        return Relation.TOUCHING
    if one.a_in_b[0] and one.b_in_a[0]:
        return Relation.IDENTICAL
    if one.a_in_b[0]:
        return Relation.A_IN_B
    if one.b_in_a[0]:
        return Relation.B_IN_A
    return Relation.COPLANAR if one.coplanar[0] else Relation.PENETRATING


def test_how_the_triangles_lie(view):
    supports_a, supports_b = view.support(view.facts.support_a), view.support(view.facts.support_b)
    features_a, features_b = view.features(view.facts.support_a), view.features(view.facts.support_b)
    found = set()
    for i, one, _ in each(view):
        expected = relation(one)
        found.add(expected)
        assert view.relation[i] == expected
        touch = expected == Relation.TOUCHING and one.rank_a[0] == one.rank_b[0] == 2
        for support, codes, features in (
            (one.support_a[0], supports_a, features_a),
            (one.support_b[0], supports_b, features_b),
        ):
            assert codes[i] == (int(support) - 1 if touch else 7)
            assert features[i] == (int(support).bit_count() - 1 if touch else 3)
    assert found == set(Relation)


def test_sizes_and_margins(view):
    width, found = view.build.width, set()
    for i, one, _ in each(view):
        low, high = int(one.low[0]), int(one.high[0])
        largest = max(-low, high)
        size = 0 if largest < 8 else 1 if largest < 2 ** (width // 2) else 2
        if low == -(2 ** (width - 1)) and high == 2 ** (width - 1) - 1:
            size = 3
        found.add(size)
        assert view.size[i] == size
        assert view.margin_positive[i] == (view.sample.margins[i] > 0)
    assert found == {0, 1, 2, 3}


def test_what_is_missed_by_missing_axes(view):
    for i, one, separating in each(view):
        assert view.blind[i] == (not separating and bool(one.separating[0]))
    assert view.blind.any() != view.build.edge_box


def test_runs_and_successions(view):
    waited = [bool(x or y) for x, y in zip(view.sample.waits_in, view.sample.waits_out, strict=True)]
    assert view.runs.tolist() == [len(list(run)) for wait, run in groupby(waited) if not wait]
    assert view.previous.tolist() == [3, *view.decision[:-1].tolist()]


def test_answers_are_read_from_the_word(view):
    for i, _, separating in each(view):
        assert view.answered_near[i] == (not separating)
        assert view.claim[i] == (1 + min(separating) if separating else 0)
        assert view.answer[i] == (2 if separating else 3)


def test_classes_are_counted_from_their_starts():
    values = np.array([0, 1, 2, 7, 8, 200, 255], np.uint8)
    assert classes(values, 1, 2, 8).tolist() == [0, 1, 2, 2, 3, 3, 3]
    assert classes(np.array([0, 2**32 - 1], np.uint32), 1, 2**30).tolist() == [0, 2]


def test_empty_samples_are_samples(rng):
    build = Build(8, 8, True, True)
    (sample,) = samples(rng, build, *(a[:1] for a in (grid_pairs(rng, 1, 3), np.zeros(1, np.int64))))
    empty = CoreSample(
        sample.facts[:0], sample.margins[:0], sample.words[:0], sample.waits_in[:0], sample.waits_out[:0]
    )
    view = CoreView(build, empty)
    assert len(view.sole) == len(view.previous) == len(view.runs) == 0


def test_arrays_of_different_lengths_are_refused(rng):
    (sample,) = samples(rng, BUILDS[0], grid_pairs(rng, 9, 3), np.zeros(9, np.int64))
    with pytest.raises(ValueError, match="different lengths"):
        CoreSample(sample.facts, sample.margins[:8], sample.words, sample.waits_in, sample.waits_out)


def test_builds_that_cannot_be_are_refused():
    for wrong in ((7, 0, True, True), (33, 0, True, True), (8, 9, True, True), (8, 1, False, True)):
        with pytest.raises(InputError):
            Build(*wrong)
