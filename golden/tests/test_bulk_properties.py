"""What must hold between the facts of a pair and of the same pair seen otherwise."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.facts import Facts
from triaxis.golden.tests.test_bulk import NAMES, assert_equal

REPEATABLE = settings(deadline=None, derandomize=True, database=None)

# Coordinates at all scales; small ones give coincidences.
COORDINATES = st.one_of(
    st.integers(-3, 3), st.integers(-200, 200), st.integers(-(1 << 15), (1 << 15) - 1),
    st.integers(-(1 << 31), (1 << 31) - 1),
)  # fmt: skip
PAIRS = st.lists(COORDINATES, min_size=18, max_size=18).map(lambda x: np.array(x).reshape(1, 2, 3, 3))
GRIDS = st.lists(st.integers(-3, 3), min_size=18, max_size=18).map(lambda x: np.array(x).reshape(1, 2, 3, 3))
MARGINS = st.one_of(st.just(0), st.integers(0, 3), st.integers(0, (1 << 32) - 1))

# Where axis n of the pair goes when A and B change places; the vectors of edge x edge change sign.
SWAPPED = np.array(
    [0, 1, 2, 4, 3, *(5 + 3 * j + i for i in range(3) for j in range(3)), *range(23, 32), *range(14, 23)]
)
TURNED = np.uint32(0x1FF << 5)


def renumbered(mask):
    bits = (mask[:, None] >> np.arange(32, dtype=np.uint32)) & np.uint32(1)
    return (bits << SWAPPED.astype(np.uint32)).sum(1, dtype=np.uint32)


def swapped(facts):
    """Return the facts of the pair with A and B exchanged."""
    changed = {name: getattr(facts, name) for name in NAMES}
    for name in ("level", "clear_step", "near_step", "flat"):
        changed[name] = renumbered(changed[name])
    for x, y in (("above", "below"), ("upper", "lower")):
        one, other = renumbered(getattr(facts, x)), renumbered(getattr(facts, y))
        changed[x], changed[y] = (one & TURNED) | (other & ~TURNED), (other & TURNED) | (one & ~TURNED)
    for x, y in (
        ("support_a", "support_b"),
        ("rank_a", "rank_b"),
        ("order_a", "order_b"),
        ("a_in_b", "b_in_a"),
    ):
        changed[x], changed[y] = changed[y], changed[x]
    return Facts(**changed)


@REPEATABLE
@given(st.one_of(PAIRS, GRIDS), MARGINS)
def test_exchanging_a_and_b(pairs, margin):
    assert_equal(bulk_facts(pairs[:, ::-1], margin), swapped(bulk_facts(pairs, margin)))


@REPEATABLE
@given(GRIDS, st.integers(0, 3), st.lists(st.integers(-(1 << 30), 1 << 30), min_size=3, max_size=3))
def test_translation_changes_the_limits_alone(pairs, margin, by):
    here, there = bulk_facts(pairs, margin), bulk_facts(pairs + np.array(by), margin)
    for name in NAMES:
        if name not in ("low", "high"):
            assert (getattr(here, name) == getattr(there, name)).all(), name


@REPEATABLE
@given(GRIDS, st.integers(0, 3), st.integers(1, 1 << 28))
def test_scaling_keeps_verdicts(pairs, margin, scale):
    small, large = bulk_facts(pairs, margin), bulk_facts(pairs * scale, margin * scale)
    for name in ("above", "below", "level", "flat", "support_a", "support_b", "a_in_b", "b_in_a", "coplanar"):
        assert (getattr(small, name) == getattr(large, name)).all(), name


@REPEATABLE
@given(st.one_of(PAIRS, GRIDS), MARGINS, st.permutations(range(3)), st.permutations(range(3)))
def test_vertex_orders_keep_what_has_no_order(pairs, margin, order_a, order_b):
    other = np.stack([pairs[:, 0][:, order_a], pairs[:, 1][:, order_b]], 1)
    facts, turned = bulk_facts(pairs, margin), bulk_facts(other, margin)
    for name in ("near", "rank_a", "rank_b", "coplanar", "a_in_b", "b_in_a", "low", "high"):
        assert (getattr(facts, name) == getattr(turned, name)).all(), name
    for name in ("level", "clear_step", "near_step", "flat"):
        masks = zip(getattr(facts, name), getattr(turned, name), strict=True)
        assert all(int(x).bit_count() == int(y).bit_count() for x, y in masks), name
    assert facts.support_a[0] == sum(1 << order_a[v] for v in range(3) if turned.support_a[0] >> v & 1)


@REPEATABLE
@given(st.one_of(PAIRS, GRIDS), st.integers(0, (1 << 32) - 2))
def test_near_stays_near_with_more_margin(pairs, margin):
    facts, more = bulk_facts(pairs, margin), bulk_facts(pairs, margin + 1)
    assert (more.separating & ~facts.separating == 0).all()
    assert (more.level & ~facts.separating == 0).all()
