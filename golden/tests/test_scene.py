"""Answers for whole scenes are those of every pair by itself, and every skip has a proof."""

from itertools import product

import numpy as np
import pytest

from triaxis.golden.judge import judge_pairs
from triaxis.golden.scene import scene_answer


def meshes(rng, count_a, count_b, reach=40, size=12):
    def mesh(count):
        return rng.integers(-reach, reach, (count, 1, 3)) + rng.integers(-size, size + 1, (count, 3, 3))

    return mesh(count_a), mesh(count_b)


@pytest.mark.parametrize(("count_a", "count_b", "group"), [(1, 1, 4), (5, 9, 4), (6, 7, 1)])
def test_every_pair_is_judged_as_by_itself(seed, count_a, count_b, group):
    a, b = meshes(np.random.default_rng([seed, count_a]), count_a, count_b)
    for margin in (0, 7):
        answer = scene_answer(a, b, margin, group)
        for i, j in product(range(count_a), range(count_b)):
            pair = np.stack([a[i], b[j]])[None]
            assert answer.near[i, j] == judge_pairs(pair, np.array([margin]))["near"][0]


def test_a_skip_has_an_axis_that_separates_every_triangle_of_it(seed):
    rng = np.random.default_rng(seed)
    for _ in range(20):
        a, b = meshes(rng, 13, 10)
        answer = scene_answer(a, b, 5, 4)
        for i, j in product(range(13), range(10)):
            gaps = np.maximum(b[j].min(0) - a[i].max(0), a[i].min(0) - b[j].max(0))
            assert answer.boxes_apart[i, j] == (gaps.max() > 5)
            assert not answer.groups_apart[i // 4, j // 4] or answer.boxes_apart[i, j]
            assert not answer.rows_apart[i // 4] or answer.groups_apart[i // 4, j // 4]
        assert not (answer.near & answer.boxes_apart).any()


def test_the_account_has_every_pair_once(seed):
    rng = np.random.default_rng(seed)
    for count_a, count_b in ((0, 0), (0, 5), (5, 0), (1, 1), (9, 17)):
        a, b = meshes(rng, count_a, count_b)
        answer = scene_answer(a, b, 3, 4)
        assert answer.group_pairs_skipped + answer.group_pairs_opened == -(-count_a // 4) * -(-count_b // 4)
        left = int(answer.in_groups_apart.sum())
        assert left + answer.pairs_skipped + answer.tested == count_a * count_b
        assert len(answer.to_be_tested) == answer.tested
