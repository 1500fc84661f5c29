"""What pairs and answers hit in the model of the core."""

import numpy as np

from triaxis.coverage.core_coverage import CoreCoverage
from triaxis.coverage.core_sample import CoreSample, CoreView
from triaxis.coverage.report import report
from triaxis.coverage.tests.core_samples import true_words
from triaxis.golden.bulk import bulk_facts
from triaxis.sim.configuration import Configuration

TRIANGLE = [[0, 0, 0], [6, 0, 1], [0, 6, 1]]


def hit_bins(coverage, name):
    item = next(i for i in coverage.model.items if i.name == name)
    hits = coverage.counts.hits[name].tolist()
    return {b.name: n for b, n in zip(item.bins, hits, strict=True) if n}


WITH_MARGINS = Configuration(16, 16)


def sampled(pairs, margins, words=None, build=WITH_MARGINS):
    """Coverage of pairs, answered truly unless words are given, without waits, one each clock."""
    facts = bulk_facts(np.array(pairs), np.array(margins))
    waits = np.zeros(len(facts), np.uint8)
    coverage = CoreCoverage(build)
    answers = true_words(facts, build) if words is None else np.array(words, np.uint16)
    none = np.zeros(len(answers), np.uint8)
    clocks = np.arange(len(facts))
    coverage.sample(CoreSample(facts, np.array(margins), answers, waits, waits, clocks, none))
    return coverage


def test_a_point_above_a_triangle_is_decided_by_its_normal():
    point = [[1, 1, 9]] * 3
    tilted = [[0, 0, 0], [9, 0, 9], [0, 9, 9]]
    coverage = sampled([[tilted, point], [point, tilted]], [3, 0])
    assert hit_bins(coverage, "claim") == {"near": 1, "04 normal B": 1}
    # z > x + y by 7, three times the margin of 3 is 9; without margin the normal alone separates.
    assert list(hit_bins(coverage, "sole_axis")) == ["04 normal B / B below A / A point / B triangle / m = 0"]
    assert hit_bins(coverage, "relation") == {
        "clear / A point / B triangle / m = 0": 1,
        "penetrating / A triangle / B point / m > 0": 1,
    }
    assert hit_bins(coverage, "succession") == {"after near / clear by other axis": 1}


def test_pairs_in_a_row_follow_one_another_clock_by_clock():
    pair = [[[1, 1, 9]] * 3] * 2
    margins = np.zeros(12, np.int64)
    facts = bulk_facts(np.array([pair] * 12), margins)
    waits_in, waits_out = np.zeros((2, 12), np.uint8)
    # Three, of which the last has waited; then seven; then two, a clock later.
    waits_in[0], waits_out[2] = 1, 3
    clocks = np.array([0, 1, 5, *range(6, 13), 14, 15])
    words, none = true_words(facts, WITH_MARGINS), np.zeros(12, np.uint8)
    view = CoreView(WITH_MARGINS, CoreSample(facts, margins, words, waits_in, waits_out, clocks, none))
    assert view.runs.tolist() == [1, 7, 2]


def test_a_core_without_the_last_axes_sees_only_what_it_can():
    # Two triangles in the plane z = 0 whose boxes overlap: only edges seen along z separate them.
    pair = [[[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[9, 9, 0], [9, 2, 0], [3, 9, 0]]]
    full, less = (sampled([pair], [0], build=Configuration(edge_box=box)) for box in (True, False))
    assert list(hit_bins(full, "claim")) == ["19 A edge 1 x z"]
    assert list(hit_bins(less, "claim")) == ["near"]
    assert list(hit_bins(less, "blind")) == ["near, though a missing axis separates / coplanar"]


def test_wrong_answers_hit_illegal_bins():
    clear = [TRIANGLE, [[0, 0, 40], [6, 0, 41], [0, 6, 41]]]
    near = [TRIANGLE, TRIANGLE]
    for pair, word, bin_name in (
        (clear, 0x0001, "near, wrongly"),
        (near, 0x0000, "clear, wrongly"),
        (near, 0x0200, "clear, wrongly"),
        (clear, 0x0300, "clear, by another axis or with spare bits"),
        (clear, 0x0301, "near, wrongly"),
        (near, 0x0801, "near, with spare bits or an axis"),
    ):
        coverage = sampled([pair], [0], [word])
        found = report(coverage.model, coverage.counts)
        assert [i.bin for i in found.items[0].illegal_hits] == [bin_name], hex(word)
    right = sampled([clear, near], [0, 0], [0x0200, 0x0003])
    assert hit_bins(right, "answer") == {"clear, by the lowest axis": 1, "near": 1}
    gated = sampled([clear], [0], [0x0204])
    flags = next(i for i in report(gated.model, gated.counts).items if i.name == "flags")
    assert [i.bin for i in flags.illegal_hits] == ["clear by box / A degenerate"]
