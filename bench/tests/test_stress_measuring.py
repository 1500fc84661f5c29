"""What a stress test counts, and that it sees what must not be."""

import json

import numpy as np
import pytest

from triaxis.bench.harness import SOURCES
from triaxis.bench.stress import measuring, run
from triaxis.bench.stress.constructions import (
    WIDTH,
    contacts_at,
    far_away,
    near_misses,
)
from triaxis.bench.stress.families import FAMILIES
from triaxis.bench.stress.measuring import BulkPairs, JudgedPairs, measure, rtl_core
from triaxis.bench.stress.orders import METHODS, in_all_orders, scaled
from triaxis.bench.stress.run import FamilyResult, StressResult
from triaxis.golden.bulk import bulk_facts
from triaxis.host.cli import main
from triaxis.sim.validity import provenance

# Steps of the 16-bit grid, of those of a gap family.
LSB = 1 << WIDTH - 16


def exact_core(_width, pairs, margin):
    """Answer as the core must, without a build."""
    return bulk_facts(pairs, margin).near


def test_every_order_is_asked(rng):
    seen = []

    def test(a, b):
        seen.append(np.concatenate([a, b])[:, :, 0])
        return np.arange(a.shape[2]) == 0

    answers = in_all_orders(test, scaled(rng.integers(-99, 99, (2, 2, 3, 3))))
    assert answers.shape == (72, 2) and answers[:, 0].all() and not answers[:, 1].any()
    assert len({points.tobytes() for points in seen}) == 72
    assert len({tuple(sorted(points.ravel().tolist())) for points in seen}) == 1


def test_scaling_is_exact(rng):
    pairs = rng.integers(1 - (1 << 53), 1 << 53, (5, 2, 3, 3))
    points = scaled(pairs)
    assert np.abs(points).max() < 1 << 20
    assert (points * 2.0**33 == pairs.reshape(-1, 6, 3).transpose(1, 2, 0)).all()


@pytest.mark.parametrize("limit", [0, 7, 1000])
def test_both_ways_to_exact_facts_agree(rng, limit):
    pairs = rng.integers(-800, 800, (150, 2, 3, 3))
    bulk, judged = BulkPairs(pairs), JudgedPairs(pairs)
    assert (bulk.within(limit) == judged.within(limit)).all()
    assert bulk.contradicted == 0 and bulk.judged == 2 and judged.judged == 150
    chosen = judged.within(1000)
    assert bulk.reach(chosen, 5000) == judged.reach(chosen, 5000)
    assert judged.reach(np.ones(150, np.bool_), 1) is None


def test_a_wrong_bulk_checker_is_seen(monkeypatch):
    monkeypatch.setattr(measuring, "bulk_facts", lambda pairs, limit: bulk_facts(pairs, limit + 1))
    # Apart by one step of a grid: near by the wrong checker.
    pairs = np.zeros((200, 2, 3, 3), np.int64)
    pairs[:, 1] = 1
    problems = measure(pairs, exact_core).problems
    assert any("contradicted by the linear program" in problem for problem in problems)


@pytest.mark.parametrize("width", [8, 18, 32])
def test_near_misses_without_a_problem(rng, width):
    measured = measure(near_misses(rng, 60, width), exact_core)
    assert measured.problems == []
    assert measured.own_width == min(w for w in measuring.WIDTHS if w >= width)
    assert measured.core.answers == 3 * 60 * 72 and measured.no_miss.answers == 60 * 72
    assert measured.resolution == 1 << max(0, width - 16)
    wrong = {name: found.rate for name, found in measured.methods.items()}
    if width == 8:
        assert max(wrong.values()) < 0.01
    elif width >= 24:
        assert min(wrong.values()) > 0.15
        assert all(found.changing_rate > 0.1 for found in measured.methods.values())


def test_far_pairs_fit_the_core_all_the_same(rng):
    """The grid's offset takes the distance away, exactly."""
    measured = measure(far_away(rng, 40, 2.0**36), exact_core)
    assert measured.problems == [] and measured.methods["float32 SAT"].rate > 0.1
    assert measured.own_width == 16 and measured.resolution == 1 and measured.rounded.wrong == 0
    assert measured.judged_pairs < 10


@pytest.mark.simulator
def test_simulated_core_has_no_problem(rng):
    pairs = near_misses(rng, 300, 16)
    assert measure(pairs, lambda _, pairs, margin: rtl_core(16, pairs, margin)).problems == []


def test_core_that_errs_in_one_order_is_seen(rng):
    def broken(_width, pairs, margin):
        near = exact_core(_width, pairs, margin)
        near[71] = ~near[71]
        return near

    found = measure(near_misses(rng, 30, 16), broken)
    assert found.core.wrong == 3 and found.core.changing_pairs == 3
    assert found.problems[0] == "core: 3 wrong answers at its own resolution"


def test_a_margin_too_small_misses_and_one_too_large_leaves_the_band(rng):
    close, apart = contacts_at(rng, 60, WIDTH, LSB / 8), contacts_at(rng, 60, WIDTH, 3.2 * LSB)
    assert measure(close, exact_core).problems == [] == measure(apart, exact_core).problems
    assert "misses" in "".join(measure(close, exact_core, margin=0).problems)
    assert "beyond the band" in "".join(measure(apart, exact_core, margin=2).problems)


def test_false_alarms_reach_into_the_band(rng):
    measured = measure(contacts_at(rng, 300, WIDTH, 1.8 * LSB), exact_core)
    assert measured.problems == []
    assert 0 < measured.no_miss.false_alarms < measured.band_pairs * 72
    assert 1.2 < measured.farthest <= 2


@pytest.mark.regress
def test_command_writes_numbers_and_pictures(tmp_path, monkeypatch, capsys):
    rng = np.random.default_rng(1)

    def measured(family):
        easy, hard = (measure(family.settings[k].make(rng, 8), exact_core) for k in (0, -1))
        return (*[easy] * (len(family.settings) - 1), hard)

    families = [FamilyResult(family, measured(family)) for family in FAMILIES]
    monkeypatch.setattr(run, "RESULT", tmp_path / "stress.json")
    monkeypatch.setattr("triaxis.bench.commands.errors.RESULT", tmp_path / "stress.json")

    def command():
        result = StressResult(1, 100, tuple(families), provenance(SOURCES), 1.0)
        monkeypatch.setattr("triaxis.bench.commands.errors.run_stress", lambda *_: result)
        code = main(["bench", "stress"])
        return code, capsys.readouterr().out, json.loads((tmp_path / "stress.json").read_text())

    code, shown, content = command()
    assert code == 0 and "PASSED: core: 0 of" in shown
    pictures = [f"stress{k}.{suffix}" for k in ("", "_orders", "_quantisation") for suffix in ("png", "svg")]
    assert {path.name for path in tmp_path.iterdir()} == {"stress.json", *pictures}
    assert content["passed"] and content["rtl_hash"] and content["seed"] == 1
    assert [family["name"] for family in content["families"]] == [family.name for family in FAMILIES]
    first = content["families"][0]["settings"][0]
    assert first["methods"].keys() == {method.name for method in METHODS}
    assert first["core_at_its_own_resolution"]["wrong_rate"] == 0
    monkeypatch.setattr("triaxis.bench.stress.plot.PICTURES", ())
    missing = measure(contacts_at(rng, 30, WIDTH, LSB / 8), exact_core, margin=0)
    families[1] = FamilyResult(families[1].family, (missing, *families[1].measured[1:]))
    code, shown, content = command()
    assert code == 1 and "PROBLEM gap 2^-8: no-miss mode:" in shown and not content["passed"]


@pytest.mark.parametrize(("option", "value"), [("--pairs", "3"), ("--pairs", "1000000"), ("--seed", "-1")])
def test_options_out_of_range(option, value, capsys):
    assert main(["bench", "stress", f"{option}={value}"]) == 2
    assert option[2:] in capsys.readouterr().err
