import re

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.paths import DUT, ROOT


@pytest.mark.parametrize(
    "configuration",
    [
        Configuration(),
        Configuration(32, 32, 1),
        Configuration(16, 0, edge_box=False),
        Configuration(8, 0, 3, edge_box=False, gating=False),
    ],
)
def test_names_are_unique_and_parse(configuration):
    assert parse_configuration(configuration.name) == configuration


@pytest.mark.parametrize(
    "name", ["", "w16", "w16_m", "w7_m0", "w33_m0", "w16_m17", "w16_m1_no_edge_box", "x"]
)
def test_bad_names(name):
    with pytest.raises(InputError):
        parse_configuration(name)


def test_the_queue_is_that_of_the_rtl():
    # The environment allows so many pairs to be lost at a reset: neither more nor fewer than the core holds.
    depth = "localparam int unsigned Depth = 2 ** $clog2(core_latency(W, M));"
    assert (DUT / "core" / "triaxis_core.sv").read_text(encoding="utf-8").count(depth) == 1
    builds = [Configuration(width, margin) for width in (8, 16, 24, 32) for margin in (0, width)]
    assert all(build.queue_depth / 2 < build.latency <= build.queue_depth for build in builds)


def test_the_documented_latencies_are_those_that_the_rtl_is_held_against():
    text = (ROOT / "docs" / "interface.md").read_text(encoding="utf-8")
    section = text.split("## Latency")[1].split("\n## ")[0]
    rows = re.findall(r"^\| *(\d+) *\| *(\d+) *\| *(\d+) *\| *(\d+) *\|$", section, re.MULTILINE)
    found = [tuple(map(int, row)) for row in rows]
    widths = (8, 16, 24, 32)
    assert found == [(w, *(Configuration(w, m).latency for m in (0, 8, w))) for w in widths]
