"""Run time against error: what is demanded, what is left behind, a run that goes on where it stopped."""

import json
from dataclasses import replace

import numpy as np
import pytest

from triaxis.bench.error import running
from triaxis.bench.error.plot import draw
from triaxis.bench.error.points import COLLISION, MODES, NO_MISS, WIDTHS, CorePoint, Errors, on_grid
from triaxis.bench.error.report import demands, passed, write_report
from triaxis.bench.error.running import Benchmark, Measured, WorkloadResult
from triaxis.bench.error.software_points import BulkPoint, PeerPoint, bulk_point, golden_ns, peer_point
from triaxis.bench.error.truth import exact_truth
from triaxis.bench.error.workloads import workloads
from triaxis.bench.peers.peer import TrianglePeer
from triaxis.bench.peers.wheels import one_by_one
from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.sim.validity import Provenance

BEFORE = Provenance("rtl", "environment", "Verilator", None, None)


def load(a, b):
    """Ask the bulk checker one by one, as if it were a package."""
    pairs = np.rint(np.stack([a, b], 1) * 1024).astype(np.int64)
    return one_by_one(lambda pair: bool(bulk_verdicts(pair[None], 0)["near"][0]), [(p,) for p in pairs])


EXACT = TrianglePeer("exact", "exact", "exact.ask", lambda: "1", load)


def core(width, mode, errors, **changes):
    point = CorePoint(width, mode, errors, (0.5,), int(mode == NO_MISS), 0, 0.5, 100, 0, 1.0, False)
    return replace(point, **changes)


def peer(name="CGAL, C++", distribution="libcgal-dev", run=130.0, call=10.0, bulk=40.0):
    return PeerPoint(name, distribution, "1", "call", Errors(100, 40, 4, 0), run, call, 50.0, bulk, 2.0)


@pytest.fixture
def measured():
    """Return what a run could have found, everything in order."""
    workload = workloads(12, 1, None)[0]
    shares = {COLLISION: Errors(100, 40, 3, 2), NO_MISS: Errors(100, 40, 0, 9)}
    points = [core(width, mode, shares[mode]) for width in WIDTHS for mode in MODES]
    points[-2] = core(WIDTHS[-1], COLLISION, Errors(100, 40, 0, 0), unchanged=True)
    bulk = [BulkPoint(width, mode, 40.0, 200.0, 60, 0, 0) for width in WIDTHS for mode in MODES]
    result = WorkloadResult(workload, 40, points, bulk, 2e5, [peer(), peer("VTK", "vtk")])
    dsps = {(width, mode): 100 for width in WIDTHS for mode in MODES}
    return Measured(1, False, dsps, [result], {"coal": "coal: not installed"}, 0)


def changed(measured, **changes):
    return replace(measured, results=[replace(measured.results[0], **changes)])


def test_a_package_is_judged_on_all_pairs_and_timed_without_its_calls(tmp_path, monkeypatch):
    monkeypatch.setattr("triaxis.bench.error.software_points.ROUNDS", 4)
    workload = workloads(60, 1, None)[0]
    truth = exact_truth(workload.a, workload.b, folder=tmp_path)
    point = peer_point(EXACT, "1", workload, on_grid(workload, 32), truth)
    assert point.errors.pairs == 60 and point.errors.missed + point.errors.false_alarms <= 2
    assert point.kernel_ns == max(0, point.run_ns - point.overhead_ns)
    assert min(point.run_ns, point.overhead_ns, point.bulk_ns, point.load_ns) > 0
    assert replace(point, run_ns=9.0, overhead_ns=5.0, noise_ns=3.0).most_kernel_ns is None
    assert replace(point, run_ns=9.0, overhead_ns=5.0, noise_ns=6.0).most_kernel_ns == 10.0


def test_bulk_times_come_with_proven_axes():
    workload = workloads(200, 1, None)[0]
    point = bulk_point(on_grid(workload, 16), 16, NO_MISS)
    assert 0 < point.clear < 200 and point.unproven == 0 == point.differs
    assert point.claims_ns > 0 and 0 < point.facts_ns < golden_ns(workload)


def test_demands_that_are_reached(measured):
    found = demands(measured)
    assert [demand.verdict for demand in found] == ["reached"] * len(found)
    assert passed(found) and "3.0 times" in found[-1].found


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"errors": Errors(100, 40, 1, 9)}, "misses nothing"),
        ({"beyond_band": 1}, "false alarms within"),
        ({"rtl_differs": 1}, "RTL"),
        ({"cycles_per_pair": 1.5}, "one pair a clock"),
    ],
)
def test_missed_demands_on_the_core(measured, changes, what):
    points = measured.results[0].core
    found = demands(changed(measured, core=[*points[:-1], replace(points[-1], **changes)]))
    assert [demand.reached for demand in found if what in demand.what] == [False]
    assert sum(demand.reached is False for demand in found) == 1 and not passed(found)


def test_missed_demands_on_software(measured):
    slow = demands(changed(measured, peers=[peer(bulk=61.0)]))
    assert slow[-1].reached is False and not passed(slow)
    unproven = demands(changed(measured, bulk=[replace(measured.results[0].bulk[0], unproven=1)]))
    assert [d.what for d in unproven if d.reached is False] == ["bulk checker's axes prove what they claim"]
    # What is absent is not called reached.
    absent = demands(changed(measured, peers=[peer("VTK", "vtk")]))
    assert absent[-1].verdict == "NOT MEASURED" and passed(absent)


def test_numbers_and_pictures_hold_everything(measured, tmp_path, monkeypatch):
    monkeypatch.setattr("triaxis.bench.error.report.RESULT", tmp_path / "error.json")
    monkeypatch.setattr("triaxis.bench.error.plot.PICTURE", tmp_path / "e")
    content = json.loads(write_report(measured, demands(measured), BEFORE, 2.5).read_text())
    assert content["passed"] and content["rtl_hash"] == "rtl" and content["seed"] == 1
    assert content["peers_absent"] == {"coal": "coal: not installed"}
    assert content["core"]["dsp48e1"]["no-miss"]["16"] == 100
    random = content["workloads"]["random"]
    assert random["core"][0]["errors"]["missed_share"] == 3 / 40
    assert random["peers"][0]["kernel_ns"] == 120 and random["peers"][0]["times_bulk"] == 3
    png, svg = draw(measured)
    for name in ("CGAL, C++", "VTK", "golden model", "bulk checker, no-miss, W 32", "core, no-miss, W 8..32"):
        assert name in svg.read_text()
    assert png.stat().st_size > 50_000
    first = svg.read_bytes()
    draw(measured)
    assert svg.read_bytes() == first


@pytest.fixture
def quick(measured, tmp_path, monkeypatch):
    """Make a run quick: one width, no simulator, one package."""
    monkeypatch.setattr(running, "WIDTHS", (8,))
    monkeypatch.setattr(running, "FOLDER", tmp_path / "steps")
    monkeypatch.setattr("triaxis.bench.error.truth.FOLDER", tmp_path)
    monkeypatch.setattr(running, "_dsps", lambda progress: measured.dsps)
    monkeypatch.setattr(running, "golden_ns", lambda _: 1.0)
    monkeypatch.setattr("triaxis.bench.error.points._through_rtl", lambda *_: (0, 1, 1.0))
    monkeypatch.setattr(running, "TRIANGLE_PEERS", (EXACT,))
    return tmp_path / "steps"


def test_a_run_goes_on_where_it_was_interrupted(quick, monkeypatch):
    asked = []

    def point(_peer, _version, workload, *_):
        asked.append(workload.name)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return peer("exact", "exact")

    monkeypatch.setattr(running, "peer_point", point)
    with pytest.raises(KeyboardInterrupt):
        Benchmark(1, BEFORE, 40).run(lambda _: None)
    again = Benchmark(1, BEFORE, 40).run(lambda _: None)
    # Three and a half of four workloads were there but for the third one's package.
    assert again.taken_up == 8 and len(asked) == 5
    assert [len(result.peers) for result in again.results] == [1, 1, 1, 1]
    assert not quick.exists()


def test_a_package_that_fails_is_named(quick, monkeypatch):
    def fails(*_):
        raise TypeError("incompatible function arguments")

    monkeypatch.setattr(running, "peer_point", fails)
    with pytest.raises(InputError, match="exact 1: fails on random: TypeError: incompatible"):
        Benchmark(1, BEFORE, 40).run(lambda _: None)


@pytest.mark.parametrize(("kernel", "code"), [(130.0, 0), (50.0, 1)])
def test_exit_codes(measured, tmp_path, monkeypatch, capsys, kernel, code):
    class Done:
        real_meshes, steps = False, 1

        def __init__(self, *_):
            pass

        def run(self, _):
            return changed(measured, peers=[peer(run=kernel)])

    monkeypatch.setattr("triaxis.bench.commands.errors.Benchmark", Done)
    monkeypatch.setattr("triaxis.bench.error.report.RESULT", tmp_path / "error.json")
    monkeypatch.setattr("triaxis.bench.error.plot.PICTURE", tmp_path / "error")
    assert main(["bench", "error"]) == code
    shown = capsys.readouterr().out
    assert "coal: not installed" in shown and ("MISSED" in shown) == bool(code)
    assert json.loads((tmp_path / "error.json").read_text())["passed"] != bool(code)
