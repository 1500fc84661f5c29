"""The stress test: knobs do what their labels say, what must not be is seen."""

import json
from typing import Any

import numpy as np
import pytest

from triaxis.bench import harness
from triaxis.bench.stress import measuring, report
from triaxis.bench.stress.constructions import WIDTH, contacts_at, near_misses, nearly_coplanar
from triaxis.bench.stress.families import FAMILIES
from triaxis.bench.stress.measuring import FamilyResult, StressResult, measure
from triaxis.bench.stress.methods import guigue_devillers, moller, separating_axes
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.exact import Rational
from triaxis.golden.judge import judge
from triaxis.host.cli import main
from triaxis.verif.core.stimulus.symmetry import VERTICES

# Steps of the 16-bit grid, of those of a gap family.
LSB = 1 << WIDTH - 16


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_every_setting_makes_pairs(family):
    for setting in family.settings:
        pairs, again = (setting.make(np.random.default_rng(1), 41) for _ in range(2))
        assert pairs.shape == (41, 2, 3, 3) and pairs.dtype == np.int64 and (pairs == again).all()
        assert np.abs(pairs).max() < 1 << 53
        near = np.mean([judge(a, b, 0).near for a, b in pairs.tolist()])
        assert near == 1 if (family.name, setting.label) == ("gap", "0") else 0.1 < near < 0.9, setting.label


def exact_points(pairs) -> Any:
    """Return pairs as exact rationals: (6, 3, N)."""
    points = np.empty((6, 3, len(pairs)), object)
    for index, value in np.ndenumerate(pairs.reshape(-1, 6, 3).transpose(1, 2, 0)):
        points[index] = Rational(int(value))
    return points


def grid_pairs(rng, count, flat):
    """Return pairs of proper triangles on a small grid, that touch in every way; flat: coplanar."""
    pairs = rng.integers(-4, 5, (count, 2, 3, 3))
    if flat:
        pairs[..., 2] = 0
        pairs = pairs @ rng.integers(-2, 3, (count, 1, 3, 3))
    facts = bulk_facts(pairs, 0)
    return pairs[(facts.rank_a == 2) & (facts.rank_b == 2)]


MADE = {
    "near misses of 32 bits": lambda rng: near_misses(rng, 60, 32),
    "nearly coplanar": lambda rng: nearly_coplanar(rng, 80, 2.0**-60),
    "small grid": lambda rng: grid_pairs(rng, 150, False),
    "small grid, coplanar": lambda rng: grid_pairs(rng, 200, True),
}


@pytest.mark.parametrize("made", MADE)
def test_published_tests_are_right_in_exact_arithmetic(rng, made):
    """So that their errors on floats are rounding."""
    pairs = MADE[made](rng)
    facts = bulk_facts(pairs, 0)
    proper = (facts.rank_a == 2) & (facts.rank_b == 2)
    near, points = facts.near[proper], exact_points(pairs[proper])
    assert 0 < near.sum() < len(near) > 40
    for order in VERTICES[rng.permutation(72)[:4]]:
        ordered = points[order]
        for test in (separating_axes, moller, guigue_devillers):
            assert (test(ordered[:3], ordered[3:]) == near).all(), test.__name__


def exact_core(_width, pairs, margin):
    """Answer as the core must, without a build."""
    return bulk_facts(pairs, margin).near


def test_a_wrong_bulk_checker_is_seen(monkeypatch):
    monkeypatch.setattr(measuring, "bulk_facts", lambda pairs, limit: bulk_facts(pairs, limit + 1))
    # Apart by one step of a grid: near by the wrong checker.
    pairs = np.zeros((200, 2, 3, 3), np.int64)
    pairs[:, 1] = 1
    assert any(
        "contradicted by the linear program" in problem for problem in measure(pairs, exact_core).problems
    )


@pytest.mark.parametrize("width", [8, 18, 32])
def test_near_misses_without_a_problem(rng, width):
    measured = measure(near_misses(rng, 240, width), exact_core)
    assert measured.problems == []
    assert measured.own_width == min(w for w in measuring.WIDTHS if w >= width)
    assert measured.core.answers == 3 * 240 * 72 and measured.no_miss.answers == 240 * 72
    rates = [found.wrong_rate for found in measured.methods.values()]
    assert width != 8 or max(rates) < 0.01
    assert width != 32 or min(rates) > 0.15


def test_what_must_not_be_is_seen(rng):
    def broken(_width, pairs, margin):
        near = exact_core(_width, pairs, margin)
        near[71] = ~near[71]
        return near

    found = measure(near_misses(rng, 30, 16), broken)
    assert found.core.wrong == 3 and found.core.changing_pairs == 3
    assert found.problems[0] == "core: 3 wrong answers at its own resolution"
    # A margin too small misses, one too large leaves the band.
    close, apart = contacts_at(rng, 60, WIDTH, LSB / 8), contacts_at(rng, 60, WIDTH, 3.2 * LSB)
    assert measure(close, exact_core).problems == [] == measure(apart, exact_core).problems
    assert "misses" in "".join(measure(close, exact_core, margin=0).problems)
    assert "beyond the band" in "".join(measure(apart, exact_core, margin=2).problems)
    measured = measure(contacts_at(rng, 300, WIDTH, 1.8 * LSB), exact_core)
    assert 0 < measured.no_miss.false_alarms < measured.band_pairs * 72 and 1.2 < measured.farthest <= 2


def test_command_writes_numbers_and_pictures(tmp_path, monkeypatch, capsys):
    rng = np.random.default_rng(1)
    easy, missing = (measure(contacts_at(rng, 8, WIDTH, LSB / 8), exact_core, margin=m) for m in (None, 0))
    monkeypatch.setattr(harness, "FOLDER", tmp_path)
    for first, code in ((easy, 0), (missing, 1)):
        monkeypatch.setattr(report, "PICTURES", () if code else report.PICTURES[:1])
        families = [FamilyResult((first, *[easy] * (len(one.settings) - 1)), one) for one in FAMILIES]
        result = StressResult(1, 100, tuple(families))
        monkeypatch.setattr(report, "run_stress", lambda *_, result=result: result)
        assert main(["bench", "stress"]) == code
        content = json.loads((tmp_path / "stress.json").read_text())
        assert content["passed"] is (code == 0) and content["rtl_hash"] and content["seed"] == 1
    assert "PROBLEM gap 2^-8: no-miss mode:" in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {"stress.json", "stress.png", "stress.svg"}
    setting = content["families"][0]["settings"][1]
    assert setting["core_at_its_own_resolution"]["wrong_rate"] == 0
    assert main(["bench", "stress", "--pairs=3"]) == 2 and "pairs" in capsys.readouterr().err
