"""What skipping saves: it is what the engine counts, and wrong answers are seen."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from triaxis.bench import harness
from triaxis.bench.peers import MESH_PEERS, native
from triaxis.bench.peers.peer import Peer, PeerAbsentError, Question, present
from triaxis.bench.skipping import report, run, software
from triaxis.bench.skipping.run import Stages, measure_scene, run_skipping
from triaxis.bench.skipping.scenes import SURFACES, SkippingScene, skipping_scenes
from triaxis.bench.skipping.software import Growth, GrowthPoint, Meeting, ask_peer, contradictions
from triaxis.golden.errors import InputError
from triaxis.host.cli import main


@pytest.fixture(autouse=True)
def quickly(monkeypatch):
    monkeypatch.setattr(harness, "_ALONE_ROUNDS", 1)


def block(rng, count, place, size=300):
    return rng.integers(-2000, 2001, (count, 1, 3)) + rng.integers(-size, size + 1, (count, 3, 3)) + place


@pytest.mark.long
@pytest.mark.simulator
def test_a_scene_in_hardware_and_software(rng):
    # Of several meetings, the sums.
    a, b, c = block(rng, 60, 0), block(rng, 50, 1000), block(rng, 40, -1000)
    row = measure_scene(SkippingScene("three", ((a, b), (a, c), (b, c)), 30), [])
    assert row.problems == [] and list(row.at) == [0, 30]
    assert row.plain.pairs_by_stage.pairs == 60 * 50 + 60 * 40 + 50 * 40
    assert all(0 < at.pairs_by_stage.tested < at.hardware.cycles_without_skipping for at in row.at.values())
    lost = replace(row.plain, pairs_by_stage=row.plain.pairs_by_stage + Stages(boxes=1))
    assert "account for" in replace(row, at={0: lost}).problems[0]
    slow = replace(row.plain, hardware=replace(row.plain.hardware, cycles=10**9))
    assert "costs more" in replace(row, at={0: slow}).problems[0]


@pytest.mark.long
@pytest.mark.simulator
@pytest.mark.parametrize("lost", ["near", "tested", "broad phase"])
def test_what_skips_too_much_is_seen(monkeypatch, lost):
    class Skipping(run.MeshEngineScene):
        def run(self, *arguments, **options):
            found = super().run(*arguments, **options)
            if lost == "near":
                return replace(found, near=found.near[1:])
            return replace(found, **{lost: getattr(found, lost) - 1})

    def losing(*arguments):
        return ((i[1:], j[1:]) for i, j in candidates(*arguments))

    candidates = software.candidates
    if lost == "broad phase":
        monkeypatch.setattr(software, "candidates", losing)
    else:
        monkeypatch.setattr(run, "MeshEngineScene", Skipping)
    found = measure_scene(skipping_scenes(None)[2], []).problems
    told = lost if lost == "broad phase" else "mesh engine"
    assert len(found) == 2 and all(told in problem for problem in found)


def stand(answer, boxes_only=False):
    """Return a package that answers from a list."""
    found = np.array(answer, np.int64).reshape(-1, 2)
    question = Question(lambda: found, lambda: (7, 5))
    return Peer("stand", "stand-in", "stand.ask", lambda: "1.0", lambda *_: question, boxes_only=boxes_only)


@pytest.mark.parametrize("found", [7000, -1])
def test_fcl_is_asked_once_however_much_it_finds(rng, monkeypatch, found):
    asked = []
    library = SimpleNamespace(
        triaxis_load=lambda *_: 0,
        triaxis_free=lambda *_: None,
        triaxis_ask=lambda *_: asked.append(1) or found,
    )
    monkeypatch.setattr(native, "_fcl", lambda: library)
    question = native.FCL_TREES[0].load(*rng.random((2, 3, 3, 3)))
    if found < 0:
        with pytest.raises(InputError, match="FCL OBB: -1 pairs"):
            question.ask()
    else:
        assert question.ask().shape == (found, 2) and len(asked) == 1


def test_packages_find_all_that_there_is():
    """Where `make peers` has installed them: also more than trimesh ends with by itself."""
    flat, through = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0]]), np.array([[1, 1, -3], [1, 1, 3], [3, 5, 3]])
    a, b = (np.repeat(facet[None].astype(float), 400, 0) for facet in (flat, through))
    for peer, _ in present(MESH_PEERS)[0]:
        assert len(np.unique(peer.load(a, b).ask(), axis=0)) == 400**2, peer.name


def missing():
    raise PeerAbsentError("stand-in: not installed")


def test_answers_of_packages_are_compared_with_exact_ones(rng):
    given = Meeting(block(rng, 5, 0, 2000), block(rng, 6, 0, 2000), np.array([[0, 1], [2, 3]]))
    found = ask_peer(stand([[2, 3], [4, 5], [4, 5]]), [given, given])
    assert (found.found, found.missed, found.extra) == (4, 2, 2)
    assert (found.volumes_compared, found.triangles_compared) == (14, 10)
    # Those that compare boxes must find ours.
    exact = np.concatenate([np.stack(pairs, 1) for pairs in software.candidates(given.a, given.b, 0)])
    assert len(exact) and contradictions("", [ask_peer(stand(exact, boxes_only=True), [given]), found]) == []
    assert "misses 1" in contradictions("", [ask_peer(stand(exact[1:], boxes_only=True), [given])])[0]


def test_growth_is_judged():
    def problems(*costs, same=True):
        points = (
            GrowthPoint(10**k, cost, cost, round(cost), 1, 1, same, ()) for k, cost in enumerate(costs, 3)
        )
        return Growth(SURFACES[0], tuple(points)).problems

    assert problems(1e3, 1e4, 1e5, 1e6) == []
    (steep,) = problems(1e3, 1e5, 1e7, 1e9)
    assert "comparisons" in steep
    assert "near pairs" in problems(1e3, same=False)[0]


@pytest.mark.long
@pytest.mark.simulator
def test_the_command_writes_what_it_found(tmp_path, monkeypatch, capsys):
    absent = replace(stand([]), version=missing)
    result = run_skipping(1, None, lambda _: None, [stand([]), absent], (200, 400))
    monkeypatch.setattr(harness, "FOLDER", tmp_path)
    monkeypatch.setattr(report, "run_skipping", lambda *_: result)
    assert main(["bench", "skipping"]) == 0
    printed = capsys.readouterr().out
    assert "absent: stand: stand-in: not installed" in printed and "PASSED" in printed
    written = json.loads((tmp_path / "skipping.json").read_text())
    assert written["passed"] and len(written["scenes"]) == len(skipping_scenes(None))
    for scene in written["scenes"]:
        assert all(sum(at["pairs_by_stage"].values()) == scene["pairs"] for at in scene["at_margins"])
    assert all((tmp_path / f"skipping.{suffix}").stat().st_size > 10_000 for suffix in ("png", "svg"))
    monkeypatch.setattr(run, "LEAST_RATIO", 1e9)
    assert main(["bench", "skipping"]) == 1
    assert json.loads((tmp_path / "skipping.json").read_text())["passed"] is False
