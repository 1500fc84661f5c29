import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from triaxis.coverage.counts import Counts, CoverageDatabase, load, read_counts, write_counts
from triaxis.coverage.cover_model import CoverItem, CoverModel, Coverpoint
from triaxis.golden.errors import InputError

DIGIT = Coverpoint[Any]("digit", tuple("0123456789"), lambda s: (s % 10).astype(np.uint8))
PARITY = Coverpoint[Any]("parity", ("even", "odd"), lambda s: (s % 2).astype(np.uint8))
MODEL = CoverModel("digits", (CoverItem("digit", "", (DIGIT,)), CoverItem("both", "", (DIGIT, PARITY))))
OTHER = CoverModel("others", (CoverItem("parity", "", (PARITY,)),))
CHANGED = CoverModel("digits", (CoverItem("digit", "", (DIGIT,), at_least=2), MODEL.items[1]))

values = st.lists(st.integers(0, 99), max_size=8)


def counted(numbers, model=MODEL):
    counts = Counts.empty(model)
    counts.sample(model, np.array(numbers, np.int64))
    return counts


def merge(model, parts):
    total = Counts.empty(model)
    for part in parts:
        total.add(part)
    return total


def flat(counts):
    return {name: hits.tolist() for name, hits in counts.hits.items()}


@given(values, values, values)
def test_merging_is_associative_and_commutative_with_a_neutral_element(a, b, c):
    x, y, z = counted(a), counted(b), counted(c)
    left, right = merge(MODEL, [merge(MODEL, [x, y]), z]), merge(MODEL, [x, merge(MODEL, [y, z])])
    assert flat(left) == flat(right) == flat(merge(MODEL, [z, y, x])) == flat(counted(a + b + c))
    assert flat(merge(MODEL, [x, Counts.empty(MODEL)])) == flat(x)


def test_counts_of_another_model_or_definition_are_refused():
    for wrong in (counted([1], OTHER), counted([1], CHANGED)):
        with pytest.raises(InputError, match="cannot be merged"):
            merge(MODEL, [wrong])
    with pytest.raises(InputError, match="no such model"):
        CoverageDatabase([MODEL]).add(counted([1], OTHER))


def test_files_come_back_whole(tmp_path):
    path = tmp_path / "coverage.json"
    counted([1, 2, 30]).save(path)
    assert flat(load(path, MODEL)) == flat(counted([1, 2, 30]))
    database = CoverageDatabase([MODEL, OTHER])
    database.add_file(path)
    database.add_file(path)
    database.add(counted([7], OTHER))
    database.save(path)
    digits, others = read_counts(path, [OTHER, MODEL])
    assert flat(digits) == flat(counted([1, 2, 30] * 2)) and flat(others) == flat(counted([7], OTHER))
    assert [p.name for p in tmp_path.iterdir()] == ["coverage.json"]
    assert [model.name for model, _ in database] == ["digits", "others"]


def test_a_file_of_another_model_is_refused(tmp_path):
    path = tmp_path / "coverage.json"
    counted([1]).save(path)
    with pytest.raises(InputError, match="not among those"):
        load(path, OTHER)
    with pytest.raises(InputError, match="another definition of coverage model digits"):
        load(path, CHANGED)
    write_counts(path, [])
    with pytest.raises(InputError, match="counts of 0 models"):
        load(path, MODEL)


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: text[: len(text) // 2],
        lambda text: "",
        lambda text: "[1, 2]",
        lambda text: "{}",
        lambda text: text.replace("[0, 1,", "[0, 7,", 1),
        lambda text: text.replace("triaxis coverage 1", "triaxis coverage 2"),
        lambda text: json.dumps({**json.loads(text), "models": []}),
        lambda text: text.replace('"digit"', '"tigid"'),
        lambda text: "[" * 100_000,
        lambda text: "\x00\xff",
    ],
)
def test_damaged_files_are_refused(tmp_path, damage):
    path = tmp_path / "coverage.json"
    counted([1]).save(path)
    text = path.read_text()
    assert damage(text) != text
    path.write_text(damage(text))
    with pytest.raises(InputError, match=r"coverage\.json: .*delete it and run again"):
        load(path, MODEL)
