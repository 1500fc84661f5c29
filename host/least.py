"""The least distance of two meshes, and the facets that are so near: exact, of what the files say."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from triaxis.host.engines import BULK, NO_PAIRS, STILL, scene_engine
from triaxis.host.euclidean import euclidean_distance
from triaxis.host.scene import FacetPairs, MeshPair, bulk_near, distance_of, near_facets

# Pairs of which the exact distance is computed.
_JUDGED = 2000


@dataclass(frozen=True)
class Least:
    """Facet numbers in the files, and their distance. ``exact``: no other pair is nearer; else one may be, by
    less than rounding to the grid and back.
    """

    a: int
    b: int
    distance: float
    exact: bool


def least_distance(meshes: MeshPair, euclidean: bool) -> Least:
    """Return the nearest facets; where many are as near, one of them.

    On the grid d is the least margin at which any are near. In the files those that are nearest are within
    d + 2 steps, as rounding moves each mesh by half a step, forth and back; and what reading moved on top.
    """
    engine = scene_engine(BULK, meshes.a, meshes.b, meshes.grid.width)
    clear, near = -1, (1 << meshes.grid.width) - 1
    while near - clear > 1:
        margin = (clear + near) // 2
        if engine.run(STILL, margin, stop_at_first=True).near_count:
            near = margin
        else:
            clear = margin
    reading = (meshes.mesh_a.rounding + meshes.mesh_b.rounding) / meshes.grid.resolution
    best = _best(meshes, _nearest(meshes, near + 2 + 2 * reading), euclidean)
    if euclidean:
        # By Chebyshev they are at most as far apart as by Euclid.
        reach = Fraction(best.distance) / meshes.grid.resolution + 2 + reading
        best = _best(meshes, _nearest(meshes, reach), euclidean)
    return best


def _nearest(meshes: MeshPair, reach: Fraction) -> FacetPairs:
    """Return facet pairs within so many steps: more than are judged where there are more, but not all."""
    margin, found = min(-int(-reach // 1), (1 << meshes.grid.width) - 1), [NO_PAIRS]
    for _, near in near_facets(meshes.a, meshes.b, margin, bulk_near):
        found.append(near)
        if sum(map(len, found)) > _JUDGED:
            break
    return np.concatenate(found)


def _best(meshes: MeshPair, pairs: FacetPairs, euclidean: bool) -> Least:
    of = euclidean_distance if euclidean else distance_of
    judged = [
        (of(meshes.mesh_a, i, meshes.mesh_b, j, meshes.pose.move), i, j) for i, j in pairs[:_JUDGED].tolist()
    ]
    distance, i, j = min(judged)
    return Least(i, j, float(distance), len(pairs) <= _JUDGED and meshes.pose.exact)
