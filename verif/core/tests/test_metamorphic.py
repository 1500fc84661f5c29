"""Variants of pairs are answered alike by the core, and an answer that is not is seen."""

import numpy as np
import pytest

from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import RtlEngine
from triaxis.sim.result import COPLANAR, DEGENERATE_A, DEGENERATE_B, NEAR
from triaxis.verif.core.metamorphic import GROUPS, MOVES, ORDERS, SYMMETRIES, answered_alike
from triaxis.verif.core.stimulus.families import mixed


@pytest.mark.simulator
@pytest.mark.parametrize(
    "configuration", [Configuration(16, 0), Configuration(8, 8, gating=False)], ids=lambda c: c.name
)
def test_the_core_answers_variants_alike(rng, configuration):
    engine = RtlEngine(configuration)
    base = mixed(rng, 600, configuration.width, configuration.max_margin)
    for group in GROUPS:
        variants = group.make(rng, base.pairs, configuration.width)
        words = engine.words(variants, base.margins.repeat(group.size))[0]
        assert answered_alike(words, group, configuration.gating).all()
        # It would be no check if they were all of one sort.
        for flag in (NEAR, COPLANAR, DEGENERATE_A, DEGENERATE_B):
            assert 0 < (words & flag != 0).mean() < 1
        for flag in (NEAR, COPLANAR, DEGENERATE_A, DEGENERATE_B):
            wrong = words.copy()
            wrong[rng.integers(len(words))] ^= np.uint16(flag)
            assert not answered_alike(wrong, group, configuration.gating).all()


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
        (SYMMETRIES, claim(2), claim(3), False),
        # Translations leave all as it is.
        (MOVES, claim(30), claim(31), False),
        # A near pair claims no axis; a pair that its boxes decide has no flags, where there is gating.
        (ORDERS, NEAR, NEAR | claim(1), False),
        (MOVES, NEAR, NEAR | COPLANAR, False),
        (ORDERS, claim(7), claim(7, 1 << 4), False),
    ],
)
def test_what_a_group_lets_change(group, word, other, good):
    words, at = np.full(group.size, word, np.uint16), group.size // 4
    words[at] = other
    agree = answered_alike(words, group, gating=False)
    assert agree.shape == (1, group.size)
    assert agree[0, at] == good
    assert np.delete(agree[0], at).all()


def test_flags_follow_a_and_b_and_gated_pairs_have_none():
    words = np.full(72, claim(6, DEGENERATE_A | COPLANAR), np.uint16)
    assert (answered_alike(words, ORDERS, False) == ~ORDERS.swapped).all()
    words[ORDERS.swapped] = claim(6, DEGENERATE_B | COPLANAR)
    assert answered_alike(words, ORDERS, False).all()
    for word, good in ((claim(2), True), (claim(2, COPLANAR), False), (claim(3, COPLANAR), True)):
        words = np.full(MOVES.size, word, np.uint16)
        assert answered_alike(words, MOVES, True).all() == good
        assert answered_alike(words, MOVES, False).all()
