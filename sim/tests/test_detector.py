"""The combinational wrapper: the seed design's users drop it in."""

import re

import numpy as np
import pytest

from triaxis.golden.axes import claims
from triaxis.golden.pairs import NO_AXIS
from triaxis.sim.detector import WIDTH, detect
from triaxis.sim.paths import DUT
from triaxis.verif.core.stimulus.families import mixed_pairs
from triaxis.verif.core.stimulus.seed_vectors import seed_normals, seed_vectors

pytestmark = pytest.mark.simulator


def test_all_fifteen_seed_vectors_are_clear():
    assert not detect(seed_vectors(WIDTH), seed_normals()).any()


def test_exact_and_blind_to_the_normals_handed_in(rng):
    pairs = mixed_pairs(rng, 3000, WIDTH)
    expected = claims(pairs, np.zeros(3000, np.int64)) == NO_AXIS
    for normals in (np.zeros((3000, 2, 3), np.int64), rng.integers(-32768, 32768, (3000, 2, 3))):
        assert (detect(pairs, normals) == expected).all()
    assert expected.any()
    assert not expected.all()


def test_port_list():
    text = (DUT / "core" / "CollisionDetector.sv").read_text()
    inputs = re.findall(r"input logic signed \[W-1:0\] (\w+)", text)
    vertices = [f"{t}{i}_{k}" for t in "AB" for i in (1, 2, 3) for k in "xyz"]
    assert inputs == vertices + [f"N{t}_{k}" for t in "AB" for k in "xyz"]
    assert re.findall(r"output logic (\w+)", text) == ["CollisionOccurs"]
