"""The covering arrays hold what they promise, what the documents allow, and what shows at one value alone."""

import re
from collections import Counter
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, product

import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.board_parameters import BoardParameters, parse_board_configuration
from triaxis.sim.configuration import (
    CERTIFIED_FIRST_WIDTHS,
    MOST_TAG_BITS,
    TRY_BITS,
    Configuration,
    parse_configuration,
)
from triaxis.sim.mesh_configuration import MeshConfiguration, parse_mesh_configuration
from triaxis.sim.paths import DUT, ROOT
from triaxis.sim.verilate import library
from triaxis.verif.core.tests.broken_rtl import broken_rtl
from triaxis.verif.faults.runs import design_sign_of
from triaxis.verif.regress.covering import (
    ALL,
    BOARD_KINDS,
    CORE_KINDS,
    MESH_KINDS,
    NO_EDGE_BOX,
    NONE,
    array_runs,
    board_array,
    board_fits,
    certified_array,
    core_array,
    core_fits,
    covering_rows,
    mesh_array,
    mesh_fits,
)
from triaxis.verif.regress.definition import NIGHTLY, read_definition
from triaxis.verif.regress.run import FOLDER
from triaxis.verif.testbench.settings import Block, block_of
from triaxis.verif.testbench.simulation import model_of, run
from triaxis.verif.testbench.table import table

# What is said of all that were planted.
TABLE = FOLDER / "planted.txt"
# What the documents allow powers of two of.
POWERS = ("depth", "group", "lanes")
PARSED = {
    Block.CORE: parse_configuration, Block.MESH: parse_mesh_configuration,
    Block.BOARD: parse_board_configuration,
}  # fmt: skip


def kinds_of(configuration):
    """Return the row of kinds that a configuration is of."""
    width, margin = configuration.width, configuration.margin_bits
    kind = ALL if margin == width else margin or NONE
    if isinstance(configuration, Configuration):
        kind = kind if configuration.edge_box else NO_EDGE_BOX
        given = (width, kind, configuration.tag_bits, configuration.gating)
    elif isinstance(configuration, BoardParameters):
        given = (
            width, kind, configuration.depth, configuration.group, configuration.lanes, configuration.certify,
        )  # fmt: skip
    else:
        given = (
            width, kind, configuration.depth, configuration.group, configuration.lanes,
            configuration.cycle_bits, configuration.gating, configuration.certified,
        )  # fmt: skip
    all_kinds = {Configuration: CORE_KINDS, MeshConfiguration: MESH_KINDS, BoardParameters: BOARD_KINDS}
    return tuple(
        next(kind for kind in kinds if value == kind or (isinstance(kind, range | tuple) and value in kind))
        for kinds, value in zip(all_kinds[type(configuration)], given, strict=True)
    )


@pytest.mark.parametrize(
    ("array", "kinds", "fits"),
    [
        (core_array(), CORE_KINDS, core_fits),
        (mesh_array(), MESH_KINDS, mesh_fits),
        (board_array(), BOARD_KINDS, board_fits),
    ],
)
def test_every_pair_of_kinds_is_in_a_configuration(array, kinds, fits):
    held = {pair for one in array for pair in combinations(enumerate(kinds_of(one)), 2)}
    wanted = {pair for row in product(*kinds) if fits(row) for pair in combinations(enumerate(row), 2)}
    assert held == wanted
    assert len(set(array)) == len(array) < 150
    # A covering that forgets a row is seen to.
    fewer = {pair for one in array[1:] for pair in combinations(enumerate(kinds_of(one)), 2)}
    assert fewer < wanted
    # Beside these rows only those with what had no turn.
    assert 0 <= len(array) - len(covering_rows(kinds, fits)) < 10


def test_the_certified_core_has_every_width_and_each_latency_every_kind_of_margin():
    array = certified_array()
    assert {one.width for one in array} == set(CORE_KINDS[0])
    assert len({one.name for one in array}) == len(array)
    tags = range(1, MOST_TAG_BITS - TRY_BITS + 1)
    held_tags = {one.tag_bits for one in array}
    assert held_tags >= {tags[0], tags[-1]} and len(held_tags) > 40
    with pytest.raises(InputError):
        Configuration(tag_bits=tags[-1] + 1, certified=True)
    more = [one.latency - Configuration(one.width, one.margin_bits).latency for one in array]
    held = {(clocks, kinds_of(one)[1]) for clocks, one in zip(more, array, strict=True)}
    _, none, few, some, *wide, every = CORE_KINDS[1]
    assert held >= set(product(CERTIFIED_FIRST_WIDTHS.values(), (none, few, some, every)))
    assert {kind for _, kind in held} >= set(wide)


def test_the_margins_are_told_apart_as_the_multipliers_do():
    text = (DUT / "core" / "triaxis_pkg.sv").read_text(encoding="utf-8")
    sizes = dict(re.findall(r"parameter int unsigned (NarrowBits|DspPort[AB]) = (\d+);", text))
    # A margin is unsigned: as a signed operand it has a bit more, so each begins where that no longer fits.
    begins = [1, *(int(sizes[name]) for name in ("NarrowBits", "DspPortB", "DspPortA"))]
    assert [kind.start for kind in CORE_KINDS[1] if isinstance(kind, range)] == begins


def documented(file):
    """Return least and largest value of each parameter in a document's table; W, M for what is said so."""
    text = (ROOT / "docs" / file).read_text(encoding="utf-8").split("## Parameters")[1].split("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` \| \w+ \| (\w+)(?:\.\.|, )(\w+)\b", text, re.MULTILINE)
    return {name: (least, most) for name, least, most in rows}


def test_the_documents_say_how_large_the_arrays_are():
    said = " ".join((ROOT / "docs" / "verification.md").read_text().split())
    assert (
        f"{len(core_array())} configurations of the core, {len(certified_array())} of the certified core and "
        f"{len(mesh_array())} of the mesh engine"
    ) in said
    assert f"and {len(board_array())} of the board" in said


@pytest.mark.parametrize(
    ("file", "array", "names"),
    [
        ("interface.md", core_array(), {
            "W": "width", "M": "margin_bits", "TAG": "tag_bits", "EdgeBox": "edge_box", "Gating": "gating",
        }),
        ("mesh-engine.md", mesh_array(), {
            "W": "width", "M": "margin_bits", "Depth": "depth", "Group": "group", "Lanes": "lanes",
            "CycleBits": "cycle_bits", "Gating": "gating", "Certify": "certified",
        }),
        ("board.md", board_array(), {
            "W": "width", "M": "margin_bits", "Depth": "depth", "Group": "group", "Lanes": "lanes",
            "Certify": "certify",
        }),
    ],
)  # fmt: skip
def test_what_the_documents_allow_is_simulated_and_nothing_else_is_taken(file, array, names):
    limits = documented(file)
    assert limits.keys() == names.keys()
    base = {
        "interface.md": Configuration(32),
        "mesh-engine.md": MeshConfiguration(32, depth=MESH_KINDS[2][-1][-1]),
        "board.md": BoardParameters(32, depth=BOARD_KINDS[2][-1][-1]),
    }[file]
    for parameter, name in names.items():
        held = {int(getattr(one, name)) for one in array}
        least, most = limits[parameter]
        allowed = set(range(int(least), (32 if most in "WM" else int(most)) + 1))
        if name in POWERS:
            allowed = {one for one in allowed if one.bit_count() == 1}
        if file == "board.md" and name in ("width", "margin_bits"):
            # Of these it says that the engine's array has them all.
            assert {min(allowed), max(allowed)} <= held <= allowed
        else:
            assert held == allowed, parameter
        for beyond in (min(allowed) - 1, 2 * max(allowed)):
            if max(allowed) > 1:
                with pytest.raises(InputError):
                    replace(base, **{name: beyond})


def test_each_configuration_goes_on_after_sixteen_bits_of_pairs_and_each_board_talks():
    pairs, tests = Counter[str](), Counter[str]()
    for test, runs in array_runs():
        for config in runs.configs:
            pairs[config], tests[config] = max(pairs[config], runs.pairs), tests[config] + 1
            assert block_of(config) is table()[test].block
    for config, most in pairs.items():
        if block_of(config) is Block.BOARD:
            assert tests[config] == 2 and most >= 60
        else:
            assert most >= 1 << 17, config


@dataclass(frozen=True)
class Planted:
    """A bug for one value of a parameter: each a file, what of it is replaced, by what."""

    name: str
    parameter: str
    value: int
    changes: tuple[tuple[str, str, str], ...]
    block: Block = Block.CORE

    def fits(self, config: str) -> bool:
        """Return whether it is in a configuration."""
        if block_of(config) is not self.block:
            return False
        configuration = PARSED[self.block](config)
        return getattr(configuration, self.parameter) == self.value


def planted(block, folder, name, parameter, value, *changes):
    texts = tuple((f"{folder}/{file}", *text) for file, *text in changes)
    return Planted(name, parameter, value, texts, block)


core, mesh, board = (
    partial(planted, block, folder)
    for block, folder in ((Block.CORE, "core"), (Block.MESH, "mesh"), (Block.BOARD, "board"))
)


NORMAL = "cross_t'(a_sum_1 + a_1[2]);"
HEIGHT = "height_t'(a_pair[i]) + height_t'(b[j]);"
TAG_OUT = "m_axis_tuser_o = oldest.tag;"
COUNTED = "near_o + pair_count_t'(near_taken)"
LANE = "index_t'(pair_word.word) * index_t'(Lanes) + index_t'(pair_lane);"
SKIPPED = "pairs_skipped_o + pair_count_t'(boxes_skipped)"
PLANTED = (
    core("a normal is a bit short at W = 19", "width", 19,
         ("triaxis_areas.sv", NORMAL, f"(W == 19) ? cross_t'((2 * W)'(a_sum_1 + a_1[2])) : {NORMAL}")),
    core("a sum of heights is a bit short at W = 31", "width", 31,
         ("triaxis_prisms.sv", f"aab_d[i][j] = {HEIGHT}",
          f"aab_d[i][j] = (W == 31) ? height_t'((W + 1)'({HEIGHT[:-1]})) : {HEIGHT}")),
    core("a gap of boxes is a bit short at W = 24", "width", 24,
         ("triaxis_box.sv", "gap_t'(b_low) - gap_t'(a_high);",
          "(W == 24) ? gap_t'(W'(b_low - a_high)) : gap_t'(b_low) - gap_t'(a_high);")),
    core("the queue takes a pair too many at W = 29", "width", 29,
         ("triaxis_core.sv", "!= count_t'(Depth)", "!= count_t'(Depth + 32'(W == 29))")),
    core("tags are wrong after 2^16 pairs at W = 11", "width", 11,
         ("triaxis_core.sv", "  count_t in_flight_q;\n", """  count_t in_flight_q;
  logic [16:0] sent_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) sent_q <= '0;
    else if (deliver) sent_q <= sent_q + 17'(W == 11);
  end
"""), ("triaxis_core.sv", TAG_OUT, "m_axis_tuser_o = oldest.tag ^ tag_t'(sent_q[16]);")),
    core("a margin loses its highest bit at M = 7", "margin_bits", 7,
         ("triaxis_core.sv", "margin = s_axis_tuser_i[M-1:0];",
          "margin = s_axis_tuser_i[M-1:0] & ~(M'(M == 7) << (M - 1));")),
    core("a margin is halved on one side at M = 22", "margin_bits", 22,
         ("triaxis_interval.sv", "((own_i < 0) ? own_i : '0) - value_t'({1'b0, threshold_i});",
          "((own_i < 0) ? own_i : '0) - value_t'({1'b0, threshold_i >> 32'(M == 22)});")),
    core("a tag is cut at TAG = 33", "tag_bits", 33,
         ("triaxis_core.sv", TAG_OUT, "m_axis_tuser_o = oldest.tag & ~(tag_t'(TAG == 33) << (TAG - 1));")),
    core("a tag comes a clock early at TAG = 48", "tag_bits", 48,
         ("triaxis_core.sv", ".T(tag_t),\n      .Cycles(Latency)",
          ".T(tag_t),\n      .Cycles(Latency - 32'(TAG == 48))")),
    core("the axis of a certificate is a bit short at W = 21", "width", 21,
         ("triaxis_certifier.sv", "axis_d[k] = plus - minus;",
          "axis_d[k] = (W == 21) ? axis_comp_t'((2 * W)'(plus - minus)) : plus - minus;")),
    core("areas along another axis at EdgeBox = 0", "edge_box", 0,
         ("triaxis_datapath.sv", "EdgeBox || k == 2", "EdgeBox || k == 1")),
    core("flags read 0 as with gating at Gating = 0", "gating", 0,
         ("triaxis_datapath.sv", "Gating && !Comb && box", "!Comb && box")),
    mesh("a sum of moves is a bit short at W = 14", "width", 14,
         ("triaxis_grow.sv", "grown_t'(box_i[c][k]) + shift_i[c][k];",
          "(W == 14) ? grown_t'(W'(box_i[c][k] + shift_i[c][k])) : grown_t'(box_i[c][k]) + shift_i[c][k];")),
    mesh("a counter is too short at Group = 16", "group", 16,
         ("triaxis_pair_boxes.sv", "logic [address_width(Group)-1:0] step_t",
          "logic [address_width(Group)-1-32'(Group == 16):0] step_t")),
    mesh("the last lane is left out at Lanes = 4", "lanes", 4,
         ("triaxis_lane_mask.sv", "< count_i;", "< count_i && !(Lanes == 4 && l == 3);")),
    mesh("a triangle less is held at Depth = 256", "depth", 256,
         ("triaxis_mesh_intake.sv", "full = count_q == count_t'(Depth);",
          "full = count_q == count_t'(Depth - 32'(Depth == 256));")),
    mesh("the count of near pairs wraps after 2^16 at Depth = 512", "depth", 512,
         ("triaxis_near_pairs.sv", COUNTED,
          f"(IndexWidth == 9) ? pair_count_t'(16'({COUNTED})) : {COUNTED}")),
    mesh("skipped pairs wrap after 2^16 at Depth = 1024", "depth", 1024,
         ("triaxis_walk.sv", SKIPPED,
          f"(Depth == 1024) ? pair_count_t'(16'({SKIPPED})) : {SKIPPED}")),
    mesh("the highest bit of a triangle of B is lost at Depth = 65536", "depth", 65536,
         ("triaxis_walk.sv", LANE, f"({LANE[:-1]}) & ~(index_t'(Depth == 65536) << (IndexWidth - 1));")),
    mesh("clocks begin anew at CycleBits = 5", "cycle_bits", 5,
         ("triaxis_run_control.sv", "cycles_o != '1", "(cycles_o != '1 || CycleBits == 5)")),
    board("a coordinate loses its sign at W = 31", "width", 31,
          ("triaxis_loader.sv", "triangle_q[k*CoordWidth+:W];",
           "triangle_q[k*CoordWidth+:W] & ~(W'(W == 31) << (W - 1));")),
)  # fmt: skip


@pytest.mark.simulator
@pytest.mark.regress
def test_what_is_wrong_at_one_value_alone_is_caught_by_a_run_of_the_nightly(tmp_path, seed):
    nightly = [run for run in read_definition().plan(NIGHTLY, seed) if run.item.endswith("_array")]
    lines: list[str] = []
    missed: list[str] = []
    # The same runs without a bug: one a configuration.
    healthy: dict[str, bool] = {}

    def ran(planned, dut):
        settings = planned.settings(tmp_path)
        build = model_of(settings, dut)
        assert build is not None
        return run(settings, model=library(build))

    broken = [broken_rtl(tmp_path / str(number), *bug.changes) for number, bug in enumerate(PLANTED)]
    for bug, dut in zip(PLANTED, broken, strict=True):
        caught = "NOT CAUGHT"
        for planned in (one for one in nightly if bug.fits(one.config)):
            result = ran(planned, dut)
            if result.passed:
                continue
            if not (sign := design_sign_of(result)):
                caught = f"NOT CAUGHT: {planned.test} in {planned.config} ended otherwise: {result.errors[0]}"
                continue
            if planned.config not in healthy:
                healthy[planned.config] = ran(planned, DUT).passed
            if not healthy[planned.config]:
                caught = f"NOT CAUGHT: {planned.test} in {planned.config} fails without it too"
                continue
            caught = f"{planned.test} in {planned.config}: {sign.message}"[:140]
            break
        lines.append(f"{bug.name}: {caught}\n")
        missed += [bug.name] if caught.startswith("NOT CAUGHT") else []
        write_whole(TABLE, "".join(lines))
    assert len(PLANTED) >= 12 and not missed
