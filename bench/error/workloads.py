"""The pairs that everything is asked: float32 triangles in millimetres, as they come, rounded to no grid.

Each workload has parts that share a working volume: the pairs of a scene, for which a user would choose one
grid. No triangle is degenerate, since most packages demand that; `make stress` has those.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.bench.error.truth import Triangles, exact_triangle
from triaxis.bench.stress.constructions import contacts
from triaxis.golden.exact import triangle_rank
from triaxis.host.broadphase import all_candidates
from triaxis.host.quantise import Grid, Steps, box_of, finest_resolution, grid_around, quantise
from triaxis.host.scenes import Scene, machine_scenes, scenes
from triaxis.host.stl import Facets
from triaxis.verif.core.stimulus.contact import Contact
from triaxis.verif.core.stimulus.near_miss import edge_edge, edge_edge_level, face_vertex, face_vertex_level
from triaxis.verif.core.stimulus.stimulus import divided

Rng = np.random.Generator
Reals = npt.NDArray[np.float64]

# Lattice near-misses: integers of so many bits, which float32 holds, in steps of 2^-16 mm: a cube of 256 mm.
LATTICE_BITS = 24
_LATTICE_STEP = 2.0**-16
# Units of the machine's files, in mm; what the unit of the parts' files is, nobody says.
_MACHINE_UNIT = 10.0
# Bits of the grid on which facets that come close are looked for, and how close, in its steps.
_SEARCH_BITS, _SEARCH_REACH = 16, 400
# How far the first solid is moved at most, as a share of the scene's extent: the scenes are close ones.
_MOVES = 0.02
# Gaps of a contact, in mm, on both sides of it; float32 then rounds the triangles by up to 3e-5 mm.
_LEAST_GAP, _LARGEST_GAP = 1e-7, 1e-2


@dataclass(frozen=True)
class Part:
    """Pairs of triangles A (N, 3, 3) and B (N, 3, 3) in one working volume, and where they are from."""

    source: str
    a: Triangles
    b: Triangles

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.a)


@dataclass(frozen=True)
class Workload:
    """Pairs, part by part. The same seed gives the same pairs."""

    name: str
    parts: tuple[Part, ...]

    def __len__(self) -> int:
        """Return the number of pairs."""
        return sum(len(part) for part in self.parts)

    @property
    def a(self) -> Triangles:
        """Return the first triangles (N, 3, 3)."""
        return np.concatenate([part.a for part in self.parts])

    @property
    def b(self) -> Triangles:
        """Return the second triangles (N, 3, 3)."""
        return np.concatenate([part.b for part in self.parts])


def part_grid(a: Facets, b: Facets, width: int) -> Grid:
    """Return the grid that a user would choose for two solids: the finest that holds them.

    Its resolution is a power of two: float32 coordinates are multiples of such, so a grid fine enough rounds
    nothing.
    """
    box = box_of(np.concatenate([a, b]))
    return grid_around([box], finest_resolution(box, width, steps=Steps.BINARY), width)


def workloads(count: int, seed: int, data: Path | None) -> list[Workload]:
    """Return the workloads, of ``count`` pairs each; ``data``: the folder of real meshes, None where absent.

    Without it the project's own solids, a tool and a vise, take their place, and the names say so.
    """
    source, solids = ("real meshes", _real(data)) if data else ("made solids", scenes())

    def on_solids(draw: "Callable[[Rng, Scene, int], _Pairs]") -> "Callable[[Rng], list[Part]]":
        def parts(rng: Rng) -> list[Part]:
            shares = divided(count, [1] * len(solids))
            return [
                _sound(solid.name, lambda n, s=solid: draw(rng, s, n), share)
                for solid, share in zip(solids, shares, strict=True)
            ]

        return parts

    makers: dict[str, Callable[[Rng], list[Part]]] = {
        "random": lambda rng: [_sound("uniform in 100 mm", lambda n: _random(rng, n), count)],
        source: on_solids(_in_poses),
        f"near-contact {source}": on_solids(_in_contact),
        "lattice near-misses": lambda rng: _lattice(rng, count),
    }
    return [
        Workload(name, tuple(make(np.random.default_rng([seed, *name.encode()]))))
        for name, make in makers.items()
    ]


# Triangles A and B, not yet known to be sound.
_Pairs = tuple[Triangles, Triangles]


def _real(data: Path) -> list[Scene]:
    """Return the scenes of real meshes in millimetres; parts of unknown unit as if theirs was that."""
    machine = {path.stem for path in (data / "vmc").glob("*.stl")}

    def unit(scene: Scene) -> float:
        return _MACHINE_UNIT if scene.name.split()[0] in machine else 1.0

    return [Scene(s.name, s.a * unit(s), s.b * unit(s), s.near) for s in machine_scenes(data)]


def _sound(source: str, draw: Callable[[int], _Pairs], count: int) -> Part:
    """Return ``count`` pairs without degenerate triangles, drawn until there are enough."""
    a, b = np.empty((2, 0, 3, 3), np.float32)
    while len(a) < count:
        more_a, more_b = (more[: count - len(a)] for more in draw(count - len(a)))
        kept = proper(more_a) & proper(more_b)
        a, b = np.concatenate([a, more_a[kept]]), np.concatenate([b, more_b[kept]])
    return Part(source, a, b)


def proper(triangles: Triangles) -> npt.NDArray[np.bool_]:
    """Return which triangles (N, 3, 3) are no segments and no points, exactly.

    In float64, an edge is off by 2^-53 of itself, and the 1-norm of the cross product of two by less than
    2^-49 of the product of their 1-norms; where that leaves a doubt, rationals decide.
    """
    real = triangles.astype(np.float64)
    p, q = real[:, 1] - real[:, 0], real[:, 2] - real[:, 0]
    sure = np.abs(np.cross(p, q)).sum(1) > 2.0**-49 * np.abs(p).sum(1) * np.abs(q).sum(1)
    for index in np.flatnonzero(~sure):
        sure[index] = triangle_rank(exact_triangle(triangles[index])) == 2
    return sure


def _random(rng: Rng, count: int) -> _Pairs:
    """Return pairs anywhere in cubes of every size from 2 to 100 mm, which lie anywhere in one of 100 mm."""
    size = np.exp2(rng.uniform(1, np.log2(100), (count, 1, 1, 1)))
    corner = rng.uniform(-50, 50 - size, (count, 1, 1, 3))
    triangles = (corner + size * rng.random((count, 2, 3, 3))).astype(np.float32)
    return triangles[:, 0], triangles[:, 1]


def _in_poses(rng: Rng, scene: Scene, count: int) -> _Pairs:
    """Return facet pairs of a few poses: half of those of a pose close, the others any.

    The scene as it stands comes first, then with the first solid moved a little, again and again.
    """
    reach = _MOVES * float(np.ptp(np.concatenate([scene.a, scene.b]).reshape(-1, 3), 0).max())
    move, b = np.zeros(3), scene.b.astype(np.float32)
    pairs_a, pairs_b = np.empty((2, 0, 3, 3), np.float32)
    while len(pairs_a) < count:
        if len(pairs_a):
            move = rng.uniform(-reach, reach, 3)
        a = (scene.a + move).astype(np.float32)
        close = rng.permutation(_close(scene.name, a, b))[: count // 4]
        any_pair = np.stack([rng.integers(0, len(x), len(close) + 1) for x in (a, b)], 1)
        chosen = np.concatenate([close, any_pair])
        pairs_a = np.concatenate([pairs_a, a[chosen[:, 0]]])
        pairs_b = np.concatenate([pairs_b, b[chosen[:, 1]]])
    order = rng.permutation(len(pairs_a))
    return pairs_a[order], pairs_b[order]


def _close(name: str, a: Triangles, b: Triangles) -> npt.NDArray[np.int64]:
    """Return the facets (K, 2) whose boxes come close, about."""
    grid = part_grid(a, b, _SEARCH_BITS)
    return all_candidates(quantise(a, grid, name), quantise(b, grid, name), _SEARCH_REACH)


def _in_contact(rng: Rng, scene: Scene, count: int) -> _Pairs:
    """Return facet pairs, about ``count``: the second is moved until it touches the first, or all but."""
    half = -(-count // 2)
    # Of pairs of edges, half and more do not fit.
    touching = [
        _vertex_on_face(rng, *_drawn(rng, scene, half)),
        _edge_on_edge(rng, *_drawn(rng, scene, 4 * half)),
    ]
    pairs_a, pairs_b = np.empty((2, 0, 3, 3))
    for a, b, here, there, normal in touching:
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        kept = np.flatnonzero(length[:, 0] > 0)[:half]
        # They touch, but for rounding; then a gap along the way from A to B.
        touched = b[kept] + (there - here)[kept, None]
        gaps = _gaps(rng, len(kept)) * (normal[kept] / length[kept])[:, None]
        pairs_a, pairs_b = np.concatenate([pairs_a, a[kept]]), np.concatenate([pairs_b, touched + gaps])
    return pairs_a.astype(np.float32), pairs_b.astype(np.float32)


def _drawn(rng: Rng, scene: Scene, count: int) -> tuple[Reals, Reals]:
    """Return any facets, with their edges in any of the three places."""
    drawn: list[Reals] = []
    for facets in (scene.a, scene.b):
        chosen = facets[rng.integers(0, len(facets), count)].astype(np.float64)
        turned = (np.arange(3) + rng.integers(0, 3, (count, 1))) % 3
        drawn.append(np.take_along_axis(chosen, turned[..., None], 1))
    return drawn[0], drawn[1]


def _gaps(rng: Rng, count: int) -> Reals:
    """Return gaps (N, 1, 1) at every scale: a third apart, a third overlapping, a third none."""
    size = np.exp(rng.uniform(np.log(_LEAST_GAP), np.log(_LARGEST_GAP), (count, 1, 1)))
    return size * rng.choice([-1.0, 0.0, 1.0], (count, 1, 1))


def _vertex_on_face(rng: Rng, a: Reals, b: Reals) -> tuple[Reals, ...]:
    """Return A and B, B's vertex outermost towards A's face, on either side of that, a place in the face
    where it is to come, and the way from A to B there. All of B may come to lie in A's plane.
    """
    normal = rng.choice([-1.0, 1.0], (len(a), 1)) * np.cross(a[:, 1] - a[:, 0], a[:, 2] - a[:, 0])
    outermost = np.einsum("nvk,nk->nv", b, normal).argmin(1)
    place = np.einsum("nv,nvk->nk", rng.dirichlet((1, 1, 1), len(a)), a)
    return a, b, b[np.arange(len(a)), outermost], place, normal


def _edge_on_edge(rng: Rng, a: Reals, b: Reals) -> tuple[Reals, ...]:
    """Return A and B, a place on B's first edge, one on A's where it is to come, and the way from A to B
    there: of those whose third vertices are on opposite sides then.
    """
    normal = np.cross(a[:, 1] - a[:, 0], b[:, 1] - b[:, 0])
    third_a, third_b = (np.einsum("nk,nk->n", t[:, 2] - t[:, 0], normal) for t in (a, b))
    share = rng.uniform(0.05, 0.95, (2, len(a), 1))
    on_a, on_b = (t[:, 0] + s * (t[:, 1] - t[:, 0]) for t, s in zip((a, b), share, strict=True))
    fits = third_a * third_b < 0
    return tuple(x[fits] for x in (a, b, on_b, on_a, normal * np.sign(third_b)[:, None]))


def _lattice(rng: Rng, count: int) -> list[Part]:
    """Return pairs whose decision hangs on the smallest step of the lattice; see `near_miss`."""
    kinds: Sequence[tuple[str, Callable[[Rng, int, int], Contact], int]] = (
        ("vertex and face, a step off", face_vertex, 2),
        ("vertex and face, touching", face_vertex_level, 1),
        ("edge and edge, a step off", edge_edge, 2),
        ("edge and edge, touching", edge_edge_level, 1),
    )
    shares = divided(count, [share for _, _, share in kinds])
    parts: list[Part] = []
    for (source, make, _), share in zip(kinds, shares, strict=True):
        pairs = contacts(make, rng, share, LATTICE_BITS).pairs * _LATTICE_STEP
        parts.append(Part(source, pairs[:, 0].astype(np.float32), pairs[:, 1].astype(np.float32)))
    return parts
