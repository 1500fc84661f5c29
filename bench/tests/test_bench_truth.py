from fractions import Fraction

import numpy as np
import pytest

from triaxis.bench.error.truth import check_triangles, exact_truth
from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.errors import InputError


def test_distances_are_those_of_the_integers(rng, tmp_path):
    """On small integers, which float32 holds, the bulk checker has the same near pairs at every margin."""
    pairs = rng.integers(-6, 7, (1200, 2, 3, 3))
    a, b = (pairs[:, k].astype(np.float32) for k in (0, 1))
    told = []
    truth = exact_truth(a, b, told.append, tmp_path)
    assert sum(told) == len(truth) == 1200
    for margin in range(4):
        assert np.array_equal(truth.near(margin), bulk_verdicts(pairs, margin)["near"])
    assert 0 < truth.near().sum() < 1200


def test_no_bit_of_a_float_is_lost(tmp_path):
    """Two points one unit in the last place apart, and the same at denormal size."""
    a = np.ones((2, 3, 3), np.float32)
    b = a.copy()
    b[0, :, 1] = np.nextafter(np.float32(1), np.float32(2))
    a[1] = 0
    b[1] = 0
    b[1, :, 2] = np.float32(1e-45)
    assert exact_truth(a, b, folder=tmp_path).distances == (Fraction(1, 2**23), Fraction(1, 2**149))


def test_answers_are_kept_and_a_damaged_file_is_not_believed(rng, tmp_path, monkeypatch):
    a, b = rng.uniform(-1, 1, (2, 5, 3, 3)).astype(np.float32)
    first = exact_truth(a, b, folder=tmp_path)
    (path,) = tmp_path.glob("*.json")
    monkeypatch.setattr("triaxis.bench.error.truth._solve", lambda *_: pytest.fail("solved again"))
    assert exact_truth(a, b, folder=tmp_path) == first
    monkeypatch.undo()
    for damage in ("", "[]", '["1/0", "1", "1", "1", "1"]', "3"):
        path.write_text(damage)
        assert exact_truth(a, b, folder=tmp_path) == first
    exact_truth(a[::-1], b, folder=tmp_path)
    assert len(list(tmp_path.glob("*.json"))) == 2


def test_bad_triangles_are_refused(tmp_path):
    good = np.zeros((2, 3, 3), np.float32)
    bad = good.copy()
    bad[1, 2, 0] = np.inf
    with pytest.raises(InputError, match="triangles B: pair 1, vertex 2, coordinate x: not finite"):
        exact_truth(good, bad, folder=tmp_path)
    with pytest.raises(InputError, match="float64"):
        check_triangles(good.astype(np.float64), good)
    with pytest.raises(InputError, match="shape"):
        exact_truth(good, good[:1], folder=tmp_path)
