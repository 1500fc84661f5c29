import json
from typing import Any

import numpy as np
import pytest

from triaxis.coverage.core_model import CORE_MODEL, CoreSample, _rank
from triaxis.coverage.covergroup import NO_BIN, Counts, CoverModel, Coverpoint, cross, load, merge, report
from triaxis.coverage.text import coverage_lines
from triaxis.golden.axes import separating
from triaxis.golden.errors import InputError

PARITY = Coverpoint[Any]("parity", "even or odd", ("even", "odd"), lambda s: s % 2)
SIZE = Coverpoint[Any]("size", "size", ("small", "large"), lambda s: np.where(s < 0, NO_BIN, (s > 9) * 1))
MODEL = CoverModel("numbers", (PARITY, SIZE, cross("both", "both", PARITY, SIZE)))
OTHER = CoverModel("numbers", (PARITY,))


def counted(*values):
    counts = Counts.empty(MODEL)
    counts.sample(MODEL, np.array(values, np.int64))
    return counts


def test_counts_and_report():
    counts = counted(1, 3, 10, -2)
    assert counts.hits["parity"].tolist() == [2, 2]
    assert counts.hits["size"].tolist() == [2, 1]
    assert counts.hits["both"].tolist() == [0, 1, 2, 0]
    reports = report(MODEL, counts)
    assert [(r.hit, r.total) for r in reports] == [(2, 2), (2, 2), (2, 4)]
    assert reports[2].missing == ("even / small", "odd / large")
    assert "missing: even / small, odd / large" in coverage_lines(reports)[2]


def test_merging_does_not_depend_on_order(rng):
    parts = [counted(*rng.integers(-5, 20, 9)) for _ in range(4)]

    def flat(counts):
        return np.concatenate([counts.hits[p.name] for p in MODEL.coverpoints]).tolist()

    expected = flat(merge(MODEL, parts))
    for _ in range(5):
        order = [parts[i] for i in rng.permutation(4)]
        nested = merge(MODEL, [merge(MODEL, order[:2]), merge(MODEL, order[2:])])
        assert flat(merge(MODEL, order)) == flat(nested) == expected


def test_saved_counts_come_back(tmp_path):
    path = tmp_path / "coverage.json"
    counted(1, 2, 30).save(path)
    assert load(path, MODEL).hits["size"].tolist() == [2, 1]


def test_other_or_damaged_files_are_refused(tmp_path):
    path = tmp_path / "coverage.json"
    counted(1).save(path)
    with pytest.raises(InputError, match="another coverage model"):
        load(path, OTHER)
    with pytest.raises(InputError, match="another coverage model"):
        merge(OTHER, [counted(1)])
    content = json.loads(path.read_text())
    content["hits"]["parity"] = [1]
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match="damaged"):
        load(path, MODEL)
    path.write_text(path.read_text()[:30])
    with pytest.raises(InputError, match="not a coverage file"):
        load(path, MODEL)
    with pytest.raises(InputError, match="cannot read"):
        load(tmp_path / "missing.json", MODEL)


def test_ranks_are_exact():
    big = 2**31 - 1
    sliver = [[0, 0, 0], [big, big - 1, 0], [big - 1, big - 2, 0]]
    wrapped = [[-(2**31), 0, 0], [2**31 - 1, 0, 0], [0, 2**31 - 1, 2**31 - 1]]
    line = [[-(2**31), -(2**31), 0], [0, 0, 0], [2**31 - 1, 2**31 - 1, 0]]
    triangles = np.array([sliver, wrapped, line, [[5, 5, 5]] * 3], np.int64)
    assert _rank(triangles).tolist() == [2, 2, 1, 0]


def test_core_model_tells_what_it_sees():
    point, flat = [[1, 1, 5]] * 3, [[0, 0, 0], [4, 0, 0], [0, 4, 0]]
    pairs = np.array([[flat, point], [point, flat], [flat, flat]], np.int64)
    margins = np.array([0, 5, 0])
    separates = separating(pairs, margins)
    sample = CoreSample(
        pairs,
        margins,
        np.logical_not(separates.any(1)),
        separates,
        np.array([0, 1, 9]),
        np.zeros(3, np.int64),
        16,
        15,
    )
    counts = Counts.empty(CORE_MODEL)
    counts.sample(CORE_MODEL, sample)
    hit = {
        p.name: [b for b, n in zip(p.bins, counts.hits[p.name].tolist(), strict=True) if n]
        for p in CORE_MODEL.coverpoints
    }
    # The height, 5, decides the first pair; at margin 5 the second just touches.
    assert hit["claim"] == ["near", "02 box z"]
    assert hit["ranks_near"] == [
        "point / triangle / near",
        "triangle / point / clear",
        "triangle / triangle / near",
    ]
    assert hit["wait_in"] == ["none", "1", "8 or more"]
    assert hit["margin_near"] == ["0 / clear", "0 / near", "2 to 7 / near"]
