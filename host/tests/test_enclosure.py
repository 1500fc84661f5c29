"""Inside and outside, against boxes, against rays in other directions, and where numbers are large."""

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_verdicts
from triaxis.host import scenes
from triaxis.host.enclosure import State, enclosure, inside
from triaxis.host.shells import shells_of, solid_of


def box(low, high, inverted=False):
    """Return a box of edges along the axes, its facets counterclockwise from outside unless inverted."""
    made = np.array(low) + scenes.box((0, 0, 0), (1, 1, 1)).astype(np.int64) * (
        np.array(high) - np.array(low)
    )
    return made[:, ::-1] if inverted else made


def ring(scale: float = 1):
    profile = [(5.0, 0.0), (8.0, 0.0), (8.0, 3.0), (5.0, 3.0), (5.0, 0.0)]
    return np.rint(scenes.revolved(profile) * scale).astype(np.int64)


STOCK = box(0, 100)
# With the other diagonals: squares are of two facets each, in this order.
FLIPPED = np.concatenate(
    [
        [[pair[0, 0], pair[0, 1], other], [other, pair[0, 1], pair[0, 2]]]
        for pair in STOCK.reshape(6, 2, 3, 3)
        for other in [next(v for v in pair[1] if not (v == pair[0]).all(1).any())]
    ]
)
# A fold at a box's corner.
FIN = np.array([[[10, 10, 10], [90, 10, 10], [90, 90, 10]], [[10, 10, 10], [10, 90, 90], [90, 90, 10]]])
# Three boxes side by side: two have a wall with the third.
CORNER = np.concatenate([box(0, 100), box((100, 0, 0), (200, 100, 100)), box((0, 100, 0), (100, 200, 100))])
TURNED = np.concatenate([STOCK[:1, ::-1], STOCK[1:]])
# A box that has one vertex with STOCK, and lies across it.
LEANING = box(0, 1) @ np.array([[200, 20, 20], [10, 80, 10], [10, 10, 80]])
IN_BOTH = box((66, 40, 40), (70, 44, 44))


WAYS = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]])
SIDES = box(0, 10).reshape(6, 2, 3, 3)


def cells(filled):
    """Return the surface of cells (X, Y, Z), cubes of 10 where they are filled."""
    around, there = np.pad(filled, 1), np.argwhere(filled)
    return np.concatenate(
        [
            pair + 10 * at
            for at in there
            for way, pair in zip(WAYS, SIDES, strict=True)
            if not around[tuple(at + 1 + way)]
        ]
    )


def probe(at):
    """Return a box within a cell."""
    return box(10 * np.array(at) + 3, 10 * np.array(at) + 7)


# A hole from above that goes on to one side, and a bent needle that comes out of it.
BLOCK = np.ones((5, 5, 5), np.bool_)
BLOCK[2, 2, 2:] = BLOCK[3, 2, 2] = False
NEEDLE = np.array([[[35, 25, 25], [25, 25, 25], [25, 25, 25]], [[25, 25, 25], [25, 25, 80], [25, 25, 80]]])


# Two boxes across each other, both without a lid; a box with a hole in the middle of each side.
OPEN = np.concatenate([one[one[..., 2].min(1) < 100] for one in (STOCK, box((20, 20, 10), (130, 130, 100)))])
CAGE = cells(np.ones((3, 3, 3), np.bool_))
CAGE = CAGE[(np.abs(CAGE.sum(1) - 45) > 20).sum(1) > 1]


# A drill that looks out of the upper side by far, over the facet of that side that BORED lacks.
DRILL = box((70, 20, 50), (80, 30, 200))
BORED = STOCK[~((STOCK[..., 2] == 100).all(1) & (STOCK[:, :, 0].sum(1) > STOCK[:, :, 1].sum(1)))]
# Without what is between its upper and its lower side.
BANDED = np.concatenate([STOCK[(STOCK[..., 2] == high).all(1)] for high in (0, 100)])


def cracked(off):
    """Return STOCK with a vertex more on an edge of its upper side, on one side of that alone, and off it."""
    facet = next(k for k, one in enumerate(STOCK) if (one[:, 2] == 100).all())
    a, b, c = STOCK[facet]
    middle = (a + b) // 2 + off
    return np.concatenate([np.delete(STOCK, facet, 0), [[a, middle, c], [middle, b, c]]])


@pytest.mark.parametrize(
    "outer", [BORED, np.concatenate([BORED, BORED]), np.concatenate([BORED, BORED[:, ::-1]])]
)
def test_a_part_that_may_go_through_what_is_missing_is_undecided(outer):
    assert len(BORED) == 11
    assert enclosure(solid_of(DRILL), solid_of(STOCK)).state == State.OUTSIDE  # but for its near facets
    for one, other, mesh in ((DRILL, outer, "a"), (outer, DRILL, "b")):
        found = enclosure(solid_of(one), solid_of(other))
        assert found.state == State.UNDECIDED and {part.mesh for part in found.parts} == {mesh}
    # Above it, and beside it.
    for away in ((0, 0, 51), (31, 0, 0), (0, 0, -151), (-81, 0, 0)):
        beside = solid_of(DRILL + np.array(away))
        assert enclosure(beside, solid_of(outer)).state == State.OUTSIDE
    # On its way down to it.
    high, down = solid_of(DRILL + np.array([0, 0, 60])), np.array([[[0, 0, -60], [0, 0, 0]]])
    assert enclosure(high, solid_of(outer), down).state == State.UNDECIDED
    assert enclosure(high, solid_of(outer), down // 8).state == State.OUTSIDE


LOW, HIGH = (BANDED[(BANDED[..., 2] == high).all(1)] for high in (0, 100))
# A tetrahedron without a facet, at whose edges others stand.
APEX = np.array([[0, 0, 0], [100, 0, 0], [0, 100, 0], [0, 0, 100]])
OTHERS = [
    np.array([APEX[i], APEX[j], [out] * 3, [out + 20, out, out]])
    for i, j, out in ((1, 2, 150), (2, 3, 160), (1, 3, 170))
]


def faces(corners, but=None):
    """Return the facets of a tetrahedron, but that across one of its corners."""
    return np.array([np.delete(corners, k, 0) for k in range(4) if k != but])


@pytest.mark.parametrize(
    "copies", [lambda one: np.concatenate([one, one]), lambda one: np.concatenate([one, one[:, ::-1]])]
)
def test_rims_count_facets_once_and_those_of_all_surfaces_together(copies):
    banded = solid_of(np.concatenate([LOW, copies(HIGH)]))
    for tool in (box((40, 40, 40), (200, 60, 60)), box(40, 60)):
        assert enclosure(solid_of(tool), banded).state == State.UNDECIDED
    held = np.concatenate([faces(APEX, but=0), *(faces(one) for one in OTHERS)])
    drill = solid_of(box((20, 20, 20), (25, 25, 400)))
    assert enclosure(drill, solid_of(copies(held))).state == State.UNDECIDED


def test_a_wall_between_two_solids_has_no_rim():
    """As between a cutter and its shank: the same facets, of which each belongs to one of the two."""
    upper = STOCK + np.array([0, 0, 100])
    outer = solid_of(np.concatenate([STOCK, upper]))
    assert len(outer.shells.doubles) == len(outer.shells.doubles_rim) == 0
    assert enclosure(solid_of(box((200, 0, 50), (300, 90, 150))), outer).state == State.OUTSIDE


@pytest.mark.parametrize("turned_round", [False, True])
@pytest.mark.parametrize("turned", [False, True])
def test_a_surface_written_twice_with_other_diagonals_has_a_rim(turned_round, turned):
    """Though each edge of its rim belongs to two facets, no two of which are the same."""
    one, other = (solid[solid[..., 2].min(1) < 100] for solid in (STOCK, FLIPPED))
    outer = np.concatenate([one, other[:, ::-1] if turned_round else other])
    # Turned and rounded, no two are in one plane.
    way = np.array([[0.96, 0.2, 0.19], [-0.17, 0.97, -0.16], [-0.22, 0.13, 0.97]]) * 37
    way = way if turned else np.eye(3)
    outer, drill, deep, above = (
        np.rint(some @ way).astype(np.int64)
        for some in (outer, DRILL, box(40, 60), DRILL + np.array([0, 0, 100]))
    )
    assert shells_of(outer).open_edges.sum() == 0
    for tool, state in ((drill, State.UNDECIDED), (deep, State.UNDECIDED), (above, State.OUTSIDE)):
        assert enclosure(solid_of(tool), solid_of(outer)).state == state
        assert enclosure(solid_of(outer), solid_of(tool)).state == state


@pytest.mark.parametrize(("off", "state"), [(1, State.OUTSIDE), (2, State.OUTSIDE), (3, State.UNDECIDED)])
def test_what_rounding_folds_is_no_rim(off, state):
    """A thin facet between two of the upper side, that lies on one of them."""
    a, b, c, d, m = (np.array([x, y, 100]) for x, y in (
        (0, 0), (100, 0), (100, 100), (0, 100), (50 + off, 50 - off)
    ))  # fmt: skip
    upper = np.array([[a, b, c], [a, c, m], [a, m, d], [m, c, d]])
    closed = solid_of(np.concatenate([FLIPPED[(FLIPPED[..., 2] < 100).any(1)], upper]))
    assert closed.shells.oriented.all()
    spike = solid_of(box((40, -200, 99), (60, 200, 400)))
    assert enclosure(spike, closed).state == state


def test_a_missing_band_is_between_its_rims():
    assert enclosure(solid_of(box((40, 40, 40), (200, 60, 60))), solid_of(BANDED)).state == State.UNDECIDED


def test_in_a_crack_nothing_is_missing():
    spike = solid_of(box((40, -200, 99), (60, 200, 400)))
    for off, state in ((0, State.OUTSIDE), ((0, 1, 0), State.OUTSIDE), ((0, 3, 0), State.UNDECIDED)):
        found = solid_of(cracked(np.array(off)))
        assert found.shells.open_edges.sum() == 3
        assert enclosure(spike, found).state == state, off


@pytest.mark.parametrize(
    ("a", "b", "state", "mesh"),
    [
        (box(40, 60), STOCK, State.INSIDE, "a"),
        (STOCK, box(40, 60), State.INSIDE, "b"),
        (box(140, 160), STOCK, State.OUTSIDE, None),
        # In a cavity, on an island in it, in the wall around it.
        (box(40, 60), np.concatenate([STOCK, box(30, 70, inverted=True)]), State.OUTSIDE, None),
        (box(49, 51), np.concatenate([STOCK, box(30, 70, True), box(40, 60)]), State.INSIDE, "a"),
        (box(10, 20), np.concatenate([STOCK, box(30, 70, inverted=True)]), State.INSIDE, "a"),
        # Where two solids overlap, it is inside both.
        (box(40, 60), np.concatenate([STOCK, box(30, 170)]), State.INSIDE, "a"),
        # Both turned inside out, it is too; one alone, it may be; elsewhere that tells nothing.
        (box(40, 60), np.concatenate([STOCK, box(30, 170)])[:, ::-1], State.INSIDE, "a"),
        (box(40, 60), np.concatenate([STOCK, box(30, 170, inverted=True)]), State.UNDECIDED, "a"),
        (box(140, 160), np.concatenate([STOCK, box(300, 400, inverted=True)]), State.OUTSIDE, None),
        (box(140, 160), np.concatenate([STOCK, box(30, 170, inverted=True)]), State.INSIDE, "a"),
        # One of two parts.
        (np.concatenate([box(200, 210), box(40, 60)]), STOCK, State.INSIDE, "a"),
        # The hole of a ring is outside; so is a ring around a bar, and a ring in a groove's hole.
        (box((-2, -2, 0), (2, 2, 3)), ring(), State.OUTSIDE, None),
        (box((-20, -20, 100), (20, 20, 200)), ring(100), State.OUTSIDE, None),
        (box((630, -20, 100), (670, 20, 200)), ring(100), State.INSIDE, "a"),
        (ring(), box((-2, -2, -9), (2, 2, 9)), State.OUTSIDE, None),
        # A closed shell with a facet turned round tells odd from even, and no more.
        (box(40, 60), TURNED, State.INSIDE, "a"),
        (box(140, 160), np.concatenate([TURNED, box(120, 130)]), State.OUTSIDE, None),
        (box(40, 60), np.concatenate([TURNED, box(30, 70)]), State.UNDECIDED, "a"),
        # What is open may be a solid with a facet missing.
        (box(40, 60), STOCK[1:], State.UNDECIDED, "a"),
        (box(40, 60)[1:], STOCK, State.INSIDE, "a"),
        # A facet twice, and faces that do not hang together, are open as well.
        (box(40, 60), np.concatenate([STOCK, STOCK[:1]]), State.UNDECIDED, "a"),
        (box(40, 60), STOCK + np.array([0, 0, 1]) * (np.arange(12) < 2)[:, None, None], State.UNDECIDED, "a"),
        # Both sides of a surface: of a solid that has an inside, or of a sheet that has none.
        (box(40, 60), np.concatenate([STOCK, STOCK[:, ::-1]]), State.UNDECIDED, "a"),
        (np.concatenate([STOCK, STOCK[:, ::-1]]), box(40, 60), State.UNDECIDED, "b"),
        (box(40, 60), np.concatenate([STOCK, STOCK[:, ::-1], box(100, 200)]), State.UNDECIDED, "a"),
        (box(140, 160), np.concatenate([STOCK, STOCK[:, ::-1], box(100, 200)]), State.INSIDE, "a"),
        (box(40, 60), np.concatenate([STOCK, TURNED]), State.UNDECIDED, "a"),
        (box(40, 60), np.concatenate([STOCK, STOCK]), State.INSIDE, "a"),
        (box(140, 160), np.concatenate([STOCK, STOCK[:, ::-1]]), State.OUTSIDE, None),
        # The other side with other diagonals; with a hole in both sides; and of a sheet that is folded.
        (box(40, 60), np.concatenate([STOCK, FLIPPED[:, ::-1]]), State.UNDECIDED, "a"),
        (box(140, 160), np.concatenate([STOCK, FLIPPED[:, ::-1]]), State.OUTSIDE, None),
        *(
            (
                box(40, 60),
                np.concatenate([np.delete(STOCK, k, 0), np.delete(STOCK, k, 0)[:, ::-1]]),
                State.UNDECIDED,
                "a",
            )
            for k in range(12)
        ),
        (box(20, 40), np.concatenate([box(0, 10), FIN, FIN[:, ::-1]]), State.UNDECIDED, "a"),
        # Open bodies, all of it twice, with the same side or with both, where rays pass two, or none.
        *(
            (inner, np.concatenate([outer, outer[:, ::way]]), state, mesh)
            for inner, outer, state, mesh in (
                (box(50, 60), OPEN, State.UNDECIDED, "a"),
                (probe((1, 1, 1)), CAGE, State.UNDECIDED, "a"),
                (probe((4, 1, 1)), CAGE, State.OUTSIDE, None),
            )
            for way in (1, -1)
        ),
        (box((-2, -2, 0), (2, 2, 3)), np.concatenate([ring(), ring()]), State.OUTSIDE, None),
        # What rounding made of details has no sides.
        (
            box((-2, -2, 0), (2, 2, 3)),
            np.concatenate([ring(), *(box(k, k) for k in (-9, 9))]),
            State.OUTSIDE,
            None,
        ),
        # Solids that touch have walls twice, and an inside.
        (box((140, 40, 40), (160, 60, 60)), CORNER, State.INSIDE, "a"),
        (box((140, 140, 40), (160, 160, 60)), CORNER, State.OUTSIDE, None),
        # Several bodies that have a vertex in common: with a facet turned round, and one of them mirrored.
        (IN_BOTH, np.concatenate([TURNED, LEANING]), State.UNDECIDED, "a"),
        (IN_BOTH, np.concatenate([STOCK, LEANING[:, ::-1]]), State.UNDECIDED, "a"),
        (IN_BOTH, np.concatenate([STOCK, LEANING]), State.INSIDE, "a"),
        # Two that are written with both sides, where they overlap.
        (
            box(60, 65),
            np.concatenate([*(one[:, ::way] for way in (1, -1) for one in (STOCK, box(30, 170)))]),
            State.UNDECIDED,
            "a",
        ),
        # A solid within what is turned inside out; and cavities of two solids that overlap.
        (box(45, 55), np.concatenate([box(0, 100, True), box(20, 80)]), State.UNDECIDED, "a"),
        (
            box(55, 60),
            np.concatenate([STOCK, box(20, 120), box(40, 80, True), box(45, 85, True)]),
            State.OUTSIDE,
            None,
        ),
        # In a bent hole nothing sees the outside, but what comes out of it.
        (probe((3, 2, 2)), cells(BLOCK), State.UNDECIDED, "a"),
        (NEEDLE, cells(BLOCK), State.OUTSIDE, None),
        (probe((2, 2, 3)), cells(BLOCK), State.OUTSIDE, None),
        # Where no part fits the other's box, nothing needs to be decided.
        (box(40, 60), box((0, 0, 0), (100, 100, 50))[1:], State.OUTSIDE, None),
    ],
)
def test_who_is_inside_whom(a, b, state, mesh):
    found = enclosure(solid_of(a), solid_of(b))
    assert found.state == state
    assert [part.mesh for part in found.parts] == ([mesh] if mesh else [])


def test_rounding_leaves_closed_what_was_closed():
    for scale in (40.0, 1.0, 0.3, 0.1):
        for solid in (scenes.tool(), scenes.vise()):
            found = shells_of(np.rint(solid * scale).astype(np.int64))
            assert found.closed.all()
            assert found.oriented.all()


def rays(point, facets, rng):
    """Return the winding number of facets around a point on none of them, by a ray in a random direction.

    A ray that meets an edge is drawn again. Python's integers, no arithmetic in common with the product.
    """
    while True:
        way = [int(x) for x in rng.integers(-(10**6), 10**6, 3)]
        total = 0
        for facet in facets.tolist():
            a, b, c = ([x - int(o) for x, o in zip(v, point, strict=True)] for v in facet)
            sides = [volume(way, u, v) for u, v in ((a, b), (b, c), (c, a))]
            if min(sides) > 0 or max(sides) < 0:
                # The ray's line goes through; the facet is ahead where a, b, c and the way turn the same.
                ahead = volume(a, b, c)
                total += (sides[0] > 0) - (sides[0] < 0) if (ahead > 0) == (sides[0] > 0) else 0
            elif 0 in sides and (min(sides) >= 0 or max(sides) <= 0) and any(sides):
                break
        else:
            return total


def volume(u, v, w):
    return (
        u[0] * (v[1] * w[2] - v[2] * w[1])
        + u[1] * (v[2] * w[0] - v[0] * w[2])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
    )


def solid(rng):
    """Return one closed, oriented solid on a grid so small that facets collapse and rays meet edges."""
    kind = rng.integers(3)
    if kind == 0:
        made = box(-1, 1)
    elif kind == 1:
        made = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
        made = rng.integers(-4, 5, (4, 3))[made]
    else:
        made = ring(0.5)
    sheared = made @ (rng.integers(-1, 2, (3, 3)) + 2 * np.eye(3, dtype=np.int64))
    # Clipped to the grid: a map of vertices, so it stays closed.
    return np.clip(sheared + rng.integers(-2, 3, 3), -6, 6)


def free(points, facets):
    """Return the points (K, 3) that lie on no facet."""
    pairs = [np.stack([np.broadcast_to(p, facets.shape), facets], 1) for p in points]
    near = bulk_verdicts(np.concatenate(pairs), 0)["near"]
    return points[~near.reshape(len(points), -1).any(1)]


def test_rays_in_other_directions_agree(rng):
    within = 0
    for _ in range(20):
        facets = np.concatenate([solid(rng) for _ in range(rng.integers(1, 4))])
        points = free(rng.integers(-3, 4, (25, 3)), facets)
        expected = np.array([rays(point, facets, rng) != 0 for point in points], np.bool_)
        found = shells_of(facets)
        assert found.oriented.all()
        assert (inside(points, facets, found)[0] == expected).all()
        within += int(expected.sum())
        # The same over the whole range of 20 and of 32 bits.
        for width in (20, 32):
            large = ((1 << width) - 1) // 12
            there, at = (x * large + (6 * large - (1 << (width - 1))) for x in (facets, points))
            assert (inside(at, there, shells_of(there))[0] == expected).all()
    assert within > 30


def grown(part):
    """Return cells with all that touch them, of an array with room around."""
    steps = [np.roll(part, step, (0, 1, 2)) for step in np.ndindex(3, 3, 3) for step in [np.array(step) - 1]]
    return np.any(steps, 0)


def is_cavity(at, body, others):
    """Return whether what hangs together with a cell of a body is within the others, and meets no wall."""
    part = np.zeros_like(body)
    part[at] = True
    while (more := grown(part) & body).sum() > part.sum():
        part = more
    return bool((others | ~grown(part)).all())


def test_nothing_in_a_body_is_ever_outside(rng):
    """Bodies of cells that overlap and touch, each turned inside out or not, some with facets turned round.

    But what is turned inside out within others is a cavity. Some stand half a cell aside, so that they cross
    others, and have no vertices in common with them.
    """
    found = dict.fromkeys(State, 0)
    for _ in range(60):
        bodies = [rng.random((4, 4, 4)) < rng.choice([0.3, 0.6, 0.9]) for _ in range(rng.integers(1, 4))]
        bodies = [np.pad(body, 2) for body in bodies if body.any()]
        aside = rng.random(len(bodies)) < 0.3
        surfaces = [cells(body) + 5 * moved for body, moved in zip(bodies, aside, strict=True)]
        mirrored, spoilt = (rng.random(len(bodies)) < part for part in (0.3, 0.2))
        for k, surface in enumerate(surfaces):
            some = slice(None) if mirrored[k] else slice(int(rng.integers(len(surface))), None)
            some = slice(some.start, some.start + 1) if spoilt[k] and not mirrored[k] else some
            if mirrored[k] or spoilt[k]:
                surface[some] = surface[some, ::-1].copy()
        outer = solid_of(np.concatenate(surfaces))
        # In half cells.
        halves = [
            np.roll(np.kron(body, np.ones((2, 2, 2), np.bool_)), moved, (0, 1, 2))
            for body, moved in zip(bodies, aside.tolist(), strict=True)
        ]
        for at in map(tuple, rng.integers(4, 13, (12, 3)).tolist()):
            state = enclosure(solid_of(box(5 * np.array(at) + 1, 5 * np.array(at) + 4)), outer).state
            others = [np.any([*halves[:k], *halves[k + 1 :], 0 * halves[k]], 0) for k in range(len(halves))]
            turned = np.flatnonzero(mirrored | spoilt)
            cavity = any(halves[k][at] and is_cavity(at, halves[k], others[k]) for k in turned)
            if np.any(halves, 0)[at] and not cavity:
                assert state != State.OUTSIDE
            elif not np.any(halves, 0)[at] and not len(turned):
                assert state != State.INSIDE
            found[state] += 1
    assert min(found[state] for state in (State.INSIDE, State.OUTSIDE, State.UNDECIDED)) > 40, found
