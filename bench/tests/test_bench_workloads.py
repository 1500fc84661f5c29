from fractions import Fraction

import numpy as np
import pytest

from triaxis.bench.error.core_points import on_grid
from triaxis.bench.error.grids import finest_grid
from triaxis.bench.error.truth import exact_triangle, exact_truth
from triaxis.bench.error.workloads import LATTICE_BITS, proper, workloads
from triaxis.golden.exact import triangle_rank
from triaxis.host.mesh_data import mesh_data
from triaxis.host.quantise import box_of, fits, grid_around

COUNT = 240


@pytest.fixture(scope="module")
def made():
    return {workload.name: workload for workload in workloads(COUNT, 5, None)}


def test_workloads_follow_from_the_seed(made):
    assert list(made) == ["random", "made solids", "near-contact made solids", "lattice near-misses"]
    for again, other in zip(workloads(COUNT, 5, None), workloads(COUNT, 6, None), strict=True):
        first = made[again.name]
        assert len(first) == COUNT == len(first.a)
        assert np.array_equal(first.a, again.a) and np.array_equal(first.b, again.b)
        assert not np.array_equal(first.b, other.b)
        assert first.a.dtype == first.b.dtype == np.float32


def test_real_meshes_where_they_are():
    data = mesh_data()
    if data is None:
        pytest.skip("real meshes: no folder $TRIAXIS_DATA or ../shared/data")
    real = {workload.name: workload for workload in workloads(COUNT, 5, data)}
    assert list(real) == ["random", "real meshes", "near-contact real meshes", "lattice near-misses"]
    sources = [part.source for part in real["real meshes"].parts]
    assert "carousel against arm" in sources and len(sources) == 8
    # In millimetres: the machine is more than a metre high.
    carousel = real["real meshes"].parts[0]
    assert np.ptp(np.concatenate([carousel.a, carousel.b]).reshape(-1, 3)[:, 2]) > 100


def test_no_triangle_is_degenerate(made):
    for workload in made.values():
        for triangle in np.concatenate([workload.a, workload.b]):
            assert triangle_rank(exact_triangle(triangle)) == 2


def test_degenerate_triangles_are_found_exactly(rng):
    """Segments of any direction, in float32 where that holds them, and triangles off them by one bit."""
    start, step = rng.integers(-(2**10), 2**10, (2, 300, 1, 3))
    segments = (start + step * rng.integers(-50, 51, (300, 3, 1))).astype(np.float32)
    assert not proper(segments).any()
    # Thin, far from the origin, and hardly wider than the last place of its coordinates.
    thin = np.array(
        [[[4096, 4096, 0], [4097, 4097, 0], [4098, np.nextafter(np.float32(4098), 0), 0]]], np.float32
    )
    assert proper(thin).all()


def test_contacts_are_close_and_on_both_sides(made, tmp_path):
    contacts = made["near-contact made solids"]
    truth = exact_truth(contacts.a, contacts.b, folder=tmp_path)
    assert max(truth.distances) < Fraction(2, 100)
    assert 0.3 < truth.near().mean() < 0.9
    assert sum(0 < distance < Fraction(1, 10**4) for distance in truth.distances) > COUNT / 20


def test_lattice_is_held_exactly(made, tmp_path):
    lattice = made["lattice near-misses"]
    assert on_grid(lattice, LATTICE_BITS).unchanged
    assert not on_grid(lattice, LATTICE_BITS - 4).unchanged
    near = exact_truth(lattice.a, lattice.b, folder=tmp_path).near()
    assert 0.5 < near.mean() < 0.8


@pytest.mark.parametrize("width", [8, 16, 32])
def test_the_finest_grid_holds_its_boxes_and_none_finer_does(made, width):
    for part in made["random"].parts:
        boxes = [box_of(part.a), box_of(part.b)]
        grid = finest_grid(boxes, width)
        assert fits(boxes, grid)
        assert not fits(boxes, grid_around(boxes, grid.resolution / 2, width))
