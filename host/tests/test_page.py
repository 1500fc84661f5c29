"""The page that shows a machine while it is followed: what it serves, and what a browser makes of it."""

import json
import socket
import struct
import threading
import time
import urllib.error
import urllib.request
from contextlib import suppress
from itertools import pairwise

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.host import page as page_module
from triaxis.host.page import Page, line_of, mesh_of
from triaxis.host.scenes import scenes
from triaxis.host.tests.browser import CHROMIUM, Browser

pytest.importorskip("plotly", reason="plotly is not installed: the page is not tried")
ENDS = np.array([[0.0, 0, 30], [10, 0, 30], [10, 20, 30], [10, 20, 10]])


@pytest.fixture
def page():
    made = Page(0)
    scene = scenes()[0]
    made.show(scene.a, scene.b, ENDS, "tool along part.nc")
    return made


def clear(page, number, **changes):
    told = {"line": 5 + number, "hold": 60_000, "verdict": "clear", "lag": 2.5, "asked": number + 1}
    place = {"position": ENDS[number].tolist(), "permitted": number + 1}
    page.tell(**{**told, **place, **changes})


def states(page, count):
    """Return the next states that a browser is sent."""
    found = []
    with urllib.request.urlopen(page.address + "states") as events:
        while len(found) < count:
            line = events.readline()
            if line.startswith(b"data: "):
                found.append(json.loads(line[6:]))
    return found


def test_a_mesh_is_the_same_in_the_form_of_plotly():
    facets = scenes()[0].a
    made = mesh_of(facets)
    vertices = np.stack([made[c] for c in "xyz"], 1)
    assert len(vertices) < 3 * len(facets)
    numbers = np.stack([made[c] for c in "ijk"], 1)
    assert np.array_equal(vertices[numbers], facets.astype(np.float64))
    assert line_of(ENDS)["y"] == [0, 0, 20, 20]


def test_what_is_served(page):
    with urllib.request.urlopen(page.address) as answer:
        text = answer.read().decode()
        assert answer.headers["Content-Type"].startswith("text/html")
    # Nothing of another address.
    assert "http://" not in text and "https://" not in text
    with urllib.request.urlopen(page.address + "plotly.js") as answer:
        assert b"Plotly" in answer.read()
    with urllib.request.urlopen(page.address + "scene") as answer:
        scene = json.load(answer)
    assert scene["title"] == "tool along part.nc" and len(scene["path"]["x"]) == len(ENDS)
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(page.address + "etc/passwd")
    assert page.address.startswith("http://127.0.0.1:")
    # Another page, with a name of its own for this computer.
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(
            urllib.request.Request(page.address + "scene", headers={"Host": "evil.example"})
        )


@pytest.mark.long
def test_browsers_that_say_nothing_are_few_and_not_waited_for(page, monkeypatch, capfd):
    host, port = page.address.removeprefix("http://").strip("/").split(":")
    idle = [socket.create_connection((host, int(port))) for _ in range(40)]
    assert (
        sum(thread.name.startswith("Thread") and thread.is_alive() for thread in threading.enumerate()) < 40
    )
    # One that resets while it is sent something.
    idle[0].setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    idle[0].sendall(f"GET /plotly.js HTTP/1.1\r\nHost: {host}:{port}\r\n\r\n".encode())
    for one in idle:
        one.close()
    # They are gone: there is room again.
    for _ in range(100):
        with suppress(OSError), urllib.request.urlopen(page.address) as answer:
            assert answer.read()
            break
        time.sleep(0.1)
    else:
        raise AssertionError("nothing is served any more")
    assert capfd.readouterr().err == ""


def test_the_newest_state_is_sent_and_how_old_it_is(page, monkeypatch):
    monkeypatch.setattr(page_module, "_QUIET_SECONDS", 0.05)
    clear(page, 0)
    clear(page, 1)
    found = states(page, 3)
    assert [state["line"] for state in found] == [6] * 3 and found[0]["pieces"] == 3
    assert all(one["age"] <= other["age"] for one, other in pairwise(found))
    # A verdict is no younger for what is told beside it.
    page._since -= 10
    page.tell(zone="slow")
    assert states(page, 1)[0]["age"] >= 10_000


def test_the_last_news_is_sent_before_the_end(page, monkeypatch):
    """However soon after the one before; a browser that reads nothing is not waited for long."""
    monkeypatch.setattr(page_module, "_LEAST_SECONDS", 0.2)
    monkeypatch.setattr(page_module, "_LAST_SECONDS", 60)
    with urllib.request.urlopen(page.address + "states") as events:
        events.readline()
        clear(page, 0)
        page.tell(stopped="near: the tool and the vise")
        page._send_last()
        # What was sent waits to be read.
        events.fp.raw._sock.settimeout(0.05)
        found = []
        with suppress(TimeoutError):
            while line := events.readline():
                found += [json.loads(line[6:])["stopped"]] if line.startswith(b"data: ") else []
        assert found[-1] == "near: the tool and the vise"
    monkeypatch.setattr(page_module, "_LAST_SECONDS", 0.5)
    monkeypatch.setattr(page, "_sent", {0: -1})
    begun = time.monotonic()
    page._send_last()
    assert time.monotonic() - begun < 30


def test_what_cannot_be_served_is_told(page, monkeypatch):
    for port in (int(page.address.rsplit(":", 1)[1].strip("/")), 70_000):
        with pytest.raises(InputError, match=f"--page {port}: .*name another"):
            Page(port)

    def absent(_):
        raise ModuleNotFoundError

    monkeypatch.setattr(page_module, "import_module", absent)
    with pytest.raises(InputError, match="pip install plotly"):
        Page(0)


@pytest.mark.simulator
@pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed: no browser shows the page")
def test_a_browser_shows_go_stop_and_the_scene(page, tmp_path):
    browser = Browser(tmp_path, page.address)

    def text(name):
        return f"document.getElementById('{name}')?.textContent"

    try:
        browser.until(text("output"), "waiting")
        clear(page, 1)
        browser.until(text("output"), "GO")
        browser.until(text("position"), "10.000  0.000  30.000")
        browser.until(text("permitted"), "2 of 3")
        browser.until("document.getElementById('output').getAttribute('role')", "status")
        # The picture has come so far: the tool at that place, and two pieces of path.
        part = "document.getElementById('view').data"
        browser.until(f"{part}?.[3]?.x?.length", 3)
        lowest = f"Math.min(...{part}[1].z)"
        browser.until(lowest, float(scenes()[0].a[..., 2].min() + 30))
        clear(page, 2, verdict="near", permitted=2)
        browser.until(text("output"), "STOP")
        browser.until(text("why"), "what comes next is near")
        browser.until(f"{part}[1].color", "#b3363b")
        page.tell(verdict="clear", stopped="position '0 0': must be X Y Z")
        browser.until(text("why"), "position '0 0': must be X Y Z")
        assert browser.picture().startswith(b"\x89PNG")
        # What is not renewed has ended.
        page.tell(stopped=None, hold=1)
        browser.until(text("why"), "go has not been renewed")
        page.tell(hold=60_000)
        browser.until(text("output"), "GO")
    finally:
        browser.end()
