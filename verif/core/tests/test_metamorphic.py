"""Variants of pairs are answered alike by the core, and a core that answers otherwise is reported."""

import numpy as np
import pytest

from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import RtlEngine
from triaxis.sim.result import COPLANAR, DEGENERATE_A, DEGENERATE_B, NEAR
from triaxis.verif.core.metamorphic import (
    GROUPS,
    MOVES,
    ORDERS,
    SYMMETRIES,
    check_variants,
    gated_flags_are_zero,
    groups_agree,
)
from triaxis.verif.core.stimulus.families import mixed_pairs, random_margins

GATED = Configuration(16, 0)
UNGATED = Configuration(16, 16, gating=False)


def base(rng, count, configuration):
    pairs = mixed_pairs(rng, count, configuration.width)
    return pairs.astype(np.int32), random_margins(rng, pairs, configuration.max_margin)


def runner(configuration, spoil=lambda words: words):
    """Return the core as a function, its result words spoilt."""
    engine = RtlEngine(configuration)
    return lambda pairs, margins: spoil(engine.words(pairs, margins)[0])


@pytest.mark.parametrize("configuration", [GATED, UNGATED], ids=lambda c: c.name)
def test_the_core_answers_variants_alike(rng, configuration):
    pairs, margins = base(rng, 2400, configuration)
    words = []

    def run(variants, variant_margins):
        words.append(runner(configuration)(variants, variant_margins))
        return words[-1]

    report = check_variants(run, pairs, margins, configuration, rng)
    assert not report.failed, "\n".join(map(str, report.failures))
    assert report.compared == {group.name: 2400 * group.size for group in GROUPS}
    assert report.variants == 2400 * (72 + 48 + 8)
    every = np.concatenate(words)
    # It would be no check if they were all of one sort.
    for flag in (NEAR, COPLANAR, DEGENERATE_A, DEGENERATE_B):
        assert (every & flag != 0).any()
        assert (every & flag == 0).any()
    assert len(np.unique(every[every & NEAR == 0] >> 8)) > 20


@pytest.mark.parametrize("bit", range(8))
def test_a_flipped_bit_is_reported(rng, bit):
    pairs, margins = base(rng, 40, UNGATED)
    at = int(rng.integers(1, 72)) + 72 * int(rng.integers(40))

    right = []

    def spoil(words):
        right.append(int(words[at]))
        words[at] ^= np.uint16(1 << bit)
        return words

    report = check_variants(runner(UNGATED, spoil), pairs, margins, UNGATED, rng, [ORDERS])
    assert report.failed == 1
    failure = report.failures[0]
    assert (failure.base, failure.variant) == divmod(at, 72)
    assert failure.variant_word == right[0] ^ (1 << bit)
    assert (failure.base_pair == pairs[failure.base]).all()
    assert sorted(failure.variant_pair.reshape(6, 3).tolist()) == sorted(
        failure.base_pair.reshape(6, 3).tolist()
    )
    assert failure.margin == margins[failure.base]
    assert f"pair {failure.base}" in str(failure)


def test_a_wrong_base_is_reported_and_descriptions_are_few(rng):
    pairs, margins = base(rng, 3, GATED)

    def spoil(words):
        words[0] ^= np.uint16(NEAR)
        return words

    for group in GROUPS:
        report = check_variants(runner(GATED, spoil), pairs, margins, GATED, rng, [group])
        assert report.failed >= group.size - 1
        assert 0 < len(report.failures) <= 10


def words_of(group, word, other, at):
    """Return words of a pair and its variants, all alike but one."""
    words = np.full(group.size, word, np.uint16)
    words[at] = other
    return words


def claim(axis, flags=0):
    return axis << 8 | flags


@pytest.mark.parametrize(
    ("group", "word", "other", "good"),
    [
        # Orders renumber edges and exchange A and B; the kind of axis stays.
        (ORDERS, claim(5), claim(13), True),
        (ORDERS, claim(14), claim(31), True),
        (ORDERS, claim(3), claim(4), True),
        (ORDERS, claim(4), claim(5), False),
        (ORDERS, claim(0), claim(1), False),
        # Symmetries exchange coordinates.
        (SYMMETRIES, claim(0), claim(2), True),
        (SYMMETRIES, claim(14), claim(16), True),
        (SYMMETRIES, claim(14), claim(17), False),
        (SYMMETRIES, claim(3), claim(4), False),
        (SYMMETRIES, claim(5), claim(6), False),
        (SYMMETRIES, claim(2), claim(3), False),
        # Translations leave all as it is.
        (MOVES, claim(0), claim(1), False),
        (MOVES, claim(30), claim(31), False),
        # A near pair claims no axis.
        (ORDERS, NEAR, NEAR | claim(1), False),
        (SYMMETRIES, NEAR, claim(0), False),
        (MOVES, NEAR, NEAR | COPLANAR, False),
        (ORDERS, claim(7), claim(7, 1 << 4), False),
    ],
)
def test_what_a_group_lets_change(group, word, other, good):
    at = group.size // 4
    agree = groups_agree(words_of(group, word, other, at), group)
    assert agree.shape == (1, group.size)
    assert agree[0, at] == good
    assert np.delete(agree[0], at).all()


def test_degenerate_flags_follow_a_and_b():
    word = claim(6, DEGENERATE_A | COPLANAR)
    words = np.full(72, word, np.uint16)
    words[ORDERS.swapped] = claim(6, DEGENERATE_B | COPLANAR)
    assert groups_agree(words, ORDERS).all()
    assert (groups_agree(np.full(72, word, np.uint16), ORDERS) == ~ORDERS.swapped).all()
    both = np.full(72, claim(6, DEGENERATE_A | DEGENERATE_B), np.uint16)
    assert groups_agree(both, ORDERS).all()


def test_gated_flags():
    words = np.array([claim(2), claim(2, COPLANAR), claim(3, COPLANAR), NEAR | DEGENERATE_A], np.uint16)
    assert gated_flags_are_zero(words).tolist() == [True, False, True, True]


def test_flags_of_gated_pairs_are_looked_at(rng):
    pairs, margins = base(rng, 20, GATED)

    def spoil(words):
        return words | np.where((words & NEAR == 0) & (words >> 8 < 3), COPLANAR, 0).astype(np.uint16)

    report = check_variants(runner(GATED, spoil), pairs, margins, GATED, rng, [MOVES])
    assert report.failed
    assert not check_variants(runner(GATED), pairs, margins, GATED, rng, [MOVES]).failed
