"""What all benchmarks are run with: the timer, steps that survive an interruption, other packages."""

import time

import numpy as np
import pytest

from triaxis.bench.harness import StoredSteps, best_times, clocked
from triaxis.bench.mesh_cycles import CONFIGURATION
from triaxis.bench.peers import MESH_PEERS, TRIANGLE_PEERS
from triaxis.bench.peers.peer import PeerAbsentError, imported, installed_version, presence, present
from triaxis.bench.skipping.scenes import SURFACES
from triaxis.bench.skipping.software import Meeting, ask_peer
from triaxis.bench.skipping.stages import stage_answer


def test_times_are_those_of_the_processor():
    def busy():
        end = time.process_time() + 0.01
        while time.process_time() < end:
            pass

    working, waiting = best_times([busy, lambda: time.sleep(0.02)], 2)
    assert working >= 0.01 > 0.005 > waiting
    result, seconds = clocked(lambda: (busy(), "made")[1])
    assert result == "made" and seconds >= 0.01


def test_an_interrupted_measurement_goes_on(tmp_path):
    made, told = [], []

    def step(name, fails=False):
        def make():
            if fails:
                raise KeyboardInterrupt
            made.append(name)
            return {"value": name}

        return make

    first = StoredSteps(tmp_path / "steps", "key", told.append)
    assert first.once("a", step("a")) == {"value": "a"}
    with pytest.raises(KeyboardInterrupt):
        first.once("b", step("b", fails=True))
    second = StoredSteps(tmp_path / "steps", "key", told.append)
    assert second.once("a", step("a")) == {"value": "a"} and second.taken_up == 1
    assert second.once("b", step("b")) == {"value": "b"}
    # Of another state of things, or damaged: made again.
    StoredSteps(tmp_path / "steps", "other key", told.append).once("a", step("a"))
    (tmp_path / "steps" / "b.json").write_text("{")
    StoredSteps(tmp_path / "steps", "key", told.append).once("b", step("b"))
    assert made == ["a", "b", "a", "b"] and sum(told) == 5
    second.finish()
    assert not (tmp_path / "steps").exists()


def test_absent_packages_say_so(monkeypatch):
    with pytest.raises(PeerAbsentError, match="no_such_package: not installed: `make peers` installs it"):
        imported("no_such_package")
    with pytest.raises(PeerAbsentError, match="no-such-distribution: not installed"):
        installed_version("no-such-distribution", "json")

    def broken(_):
        raise OSError("libGL.so.1: cannot open shared object file")

    monkeypatch.setattr("triaxis.bench.peers.peer.import_module", broken)
    there, told = present(TRIANGLE_PEERS)
    assert {peer.distribution for peer, _ in there} <= {"libcgal-dev"}
    reasons = {each.name: each.why_absent for each in told}
    assert len(reasons) == len(TRIANGLE_PEERS)
    assert "open3d: installed, but does not start: libGL.so.1" in (reasons["Open3D"] or "")


@pytest.mark.parametrize("peer", TRIANGLE_PEERS, ids=lambda peer: peer.name)
def test_packages_tell_far_from_piercing(peer):
    found = presence(peer)
    if found.version is None:
        pytest.skip(f"{peer.name}: {found.why_absent}")
    a = np.array([[[0, 0, 0], [4, 0, 0], [0, 4, 0]]] * 2, np.float32)
    b = np.array([[[1, 1, -1], [1, 1, 1], [2, 1, 1]], [[9, 9, 9], [9, 9, 8], [9, 8, 8]]], np.float32)
    assert peer.load(a, b)().tolist() == [True, False]


@pytest.mark.parametrize("peer", MESH_PEERS, ids=lambda peer: peer.name)
def test_packages_find_the_facets_that_we_find(peer, rng):
    """On integers, in general position."""
    found = presence(peer)
    if found.version is None:
        pytest.skip(f"{peer.name}: {found.why_absent}")
    a, b = SURFACES[0].make(400, rng)
    near = stage_answer(a, b, 0, CONFIGURATION).near
    assert len(near) > 100
    answer = ask_peer(peer, [Meeting(a, b, near)])
    assert (answer.missed, answer.extra) == (0, 0)
    assert answer.found == len(near) or peer.boxes_only
