"""What a stress test counts, and that it sees what must not be."""

import json

import numpy as np
import pytest

from triaxis.bench.stress import exact_pairs, measuring, results, run
from triaxis.bench.stress.curves import PICTURES
from triaxis.bench.stress.exact_pairs import BulkPairs, JudgedPairs
from triaxis.bench.stress.families import FAMILIES
from triaxis.bench.stress.lattice_families import WIDTH, contacts_at, near_misses
from triaxis.bench.stress.measuring import measure, rtl_core
from triaxis.bench.stress.orders import METHODS, Errors, errors, in_all_orders, scaled, total
from triaxis.bench.stress.plot import draw
from triaxis.bench.stress.real_families import far_away, of_unlike_size, slivers
from triaxis.bench.stress.run import FamilyResult, StressResult, measure_setting
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.sim.provenance import provenance

# Steps of the 16-bit grid, of those of a gap family.
LSB = 1 << WIDTH - 16


def exact_core(_width, pairs, margin):
    """Answer as the core must, without a build."""
    return bulk_facts(pairs, margin).near


def test_errors_are_counted():
    near = np.array([True, False, True])
    answers = np.array([[True, False, False], [True, True, False]])
    assert errors(answers, near) == Errors(6, 2, 1, 3, 2, 1)
    both = total([errors(answers, near), errors(answers, near)])
    assert both == Errors(12, 4, 2, 6, 4, 2)
    assert (both.wrong, both.rate, both.changing_rate) == (6, 0.5, pytest.approx(1 / 3))


def test_every_order_is_asked(rng):
    pairs = rng.integers(-99, 99, (2, 2, 3, 3))
    seen = []

    def test(a, b):
        seen.append(np.concatenate([a, b])[:, :, 0])
        return np.arange(a.shape[2]) == 0

    answers = in_all_orders(test, scaled(pairs))
    assert answers.shape == (72, 2) and answers[:, 0].all() and not answers[:, 1].any()
    assert len({points.tobytes() for points in seen}) == 72
    assert len({tuple(sorted(points.ravel().tolist())) for points in seen}) == 1


def test_scaling_is_exact(rng):
    pairs = rng.integers(1 - (1 << 53), 1 << 53, (5, 2, 3, 3))
    points = scaled(pairs)
    assert np.abs(points).max() < 1 << 20
    assert (points * 2.0**33 == pairs.reshape(-1, 6, 3).transpose(1, 2, 0)).all()


@pytest.mark.parametrize("limit", [0, 1, 7, 1000])
def test_both_ways_to_exact_facts_agree(rng, limit):
    pairs = rng.integers(-800, 800, (150, 2, 3, 3))
    bulk, judged = BulkPairs(pairs), JudgedPairs(pairs)
    assert (bulk.within(limit) == judged.within(limit)).all()
    assert bulk.contradicted == 0 and bulk.judged == 2 and judged.judged == 150
    chosen = judged.within(1000)
    assert bulk.reach(chosen, 5000) == judged.reach(chosen, 5000)
    assert judged.reach(np.ones(150, np.bool_), 1) is None


def test_a_wrong_bulk_checker_is_seen(rng, monkeypatch):
    def one_off(pairs, limit):
        return bulk_facts(pairs, limit + 1)

    monkeypatch.setattr(exact_pairs, "bulk_facts", one_off)
    # Apart by one step of a grid: near by the wrong checker.
    pairs = np.zeros((200, 2, 3, 3), np.int64)
    pairs[:, 1] = 1
    measured = measure(pairs, exact_core)
    assert any("contradicted by the linear program" in problem for problem in measured.problems)


@pytest.mark.parametrize("width", [8, 12, 18, 24, 32])
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


@pytest.mark.parametrize(
    "make",
    [
        lambda rng: slivers(rng, 40, 2.0**-30),
        lambda rng: of_unlike_size(rng, 40, 2.0**-30),
        lambda rng: far_away(rng, 40, 2.0**30),
    ],
)
def test_real_coordinates_without_a_problem(rng, make):
    measured = measure(make(rng), exact_core)
    assert measured.problems == []
    assert measured.methods["float32 SAT"].rate > 0.1


def test_far_pairs_fit_the_core_all_the_same(rng):
    """The grid's offset takes the distance away, exactly."""
    measured = measure(far_away(rng, 40, 2.0**36), exact_core)
    assert measured.own_width == 16 and measured.resolution == 1 and measured.rounded.wrong == 0
    assert measured.judged_pairs < 10


def test_simulated_core_has_no_problem(rng):
    def simulated(_width, pairs, margin):
        return rtl_core(16, pairs, margin)

    pairs = near_misses(rng, 300, 16)
    assert measure(pairs, simulated).problems == []


def test_core_that_errs_in_one_order_is_seen(rng):
    def broken(_width, pairs, margin):
        near = exact_core(_width, pairs, margin)
        near[71] = ~near[71]
        return near

    found = measure(near_misses(rng, 30, 16), broken)
    assert found.core.wrong == 3 and found.core.changing_pairs == 3
    assert found.problems[0] == "core: 3 wrong answers at its own resolution"


def test_margin_too_small_misses(rng):
    pairs = contacts_at(rng, 60, WIDTH, LSB / 8)
    assert measure(pairs, exact_core).problems == []
    assert "misses" in "".join(measure(pairs, exact_core, margin=0).problems)


def test_margin_too_large_leaves_the_band(rng):
    pairs = contacts_at(rng, 60, WIDTH, 3.2 * LSB)
    exact = measure(pairs, exact_core)
    assert exact.problems == [] and exact.farthest <= 2
    assert "beyond the band" in "".join(measure(pairs, exact_core, margin=2).problems)


def test_false_alarms_reach_into_the_band(rng):
    measured = measure(contacts_at(rng, 300, WIDTH, 1.8 * LSB), exact_core)
    assert measured.problems == []
    assert 0 < measured.no_miss.false_alarms < measured.band_pairs * 72
    assert 1.2 < measured.farthest <= 2


def test_settings_are_repeatable(monkeypatch):
    monkeypatch.setattr(run, "measure", lambda pairs: pairs.tolist())
    first = measure_setting((1, 3), 1, 50)
    assert first == measure_setting((1, 3), 1, 50)
    assert first != measure_setting((1, 3), 2, 50)
    assert first != measure_setting((1, 4), 1, 50)


@pytest.fixture(scope="module")
def small():
    """Return a result of very few pairs, of an exact core."""
    rng = np.random.default_rng(1)

    def measured(family):
        easy, hard = (measure(family.settings[k].make(rng, 8), exact_core) for k in (0, -1))
        return (*[easy] * (len(family.settings) - 1), hard)

    families = tuple(FamilyResult(family, measured(family)) for family in FAMILIES)
    return StressResult(1, 100, families, provenance(), 1.0)


def test_command_writes_numbers_and_pictures(small, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(results, "RESULT", tmp_path / "stress.json")
    monkeypatch.setattr("triaxis.host.cli.bench_errors.run_stress", lambda *_: small)
    assert main(["bench", "stress"]) == 0
    assert "PASSED: core: 0 of" in capsys.readouterr().out
    names = {path.name for path in tmp_path.iterdir()}
    pictures = {
        f"stress{kind}.{suffix}" for kind in ("", "_orders", "_quantisation") for suffix in ("png", "svg")
    }
    assert names == {"stress.json", *pictures}
    content = json.loads((tmp_path / "stress.json").read_text())
    assert content["passed"] and content["rtl_hash"] and content["seed"] == 1
    assert [family["name"] for family in content["families"]] == [family.name for family in FAMILIES]
    first = content["families"][0]["settings"][0]
    assert first["methods"].keys() == {method.name for method in METHODS}
    assert first["core_at_its_own_resolution"]["wrong_rate"] == 0
    # The same result gives the same files.
    again = draw(tmp_path / "again", PICTURES[0], small)
    assert [path.read_bytes() == (tmp_path / path.name).read_bytes() for path in again] == [True, True]


def test_command_says_what_is_wrong(small, tmp_path, monkeypatch, capsys):
    rng = np.random.default_rng(1)
    missing = measure(contacts_at(rng, 30, WIDTH, LSB / 8), exact_core, margin=0)
    family = small.families[1]
    broken = FamilyResult(family.family, (missing, *family.measured[1:]))
    result = StressResult(1, 100, (small.families[0], broken, *small.families[2:]), small.provenance, 1.0)
    monkeypatch.setattr(results, "RESULT", tmp_path / "stress.json")
    monkeypatch.setattr(results, "PICTURES", ())
    monkeypatch.setattr("triaxis.host.cli.bench_errors.run_stress", lambda *_: result)
    assert main(["bench", "stress"]) == 1
    assert "PROBLEM gap 2^-8: no-miss mode:" in capsys.readouterr().out
    assert not json.loads((tmp_path / "stress.json").read_text())["passed"]


@pytest.mark.parametrize(("option", "value"), [("--pairs", "3"), ("--pairs", "1000000"), ("--seed", "-1")])
def test_options_out_of_range(option, value, capsys):
    assert main(["bench", "stress", f"{option}={value}"]) == 2
    assert option[2:] in capsys.readouterr().err
    with pytest.raises(InputError):
        run.check_options(1, 0)
