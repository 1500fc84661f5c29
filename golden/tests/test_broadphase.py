import numpy as np
import pytest

from triaxis.golden import broadphase
from triaxis.golden.broadphase import candidates


@pytest.mark.parametrize("margin", [0, 1, 50])
@pytest.mark.parametrize("block", [1, 7, 1 << 20])
def test_same_as_trying_all(rng, monkeypatch, margin, block):
    monkeypatch.setattr(broadphase, "_BLOCK", block)
    a = rng.integers(-300, 300, (60, 1, 3)) + rng.integers(-40, 40, (60, 3, 3))
    b = rng.integers(-300, 300, (45, 1, 3)) + rng.integers(-90, 90, (45, 3, 3))
    found = {pair for i, j in candidates(a, b, margin) for pair in zip(i.tolist(), j.tolist(), strict=True)}
    low, high = np.stack([a.min(1), a.max(1)]), np.stack([b.min(1), b.max(1)])
    expected = {
        (i, j)
        for i in range(60)
        for j in range(45)
        if (low[0, i] - margin <= high[1, j]).all() and (high[0, j] - margin <= low[1, i]).all()
    }
    assert found == expected
    assert expected
    assert len(expected) < 60 * 45
