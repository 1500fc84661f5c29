"""What skipping saves: the counts add up and are the engine's, wrong answers are seen, peers are optional."""

import json
from dataclasses import replace

import numpy as np
import pytest

from triaxis.bench.error.peers.peer import PeerAbsentError
from triaxis.bench.mesh_cycles import CONFIGURATION
from triaxis.bench.skipping import asking, clocked, growth, results, run, software, stages
from triaxis.bench.skipping.asking import Meeting, PeerRun, ask_peer, presence
from triaxis.bench.skipping.growth import Growth, Point, exponent, growths
from triaxis.bench.skipping.peers import MESH_PEERS
from triaxis.bench.skipping.peers.mesh_peer import Counted, Question
from triaxis.bench.skipping.run import measure_scene, run_skipping, steps
from triaxis.bench.skipping.scenes import SkippingScene, skipping_scenes
from triaxis.bench.skipping.stages import Stages, stage_answer
from triaxis.bench.skipping.surfaces import SURFACES
from triaxis.golden.pairs import NO_AXIS
from triaxis.golden.scene import SceneAnswer, boxes_of
from triaxis.host.cli import main
from triaxis.host.mesh_data import mesh_data
from triaxis.host.scenes import scenes


@pytest.fixture(autouse=True)
def quickly(monkeypatch):
    monkeypatch.setattr(clocked, "_ROUNDS", 1)


def block(rng, count, place, size=300):
    return rng.integers(-2000, 2001, (count, 1, 3)) + rng.integers(-size, size + 1, (count, 3, 3)) + place


def decided_by_boxes(a, b, margin):
    """Return how many pairs a box axis separates, in groups or not."""
    low_a, high_a = boxes_of(a).transpose(1, 0, 2)
    low_b, high_b = boxes_of(b).transpose(1, 0, 2)
    apart = (low_a[:, None] - high_b[None] > margin) | (low_b[None] - high_a[:, None] > margin)
    return int(apart.any(2).sum())


@pytest.mark.parametrize("margin", [0, 60])
def test_every_pair_is_counted_once(rng, margin):
    a, b = block(rng, 150, 0), block(rng, 90, 1500)
    found = stage_answer(a, b, margin, CONFIGURATION)
    counted = found.stages
    assert counted.pairs == 150 * 90
    assert counted.before_boxes + counted.boxes == decided_by_boxes(a, b, margin)
    assert counted.near == len(found.near)
    assert min(counted.rows, counted.groups, counted.boxes, counted.normals, counted.edges, counted.near) > 0
    assert found.clocks.core == counted.tested
    assert found.clocks.rows == -(-150 // CONFIGURATION.group)


def test_objects_apart_are_skipped_as_a_whole(rng):
    a, b = block(rng, 100, 0), block(rng, 50, 9000)
    assert stage_answer(a, b, 0, CONFIGURATION).stages == Stages(objects=5000)


def test_meshes_beyond_the_depth_are_counted_in_parts(rng):
    small = replace(CONFIGURATION, depth=64)
    a, b = block(rng, 150, 0), block(rng, 90, 1500)
    whole, parts = (stage_answer(a, b, 0, engine) for engine in (CONFIGURATION, small))
    assert parts.stages.pairs == whole.stages.pairs
    assert parts.stages.tested == whole.stages.tested
    np.testing.assert_array_equal(parts.near, whole.near)


def test_axes_are_told_apart():
    axis = np.array([3, 4, 5, 13, 14, 31, NO_AXIS, NO_AXIS])
    nowhere = np.zeros((2, 4), np.bool_)
    answer = SceneAnswer(2, nowhere[0, :1], nowhere[:1, :2], nowhere, nowhere)
    counted = stages._stages(answer, axis)
    assert (counted.normals, counted.edges, counted.edge_boxes, counted.near) == (2, 2, 2, 2)


@pytest.fixture(scope="module")
def row():
    chosen = skipping_scenes(None)[4]
    return measure_scene(chosen, [])


def test_a_scene_in_hardware_and_software(row):
    assert run._scene_problems(row) == []
    assert [at.margin for at in row.at] == [0, row.scene.margin]
    for at in row.at:
        assert 0 < at.stages.tested < at.stages.pairs == row.scene.pairs
        assert at.cycles < at.cycles_without
        assert at.software.tested == at.stages.tested


@pytest.mark.parametrize("lost", ["near", "tested", "skipped"])
def test_an_engine_that_skips_too_much_is_seen(monkeypatch, row, lost):
    class Skipping(run.MeshEngineScene):
        def run(self, *arguments, **options):
            found = super().run(*arguments, **options)
            if lost == "near":
                return replace(found, near=found.near[1:])
            return replace(found, **{lost: getattr(found, lost) - 1})

    monkeypatch.setattr(run, "MeshEngineScene", Skipping)
    close = skipping_scenes(None)[2]
    found = run._scene_problems(measure_scene(close, []))
    assert len(found) == 2
    assert all("mesh engine" in problem for problem in found)


def test_a_broad_phase_that_loses_a_pair_is_seen(monkeypatch):
    def losing(*arguments):
        for i, j in candidates(*arguments):
            yield i[1:], j[1:]

    candidates = software.candidates
    monkeypatch.setattr(software, "candidates", losing)
    found = run._scene_problems(measure_scene(skipping_scenes(None)[2], []))
    assert len(found) == 2
    assert all("broad phase" in problem for problem in found)


def test_scenes_without_real_meshes():
    assert [scene.name for scene in skipping_scenes(None)][:-1] == [scene.name for scene in scenes()]
    assert not any(scene.real for scene in skipping_scenes(None))


def test_the_whole_machine_is_every_two_of_its_solids():
    data = mesh_data()
    if data is None:
        pytest.skip("no folder of real meshes: $TRIAXIS_DATA or ../shared/data")
    machines = [scene for scene in skipping_scenes(data) if "whole machine" in scene.name]
    assert [len(scene.meetings) for scene in machines] == [15, 15]
    solids = [254, 110, 4756, 188, 44, 76]
    assert machines[0].pairs == (sum(solids) ** 2 - sum(count**2 for count in solids)) // 2
    assert all(len(a) >= len(b) for a, b in machines[0].meetings)


class Stand:
    """A package that answers from a list."""

    name, distribution, call, boxes_only = "stand", "stand-in", "stand.ask", False

    def __init__(self, answer, boxes_only=False, counted=None):
        self._answer, self.boxes_only, self._counted = answer, boxes_only, counted or Counted(7, 5)

    def version(self):
        return "1.0"

    def load(self, a, b):
        assert a.dtype == b.dtype == np.float64
        return Question(lambda: np.array(self._answer, np.int64).reshape(-1, 2), lambda: self._counted)


class Missing(Stand):
    def version(self):
        raise PeerAbsentError("stand-in: not installed")


def meeting(rng):
    return Meeting(block(rng, 5, 0, 2000), block(rng, 6, 0, 2000), np.array([[0, 1], [2, 3]]))


def test_answers_of_packages_are_compared_with_exact_ones(rng):
    stand = Stand([[2, 3], [4, 5], [4, 5]])
    found = ask_peer(stand, [meeting(rng), meeting(rng)])
    assert (found.found, found.missed, found.extra) == (4, 2, 2)
    assert (found.volumes, found.triangles) == (14, 10)
    assert not found.contradicts
    assert ask_peer(Stand([], counted=Counted()), [meeting(rng)]).volumes is None


def test_packages_that_compare_boxes_must_find_ours(rng):
    given = meeting(rng)
    exact = np.concatenate([np.stack(pairs, 1) for pairs in asking.candidates(given.a, given.b, 0)])
    assert len(exact)
    assert not ask_peer(Stand(exact, boxes_only=True), [given]).contradicts
    wrong = ask_peer(Stand(exact[1:], boxes_only=True), [given])
    assert wrong.contradicts and wrong.missed == 1


def test_absent_packages_say_so():
    missing = presence(Missing([]))
    assert missing.version is None and missing.why_absent == "stand-in: not installed"
    assert presence(Stand([])).version == "1.0"


@pytest.mark.parametrize("peer", MESH_PEERS, ids=lambda peer: peer.name)
def test_packages_answer_as_we_do(peer, rng):
    """Those that are installed: on integers, in general position."""
    found = presence(peer)
    if found.version is None:
        pytest.skip(f"{peer.name}: {found.why_absent}")
    a, b = SURFACES[0].make(400, rng)
    near = stage_answer(a, b, 0, CONFIGURATION).near
    assert len(near) > 100
    answer = ask_peer(peer, [Meeting(a, b, near)])
    assert (answer.missed, answer.extra) == (0, 0)
    assert answer.found == len(near) or peer.boxes_only


def points(costs, same: bool | None = True):
    return tuple(Point(10**k, cost, cost, round(cost), 1, 1, same, ()) for k, cost in enumerate(costs, 3))


def test_exponents():
    assert exponent([(10, 5), (100, 50), (1000, 500)]) == pytest.approx(1)
    assert exponent([(10, 5), (100, 500), (1000, 50_000)]) == pytest.approx(2)


def test_growth_is_judged():
    surfaces = SURFACES[0]
    assert Growth(surfaces, points([1e3, 1e4, 1e5, 1e6])).problems == []
    steep = Growth(surfaces, points([1e3, 1e5, 1e7, 1e9])).problems
    assert len(steep) == 2 and "comparisons" in steep[0] and "seconds" in steep[1]
    assert "near pairs" in Growth(surfaces, points([1e3], same=False)).problems[0]
    wrong = PeerRun("rtree", 1, 1, 1, 1, 0, None, None, True)
    contradicted = [replace(point, peers=(wrong,)) for point in points([1e3])]
    assert "misses 1" in Growth(surfaces, tuple(contradicted)).problems[0]


def test_growth_of_small_meshes(monkeypatch):
    """Patience ends: a slow package is asked about no larger meshes."""
    monkeypatch.setattr(growth, "_PATIENCE", -1.0)
    told: list[int] = []
    found = growths(1, [Stand([])], told.append, sizes=(200, 400))
    assert len(told) == len(SURFACES) * 2
    for measured in found:
        assert [len(point.peers) for point in measured.points] == [1, 0]
        assert all(point.same and point.near > 0 for point in measured.points)


@pytest.mark.parametrize("surfaces", SURFACES, ids=lambda surfaces: surfaces.name)
@pytest.mark.parametrize("size", [200, 5000])
def test_surfaces(surfaces, size):
    made = [surfaces.make(size, np.random.default_rng(3)) for _ in range(2)]
    for a, b in made:
        assert len(a) == len(b) == pytest.approx(size, rel=0.1)
        assert max(np.abs(a).max(), np.abs(b).max()) < 1 << 23
    assert all(np.array_equal(x, y) for x, y in zip(*made, strict=True))
    # Nothing is degenerate, and neighbours share edges: each inner edge belongs to two facets.
    a = made[0][0]
    assert np.any(np.cross(a[:, 1] - a[:, 0], a[:, 2] - a[:, 0]) != 0, axis=1).all()
    edges = np.sort(
        np.unique(a.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3)[
            :, [[0, 1], [1, 2], [2, 0]]
        ],
        2,
    )
    _, counts = np.unique(edges.reshape(-1, 2), axis=0, return_counts=True)
    assert counts.max() == 2 and (counts == 1).mean() < 2 / np.sqrt(size)


def test_the_command_writes_what_it_found(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(results, "RESULT", tmp_path / "skipping.json")
    monkeypatch.setattr("triaxis.host.cli.bench_costs.mesh_data", lambda: None)
    small = {"peers": [Stand([]), Missing([])], "sizes": (200, 400)}
    monkeypatch.setattr(
        "triaxis.host.cli.bench_costs.run_skipping",
        lambda seed, data, progress: run_skipping(seed, data, progress, **small),
    )
    assert main(["bench", "skipping"]) == 0
    printed = capsys.readouterr().out
    assert "absent: stand: stand-in: not installed" in printed and "PASSED" in printed
    written = json.loads((tmp_path / "skipping.json").read_text())
    assert written["passed"] and written["real_meshes"] is False
    assert len(written["scenes"]) == len(skipping_scenes(None))
    for scene in written["scenes"]:
        for at in scene["at_margins"]:
            assert sum(at["pairs_by_stage"].values()) == scene["pairs"]
    assert [package["why_absent"] for package in written["packages"]] == [None, "stand-in: not installed"]
    for suffix in ("png", "svg"):
        assert (tmp_path / f"skipping.{suffix}").stat().st_size > 10_000


def test_the_command_fails_where_a_bound_is_missed(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(results, "RESULT", tmp_path / "skipping.json")
    monkeypatch.setattr("triaxis.host.cli.bench_costs.mesh_data", lambda: None)
    monkeypatch.setattr(run, "LEAST_RATIO", 1e9)
    monkeypatch.setattr(run, "skipping_scenes", lambda data: skipping_scenes(data)[:1])
    monkeypatch.setattr(
        "triaxis.host.cli.bench_costs.run_skipping",
        lambda seed, data, progress: run_skipping(seed, data, progress, [], (200, 400)),
    )
    assert main(["bench", "skipping"]) == 1
    assert "PROBLEM scenes" in capsys.readouterr().out
    assert json.loads((tmp_path / "skipping.json").read_text())["passed"] is False


def test_a_bad_seed_is_an_error(capsys):
    assert main(["bench", "skipping", "--seed", "-1"]) == 2
    assert "must not be negative" in capsys.readouterr().err


def test_steps_are_those_of_the_run():
    told: list[int] = []
    run_skipping(1, None, told.append, [], (100, 200))
    assert sum(told) == steps(None, (100, 200))


def test_stages_that_do_not_add_up_are_seen(row):
    at = replace(row.at[0], stages=row.at[0].stages + Stages(boxes=1))
    assert "account for" in run._scene_problems(replace(row, at=(at,)))[0]
    slow = replace(row.at[0], cycles=10**9)
    assert "costs more" in run._scene_problems(replace(row, at=(slow,)))[0]


def test_several_meetings_are_summed(rng):
    a, b, c = block(rng, 60, 0), block(rng, 50, 1000), block(rng, 40, -1000)
    scene = SkippingScene("three", ((a, b), (a, c), (b, c)), 30)
    measured = measure_scene(scene, [])
    assert run._scene_problems(measured) == []
    assert measured.at[0].stages.pairs == 60 * 50 + 60 * 40 + 50 * 40
