"""The generator of mutants: each operator, the names, the build that holds all of them."""

import re
from dataclasses import replace

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.build import rtl_files
from triaxis.sim.paths import DUT
from triaxis.verif.mutation.catalogue import catalogue, mutant_names
from triaxis.verif.mutation.elaboration import elaboration_mutants
from triaxis.verif.mutation.mutant import ELABORATION, RUNTIME, Edit
from triaxis.verif.mutation.schema import mutated
from triaxis.verif.mutation.statements import hosts
from triaxis.verif.mutation.syntax import read_source
from triaxis.verif.mutation.targets import BOARD, right_package
from triaxis.verif.testbench.settings import Block
from triaxis.verif.testbench.table import names_of

pytest.importorskip("pyslang", reason="mutants need pyslang: make setup")

HEAD = """module snippet (
    input logic clk_i,
    input logic signed [7:0] a_i[3],
    input logic signed [7:0] b_i[3],
    input logic go_i,
    input logic hold_i,
    output logic signed [8:0] x_o,
    output logic y_o
);
  typedef logic signed [8:0] wide_t;
  logic signed [8:0] p_q, q_q;
"""
STATES = "typedef enum logic [1:0] {Idle, Busy, Done} state_e; state_e state_q;"


def parsed(tmp_path, body):
    path = tmp_path / "snippet.sv"
    path.write_text(f"{HEAD}{body}\nendmodule\n")
    return read_source(path, tmp_path)


def runtime(tmp_path, body, ports=None):
    """Return the operators with the changed statements of a module's body."""
    source = parsed(tmp_path, body)
    found = [mutant for host in hosts(source, ports or {}) for mutant in host.mutants]
    return {(mutant.operator, mutant.changed) for mutant in found}


@pytest.mark.parametrize(
    ("body", "operator", "changed"),
    [
        ("assign x_o = p_q + q_q;", "arithmetic", "x_o = p_q - q_q"),
        ("assign x_o = p_q - q_q;", "operand", "x_o = q_q - p_q"),
        ("assign y_o = p_q < q_q;", "relational", "y_o = p_q <= q_q"),
        ("assign y_o = p_q == q_q;", "equality", "y_o = p_q != q_q"),
        ("assign y_o = go_i && hold_i;", "logical", "y_o = go_i || hold_i"),
        ("assign y_o = go_i & hold_i;", "bitwise", "y_o = go_i | hold_i"),
        ("assign y_o = !go_i;", "unary", "y_o = (go_i)"),
        ("assign x_o = go_i ? p_q : q_q;", "condition", "x_o = !(go_i) ? p_q : q_q"),
        ("assign x_o = p_q + 9'd3;", "constant", "x_o = p_q + 9'd4"),
        ("assign x_o = a_i[1];", "index", "x_o = a_i[next(1)]"),
        ("assign x_o = a_i[1];", "identifier", "x_o = b_i[1]"),
        ("assign x_o = p_q;", "stuck", "x_o = '0"),
        ("assign x_o = p_q[7:0];", "range", "x_o = (p_q[7:0] >> 1)"),
        ("assign x_o = p_q <<< 2;", "shift", "x_o = p_q >>> 2"),
        ("assign x_o = {go_i, hold_i};", "concatenation", "x_o = {hold_i, go_i}"),
        ("assign x_o = wide_t'(a_i[0]);", "cast", "x_o = wide_t'({a_i[0]})"),
        ("assign x_o = wide_t'(a_i[0]);", "cast", "x_o = wide_t'($signed({(a_i[0]) <<< 1}) >>> 1)"),
        ("always_ff @(posedge clk_i) if (go_i) p_q <= q_q;", "condition", "if (!(go_i))"),
        ("always_ff @(posedge clk_i) if (go_i) p_q <= q_q;", "deletion", ";"),
        ("always_comb for (int i = 3; i >= 0; i--) y_o = go_i;", "relational", "for (int i = 3; i > 0"),
        (f"{STATES} assign y_o = state_q == Idle;", "identifier", "y_o = state_q == Busy"),
        (
            f"{STATES} assign y_o = state_q inside {{Idle, Busy}};",
            "identifier",
            "y_o = state_q inside {Idle, Done}",
        ),
        (
            "assign x_o = wide_t'($countones(a_i[0] & b_i[0]));",
            "bitwise",
            "x_o = wide_t'($countones(a_i[0] | b_i[0]))",
        ),
        ("  `TRIAXIS_STAGE(p_q, q_q)", "bypass", "p_q = q_q"),
        ("  `TRIAXIS_STAGE(p_q, q_q)", "late", "p_q one clock later"),
        ("  `TRIAXIS_STAGE(p_q, q_q)", "stuck", "p_q = 0"),
    ],
)  # fmt: skip
def test_operator(tmp_path, body, operator, changed):
    assert (operator, changed) in runtime(tmp_path, body)


def test_inputs_of_instances_are_mutated_and_outputs_and_clocks_are_not(tmp_path):
    ports = {"other": frozenset({"clk_i", "go_i", "v_i"})}
    found = runtime(tmp_path, "other u (.clk_i, .go_i, .v_i(a_i[0]), .w_o(x_o));", ports)
    assert ("identifier", ".go_i(hold_i)") in found
    assert ("stuck", ".v_i('0)") in found
    assert ("index", ".v_i(a_i[next(0)])") in found
    assert not any("clk_i" in text or "w_o" in text for _, text in found)


@pytest.mark.parametrize(
    ("body", "unwanted"),
    [
        # Casts to unsigned of what is, and of numbers of bits or that are known.
        ("assign x_o = wide_t'(u_q);", r"\(\{u_q\}\)"),
        ("assign x_o = p_q + wide_t'($countones(u_q));", r"\(\{\$countones.*\}\)|countones.*<<< 1"),
        ("assign x_o = p_q + wide_t'(Depth - 1);", r"\(\{Depth - 1\}\)|Depth.*<<< 1"),
        ("assign x_o = wide_t'({1'b0, p_q[7:0]});", "^cast "),
        # The next element of an array of one; what nothing reads.
        ("logic one[1]; assign y_o = one[0];", r"next\(0\)"),
        ("logic unused; assign unused = ^p_q;", "^unary "),
        # Defaults, without which there would be a latch: of two assignments one is deleted.
        ("always_comb begin x_o = p_q; if (go_i) x_o = q_q; end", "$^"),
        # A loop that would not end.
        ("always_comb begin y_o = '0; for (int i = 0; i >= 0; i--) if (go_i) y_o = u_q[i]; end", "i <= 0"),
    ],
)
def test_what_changes_nothing_or_never_ends_is_not_generated(tmp_path, body, unwanted):
    found = runtime(tmp_path, f"localparam int Depth = 4; logic [7:0] u_q; {body}")
    assert [changed for operator, changed in found if re.search(unwanted, f"{operator} {changed}")] == []
    assert sum(operator == "deletion" for operator, _ in found) == body.startswith("always_comb")


@pytest.mark.parametrize(
    ("body", "operator", "changed"),
    [
        ("if (2 > 1) begin : g_a end", "generate_condition", "if (!(2 > 1))"),
        ("for (genvar k = 0; k < 3; k++) begin : g_k assign x_o = p_q; end", "generate_loop", "k < 3 - 1"),
        ("localparam int unsigned Delay = 3;", "constant", "Delay = (3) + 1;"),
        ("localparam int unsigned XWidth = 3;", "constant", "XWidth = (3) - 1;"),
        ("localparam int unsigned K1 = (k + 1) % 3;", "constant", "K1 = (k + 1 + 1) % 3;"),
        ("typedef logic [7:0] byte_t;", "type", "typedef logic [7 - 1:0] byte_t;"),
        ("other #(.Comb(1'b0), .Cycles(2)) u (.clk_i);", "parameter", ".Comb(!(1'b0))"),
        ("other #(.Comb(1'b0), .Cycles(2)) u (.clk_i);", "parameter", ".Cycles((2) + 1)"),
    ],
)
def test_elaboration_operator(tmp_path, body, operator, changed):
    found = {(m.operator, m.changed) for m in elaboration_mutants(parsed(tmp_path, body))}
    assert any(name == operator and text.endswith(changed) for name, text in found)
    # A width does not grow.
    assert "XWidth" not in body or not any("+ 1" in text for _, text in found)


def test_names_survive_unrelated_edits(tmp_path):
    body = "assign x_o = p_q + q_q;\nassign y_o = p_q < q_q;"
    before = {m.id for host in hosts(parsed(tmp_path, body), {}) for m in host.mutants}
    other = f"// Something else.\nlogic more;\nassign more = go_i;\n\n{body}"
    after = {m.id for host in hosts(parsed(tmp_path, other), {}) for m in host.mutants}
    assert before < after
    assert all(re.fullmatch(r"snippet/\w+/[0-9a-f]{8}", name) for name in after)


@pytest.mark.long
def test_every_file_of_dut_has_mutants_and_every_name_is_its_own():
    names = mutant_names()
    assert names == mutant_names()
    assert len(names) == len(set(names)) > 1500
    found = catalogue()
    files = {mutant.file for mutant in found.mutants}
    assert files == {path.relative_to(DUT).as_posix() for path in rtl_files() if path.suffix != ".f"}
    assert {mutant.kind for mutant in found.mutants} == {RUNTIME, ELABORATION}


def test_every_test_of_the_board_looks_for_its_mutants():
    """All but the one that does no more than fill its meshes."""
    played = {settings.test for settings in BOARD.tests(1)}
    assert played | {"BoardDepthTest"} == set(names_of(Block.BOARD))


def test_a_mutant_that_is_no_systemverilog_is_the_generators_fault():
    mutant = next(m for m in catalogue().mutants if m.operator == "arithmetic")
    broken = replace(mutant, edit=Edit(mutant.edit.start, mutant.edit.end, "a +* ;"))
    with pytest.raises(InputError, match="does not parse"), mutated(DUT, broken):
        pass


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        ("core/triaxis_pkg.sv", "BoxLatency = 4", "BoxLatency = 5"),
        ("board/triaxis_board_pkg.sv", "ClocksPerMs = 100_000", "ClocksPerMs = 100_001"),
        ("board/triaxis_board_pkg.sv", "ClocksPerMs = 100_000", "ClocksPerMs = 99_999"),
    ],
)
def test_a_package_that_gives_a_wrong_latency_or_time_is_found(tmp_path, file, right, wrong):
    assert right_package(DUT, file)
    text, copy = (DUT / file).read_text(), tmp_path / file
    assert right in text
    copy.parent.mkdir()
    copy.write_text(text.replace(right, wrong))
    assert not right_package(tmp_path, file)
    # What gives none at all is for others to find.
    copy.write_text(f"package {copy.stem}; endpackage")
    assert right_package(tmp_path, file)


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        # A table, filled once: before any mutant of it could be selected.
        (
            "for (genvar i = 0; i < 4; i++) always_comb if (i > 2) t[i] = i + 1; else t[i] = Most;",
            ELABORATION,
        ),
        ("for (genvar i = 0; i < 4; i++) always_comb if (go_i) t[i] = i + 1; else t[i] = Most;", RUNTIME),
        ("always_comb begin p = 9'd3; q = p + 9'd1; end", ELABORATION),
        ("always_ff @(posedge clk_i) p_q <= 9'd3;", RUNTIME),
    ],
)
def test_what_is_computed_once_needs_a_build_of_its_own(tmp_path, body, wanted):
    source = parsed(tmp_path, f"localparam int Most = 9; int t[4]; logic [8:0] p, q; {body}")
    mutants = [mutant for host in hosts(source, {}) for mutant in host.mutants]
    assert mutants and {mutant.kind for mutant in mutants} == {wanted}
