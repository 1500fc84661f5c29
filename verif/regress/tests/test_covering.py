"""The covering arrays hold what they promise, what the documents allow, and what shows at one value alone."""

import re
from dataclasses import dataclass, replace
from itertools import combinations, product

import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.mesh_configuration import MeshConfiguration, is_mesh_configuration, parse_mesh_configuration
from triaxis.sim.paths import ROOT
from triaxis.sim.verilate import LIGHT, library
from triaxis.verif.core.tests.broken_rtl import broken_rtl
from triaxis.verif.regress.covering import (
    ALL,
    CORE_KINDS,
    MESH_KINDS,
    NO_EDGE_BOX,
    NONE,
    SOME,
    array_runs,
    core_array,
    covering_rows,
    mesh_array,
    mesh_fits,
)
from triaxis.verif.regress.definition import NIGHTLY, read_definition
from triaxis.verif.regress.run import FOLDER
from triaxis.verif.testbench.simulation import model_of, run

# What is said of all that were planted.
TABLE = FOLDER / "planted.txt"


def kinds_of(configuration):
    """Return the row of kinds that a configuration is of."""
    width, margin = configuration.width, configuration.margin_bits
    kind = ALL if margin == width else SOME if margin else NONE
    if isinstance(configuration, Configuration):
        kind = kind if configuration.edge_box else NO_EDGE_BOX
        given = (width, kind, configuration.tag_bits, configuration.gating)
    else:
        given = (
            width, kind, configuration.depth, configuration.group, configuration.lanes,
            configuration.cycle_bits, configuration.gating,
        )  # fmt: skip
    all_kinds = CORE_KINDS if isinstance(configuration, Configuration) else MESH_KINDS
    return tuple(
        next(kind for kind in kinds if value == kind or (isinstance(kind, range | tuple) and value in kind))
        for kinds, value in zip(all_kinds, given, strict=True)
    )


@pytest.mark.parametrize(
    ("array", "kinds", "fits"),
    [(core_array(), CORE_KINDS, lambda _: True), (mesh_array(), MESH_KINDS, mesh_fits)],
)
def test_every_pair_of_kinds_is_in_a_configuration(array, kinds, fits):
    held = {pair for one in array for pair in combinations(enumerate(kinds_of(one)), 2)}
    wanted = {pair for row in product(*kinds) if fits(row) for pair in combinations(enumerate(row), 2)}
    assert held == wanted
    assert len(set(array)) == len(array) < 110
    # A covering that forgets a row is seen to.
    fewer = {pair for one in array[1:] for pair in combinations(enumerate(kinds_of(one)), 2)}
    assert fewer < wanted
    assert len(covering_rows(kinds, fits)) == len(array)


def documented(file):
    """Return least and largest value of each parameter in a document's table; W, M for what is said so."""
    text = (ROOT / "docs" / file).read_text(encoding="utf-8").split("## Parameters")[1].split("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` \| \w+ \| (\w+)(?:\.\.|, )(\w+)\b", text, re.MULTILINE)
    return {name: (least, most) for name, least, most in rows}


@pytest.mark.parametrize(
    ("file", "array", "names"),
    [
        ("interface.md", core_array(), {
            "W": "width", "M": "margin_bits", "TAG": "tag_bits", "EdgeBox": "edge_box", "Gating": "gating",
        }),
        ("mesh-engine.md", mesh_array(), {
            "W": "width", "M": "margin_bits", "Depth": "depth", "Group": "group", "Lanes": "lanes",
            "CycleBits": "cycle_bits", "Gating": "gating",
        }),
    ],
)  # fmt: skip
def test_what_the_documents_allow_is_simulated_and_nothing_else_is_taken(file, array, names):
    limits = documented(file)
    assert limits.keys() == names.keys()
    for parameter, name in names.items():
        held = [int(getattr(one, name)) for one in array]
        least, most = limits[parameter]
        most = 32 if most == "W" else int(most)
        assert (min(held), max(held)) == (int(least), most), parameter
        base = (
            Configuration(32)
            if file == "interface.md"
            else MeshConfiguration(32, depth=MESH_KINDS[2][-1][-1])
        )
        for beyond in (int(least) - 1, 2 * most):
            if most > 1:
                with pytest.raises(InputError):
                    replace(base, **{name: beyond})
    core = core_array()
    assert {one.width for one in array} == set(CORE_KINDS[0])
    assert {one.margin_bits for one in core} == set(range(33))
    assert {one.tag_bits for one in core} == set(range(1, 65))
    assert {one.depth for one in mesh_array()} == {1 << n for n in range(1, 17)}


def test_each_run_goes_on_after_sixteen_bits_of_pairs():
    for _, runs in array_runs():
        engine = parse_mesh_configuration(runs.configs[0]) if is_mesh_configuration(runs.configs[0]) else None
        assert runs.pairs >= (1 << 17 if engine is None or engine.depth > 256 else 400 * engine.depth)


@dataclass(frozen=True)
class Planted:
    """A bug for one value of a parameter: each a file, what of it is replaced, by what."""

    name: str
    parameter: str
    value: int
    changes: tuple[tuple[str, str, str], ...]
    of_mesh: bool = False

    def fits(self, config: str) -> bool:
        """Return whether it is in a configuration."""
        if is_mesh_configuration(config) != self.of_mesh:
            return False
        configuration = parse_mesh_configuration(config) if self.of_mesh else parse_configuration(config)
        return getattr(configuration, self.parameter) == self.value


def core(name, parameter, value, *changes):
    return Planted(name, parameter, value, tuple((f"core/{file}", *text) for file, *text in changes))


def mesh(name, parameter, value, *changes):
    return Planted(name, parameter, value, tuple((f"mesh/{file}", *text) for file, *text in changes), True)


NORMAL = "cross_t'(a_sum_1 + a_1[2]);"
HEIGHT = "height_t'(a_pair[i]) + height_t'(b[j]);"
TAG_OUT = "m_axis_tuser_o = oldest.tag;"
COUNTED = "near_o + pair_count_t'(near_taken)"
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
         ("triaxis_mesh_store.sv", "full = count_q == count_t'(Depth);",
          "full = count_q == count_t'(Depth - 32'(Depth == 256));")),
    mesh("the count of near pairs wraps after 2^16 at Depth = 512", "depth", 512,
         ("triaxis_near_pairs.sv", COUNTED,
          f"(IndexWidth == 9) ? pair_count_t'(16'({COUNTED})) : {COUNTED}")),
    mesh("skipped pairs wrap after 2^16 at Depth = 1024", "depth", 1024,
         ("triaxis_mesh.sv", SKIPPED,
          f"(Depth == 1024) ? pair_count_t'(16'({SKIPPED})) : {SKIPPED}")),
    mesh("clocks begin anew at CycleBits = 5", "cycle_bits", 5,
         ("triaxis_run_control.sv", "cycles_o != '1", "(cycles_o != '1 || CycleBits == 5)")),
)  # fmt: skip


@pytest.mark.simulator
@pytest.mark.regress
def test_what_is_wrong_at_one_value_alone_is_caught_by_a_run_of_the_nightly(tmp_path, seed):
    nightly = [run for run in read_definition().plan(NIGHTLY, seed) if run.item.endswith("_array")]
    lines: list[str] = []
    missed: list[str] = []
    broken = [broken_rtl(tmp_path / str(number), *bug.changes) for number, bug in enumerate(PLANTED)]
    for bug, dut in zip(PLANTED, broken, strict=True):
        caught = ""
        for planned in (one for one in nightly if bug.fits(one.config)):
            settings = planned.settings(tmp_path)
            build = model_of(settings, dut)
            assert build is not None
            result = run(settings, model=library(replace(build, speed=LIGHT)))
            if not result.passed:
                said = result.errors[0]
                caught = f"{planned.test} in {planned.config}: {said.partition(']: ')[2] or said}"[:140]
                break
        lines.append(f"{bug.name}: {caught or 'NOT CAUGHT'}\n")
        missed += [] if caught else [bug.name]
        write_whole(TABLE, "".join(lines))
    assert len(PLANTED) >= 12 and not missed
