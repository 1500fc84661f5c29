"""The least distance of two meshes, and the facets that are so near: exact, of what the files say."""

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from triaxis.host.engines import BULK, NO_PAIRS, STILL, scene_engine
from triaxis.host.euclidean import euclidean_distance
from triaxis.host.scene import FacetPairs, MeshPair, bulk_near, distance_of, near_facets

# Pairs of which the exact distance is computed, of so many at a time; those of which it may be.
_JUDGED, _CHUNK, _LISTED = 2000, 200, 1 << 24


@dataclass(frozen=True)
class Least:
    """Facet numbers in the files, and their distance. ``exact``: no other pair is nearer; else one may be, by
    less than rounding to the grid and back; by Euclid by more, where very many pairs are about as near.
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
    return _by_euclid(meshes, best, reading) if euclidean else best


def _by_euclid(meshes: MeshPair, best: Least, reading: Fraction) -> Least:
    """Return the nearest facets by Euclid, which are no further apart than some are.

    By Chebyshev, and by the boxes of facets, they are at most as far apart as by Euclid. So pairs are judged
    in the order of their boxes, until these are beyond the nearest yet: by more than what reading and
    rounding moved, and double precision, of which 2^-40 is more than enough.
    """
    resolution = float(meshes.grid.resolution)
    reach = Fraction(best.distance) / meshes.grid.resolution + 2 + reading
    pairs, beyond, listed, left = NO_PAIRS, np.empty(0), 0, math.inf
    for _, some in near_facets(meshes.a, meshes.b, _margin(meshes, reach), bulk_near):
        a, b = meshes.a[some[:, 0]].astype(np.float64), meshes.b[some[:, 1]].astype(np.float64)
        gaps = np.maximum(0, np.maximum(a.min(1) - b.max(1), b.min(1) - a.max(1)))
        apart = np.sqrt((gaps**2).sum(1)) * (1 - 2.0**-40) - 2 * float(2 + reading)
        pairs, beyond = np.concatenate([pairs, some]), np.concatenate([beyond, resolution * apart])
        order = np.argsort(beyond, kind="stable")
        left = min([left, *beyond[order[_JUDGED:][:1]]])
        pairs, beyond = pairs[order[:_JUDGED]], beyond[order[:_JUDGED]]
        listed += len(some)
        if listed > _LISTED:
            left = -math.inf
            break
    for start in range(0, len(pairs), _CHUNK):
        if beyond[start] > best.distance:
            break
        found = _best(meshes, pairs[start : start + _CHUNK], True)
        best = min(best, found, key=lambda one: (one.distance, one.a, one.b))
    return replace(best, exact=left > best.distance and meshes.pose.exact)


def _nearest(meshes: MeshPair, reach: Fraction) -> FacetPairs:
    """Return facet pairs within so many steps: more than are judged where there are more, but not all."""
    found = [NO_PAIRS]
    for _, near in near_facets(meshes.a, meshes.b, _margin(meshes, reach), bulk_near):
        found.append(near)
        if sum(map(len, found)) > _JUDGED:
            break
    return np.concatenate(found)


def _margin(meshes: MeshPair, reach: Fraction) -> int:
    return min(-int(-reach // 1), (1 << meshes.grid.width) - 1)


def _best(meshes: MeshPair, pairs: FacetPairs, euclidean: bool) -> Least:
    of = euclidean_distance if euclidean else distance_of
    judged = [
        (of(meshes.mesh_a, i, meshes.mesh_b, j, meshes.pose.move), i, j) for i, j in pairs[:_JUDGED].tolist()
    ]
    distance, i, j = min(judged)
    return Least(i, j, float(distance), len(pairs) <= _JUDGED and meshes.pose.exact)
