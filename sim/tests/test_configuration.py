"""Configurations by name, with the latencies that are documented; the layout of their words."""

import re

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import NO_AXIS, VERDICT, coordinate_range
from triaxis.sim.board_parameters import BoardParameters, parse_board_configuration
from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.packing import data_bytes, pack_data, pack_user, unpack_data, unpack_user
from triaxis.sim.paths import DUT, ROOT
from triaxis.sim.result import decode, encode


def test_names_are_unique_and_parse():
    for configuration in (Configuration(), Configuration(32, 32, 1), Configuration(8, 0, 3, False, False)):
        assert parse_configuration(configuration.name) == configuration
    for name in ("", "w16", "w16_m", "w7_m0", "w33_m0", "w16_m17", "w16_m1_no_edge_box", "x"):
        with pytest.raises(InputError):
            parse_configuration(name)


def test_names_of_boards_parse():
    for name in (
        "board_w12_m5_d128_g8_l4",
        "board_w8_m0_d16_g4_l2_plain",
        "board_w16_m16_d64_g8_l8_plain_real",
    ):
        board = parse_board_configuration(name)
        assert board.name == name
        assert board.rtl["Certify"] == board.engine.certified == ("plain" not in name)
    for name in ("board_w12_m5_d128_g8", "board_w12_m5_d128_g8_l4_real_plain", "board_w12_m5_d128_g8_l4_x"):
        with pytest.raises(InputError, match="must read board_w"):
            parse_board_configuration(name)
    with pytest.raises(InputError, match="clocks per three bits 11: must be at least 12"):
        BoardParameters(clocks_per_three_bits=11)


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


@pytest.mark.parametrize("width", [8, 13, 16, 24, 31, 32])
def test_words_survive(rng, width):
    low, high = coordinate_range(width)
    pairs = rng.integers(low, high + 1, (50, 2, 3, 3))
    pairs[0], pairs[1] = low, high
    words = pack_data(pairs, width)
    assert max(words) < 1 << (8 * data_bytes(width))
    assert (unpack_data(words, width) == pairs).all()
    # A1 x lies lowest.
    assert words[0] & ((1 << width) - 1) == 1 << (width - 1)
    assert pack_data(pairs[:0], width) == []
    for configuration in (Configuration(width, 0), Configuration(width, width, 1)):
        margins = rng.integers(0, configuration.max_margin + 1, 30)
        tags = rng.integers(0, 1 << configuration.tag_bits, 30)
        found = unpack_user(pack_user(margins, tags, configuration), configuration)
        assert (found[0] == margins).all() and (found[1] == tags).all()


def test_results_survive():
    verdicts = np.zeros(64, VERDICT)
    verdicts["near"] = np.arange(64) >= 32
    verdicts["axis"] = np.where(verdicts["near"], NO_AXIS, np.arange(64) % 32)
    verdicts["coplanar"] = np.arange(64) % 2 == 1
    verdicts["degenerate_b"] = np.arange(64) % 3 == 1
    assert (decode(encode(verdicts)) == verdicts).all()
