"""Proofs fail where the RTL is wrong: each is run on copies of it that are broken in one place.

That they hold on the RTL itself is what `make formal` says.
"""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.configuration import parse_configuration
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import DUT
from triaxis.sim.programs import EndedError
from triaxis.verif.core.tests.broken_rtl import broken_rtl
from triaxis.verif.formal import proving
from triaxis.verif.formal.axis_proofs import axes_proof
from triaxis.verif.formal.certifier_proof import certificate
from triaxis.verif.formal.netlist import NetlistError
from triaxis.verif.formal.proof import Finding, Proof, Result, SbyProof, _header
from triaxis.verif.formal.proofs import proofs

pytestmark = pytest.mark.prover


# Each by name: the proof that must fail, the RTL file, what of it is replaced by what, what the proof says.
# Each condition of go, left out.
UNSAFE = (
    ("go goes on through a HELLO", "hello_i || load_i", "load_i"),
    ("go goes on through a LOAD", "hello_i || load_i", "hello_i"),
    ("go goes on through a RUN that does not hold", "|| (run_i && !keep_i) ||", "||"),
    ("go goes on after a segment that is near", "go_q && !late && !done_i", "go_q && !late"),
    ("go goes on after its time", "go_q && !late && !done_i", "go_q && !done_i"),
    ("go that has no hold ends", "go_q && timed_q && last", "go_q && last"),
    ("go for a unit too long", "left_q  <= hold_i;", "left_q  <= hold_i + hold_t'(1);"),
    (
        "go for a clock too long",
        "part_t'(HoldClocks - 1);\n    end else if (last)",
        "part_t'(HoldClocks);\n    end else if (last)",
    ),
    ("go goes on through an ABORT", "|| abort_i;", ";"),
    ("go after an error on the line", "link_error_i || refused_i", "refused_i"),
    ("go after a refusal", "|| refused_i ", ""),
    ("go while nobody is heard", "|| !alive_i", ""),
    ("go before a run ends", "done_i && engine", "engine"),
    ("go after a run that was cut", "engine_status_i == StatusComplete && ", ""),
    ("go without a run since the last change", "|| (armed_q && clear)", "|| clear"),
    ("armed from the start", "(armed_q && !changed && !late)", "(!changed && !late)"),
    ("a fault does not disarm", "!late)) && !fault;", "!late));"),
    ("go while a fault of the board stands", "!alive_i || fault_i;", "!alive_i;"),
    ("go that something in a zone ends", "&& near_i == '0;", "&& near_i == '0 && zones_i == '0;"),
    ("beyond a zone without go", "go_d ? ~zones_d : '0", "~zones_d"),
    ("beyond the zones of the run before", "(armed_q && clear) ?", "(armed_q && clear && !go_q) ?"),
    ("stop is not the contrary of go", "stop_q <= !go_d;", "stop_q <= go_d;"),
)
# Each of the board's wires that go rests on.
MISWIRED = (
    ("refusals are not told", ".refused_i(refused)", ".refused_i(1'b0)"),
    ("errors of the line are not told", ".link_error_i(link_error)", ".link_error_i(1'b0)"),
    ("every run holds", ".keep_i(keep[i])", ".keep_i(1'b1)"),
    ("the zones of no run", ".zones_i(zones),", ".zones_i('0),"),
    ("the hold of no run", ".hold_i(runs[i].hold)", ".hold_i('1)"),
    ("a HELLO ends no run", "assign cut = abort || hello;", "assign cut = abort;"),
    ("any frame is a sign of life", ".kick_i(kick)", ".kick_i(kick || refused)"),
    ("go at each end of a run", ".engine_status_i(done_status)", ".engine_status_i(StatusComplete)"),
    ("a fault of the engine that a RUN acknowledges", ".acknowledge_i(hello)", ".acknowledge_i(begins)"),
    ("a fault of the board that goes by itself", "(board_fault_q && !hello)", "1'b0"),
    ("signatures swapped", ".signature_a_o(signatures[0]),\n      .signature_b_o(signatures[1])",
     ".signature_a_o(signatures[1]),\n      .signature_b_o(signatures[0])"),
    ("counts swapped", ".count_a_i(16'(count_a)),\n      .count_b_i(16'(count_b))",
     ".count_a_i(16'(count_b)),\n      .count_b_i(16'(count_a))"),
)  # fmt: skip
# What the engine's checks find, and it does not heed.
UNCHECKED = (
    ("walks that differ are no fault", "seen[0] != second || ", "", "check"),
    ("intakes that differ are no fault", " || stores_differ != '0;", ";", "check"),
    ("a fault of the core is none", "broken || differ || verdict_fault", "broken || differ", "check"),
    ("a box of A that is broken is no fault", "box_a_used != '0 && !box_a_intact;", "1'b0;", "check"),
    ("what the second walk rests on is no fault", "(words_used[0] | words_used[1])", "words_used[0]",
     "check"),
    ("a fault that goes by itself", "|| (fault_q && !acknowledge_i)", "", "check"),
    ("a run in doubt that is acknowledged", "(busy_o || accept)) || (ends_in_fault_q && !accept);",
     "(busy_o || accept));", "check"),
    ("a run that begins in doubt", "(fault || unlike) && (busy_o || accept)", "(fault || unlike) && busy_o",
     "check"),
    ("a run that is over falls into doubt", " && (busy_o || accept)) ||", ") ||", "check"),
    ("summaries that differ are complete", "StatusNone && (unlike || ends", "StatusNone && (ends", "InDoubt"),
    ("zones that differ are no difference of summaries", "zones[0] != zones[1] ||", "", "check"),
    ("a mesh that is not as it was loaded is no fault", "triangles_broken || stores_broken != '0;",
     "triangles_broken;", "check"),
    ("a trial that goes on when it was found", "(acknowledge_i || stores_broken != '0)", "(acknowledge_i)",
     "check"),
    ("a memory is tried in the run and after it", "(busy_o ? 5'(i) : 5'(WhichScrub + i))",
     "(trial_q.which < 5'(WhichScrub) ? 5'(i) : 5'(WhichScrub + i))", "TriedMemory"),
    ("a comparison of the scrub is tried in a run", "5'(WhichScrubbed) && !busy_o;", "5'(WhichScrubbed);",
     "TriedScrub"),
    ("a mesh is scrubbed as a run is accepted", "s_axis_run_tready_o && !s_axis_run_tvalid_i;",
     "s_axis_run_tready_o;", "Scrubs"),
    ("a fault that is none", "|| ends_in_fault_q)", "|| ends_in_fault_q || near[0] == '1)", "ElseAsSaid"),
    ("a trial of the walks that tries nothing", "misread[i] = trying_walk && ",
     "misread[i] = trying_walk && !busy_o && ", "check"),
    ("a trial of another memory", ".trial_boxes_i(broken_memory[MemoryBoxesA])",
     ".trial_boxes_i(broken_memory[MemoryBoxesB])", "TriedMemory"),
)  # fmt: skip
# What one walk or intake does, and does not show.
UNSEEN = (
    ("where A's vertices are read", "mesh/triaxis_walk.sv",
     "{triangle_a_index_o, triangle_b_index_o} :", "{triangle_b_index_o, triangle_b_index_o} :", "Reads"),
    ("which word of boxes is read", "mesh/triaxis_walk.sv",
     "box_b_read_o ? box_b_word_o :", "box_a_read_o ? box_b_word_o :", "Reads"),
    ("the margin of a pair", "mesh/triaxis_walk.sv", "core_valid_o ? core_margin_o : '0", "'0", "Pair"),
    ("pairs that are skipped", "mesh/triaxis_walk.sv",
     "    pairs_skipped_o,\n    tested_o,", "    tested_o,\n    tested_o,", "Answers"),
    ("the zone of a pair", "mesh/triaxis_walk.sv",
     "core_valid_o ? core_zone_o :", "row_read_o ? core_zone_o :", "Pair"),
    ("the zones of a run", "mesh/triaxis_walk.sv", "    zones_o,\n    near_o\n", "    2'd0,\n    near_o\n",
     "Summary"),
    ("the box of a group", "mesh/triaxis_mesh_intake.sv", "used ? group_q[c][k] : '0", "'0", "Words"),
    ("the box of a mesh at rest", "mesh/triaxis_mesh_intake.sv", "known || (write_o", "(write_o", "Objects"),
    ("the count", "mesh/triaxis_mesh_intake.sv", "seen.count = count_q;", "seen.count = '0;", "Counts"),
    ("what a reset leaves is shown", "mesh/triaxis_mesh_intake.sv", "write_o ? triangle_o : '0",
     "valid_q == '0 || write_o ? triangle_o : '0", "AfterReset"),
)  # fmt: skip
# What the scrub does not look at, or finds where nothing is, or nobody finds.
UNSCRUBBED = (
    ("it goes on in a pause", "if (read_o) index_q <=", "index_q <=", "check"),
    ("the last triangle is left out", "count_t'(index_q) + count_t'(1) == count_i",
     "count_t'(index_q) + count_t'(2) >= count_i", "check"),
    ("it goes on where it was before a load", "load) begin\n      index_q <= '0;", "load) begin", "check"),
    ("a word read before a load counts", "reading_q && !load && (", "reading_q && (", "check"),
    ("a word that waits is looked at again", "reading_q <= read_o;", "reading_q <= read_o || reading_q;",
     "check"),
    ("a word that is not intact", "(!intact_i || unlike", "(unlike", "Found"),
    ("a vertex beyond the highest", "vertex > box[1]", "1'b0", "Found"),
    ("a vertex on its box is outside", "vertex < box[0]", "vertex <= box[0]", "Found"),
    ("a box beyond its group's", "box_i[1][k] > group[1]", "box[1] > box_i[1][k]", "Found"),
    ("bounds as numbers without signs", "coord_t vertex;", "logic [W-1:0] vertex;", "Found"),
    ("the CRC before the last triangle", "unlike = last_q && ", "unlike = ", "Found"),
    ("the CRC of the pass before", "crc_q <= last_q ? '1 : crc_d;", "crc_q <= crc_d;", "check"),
    ("a trial of the CRC that tries nothing", "which_i == 4'(i % 8)", "which_i == 4'(i % 8) && !last_q",
     "Found"),
    ("a trial of an axis that is another's", "which_i == 4'(8 + k)", "which_i == 4'(10 - k)", "Found"),
    ("a trial of groups that tries nothing", "which_i == 4'(11 + k)", "which_i == 4'(11 + k) && k != 1",
     "TriedBounds"),
)  # fmt: skip
# What the signature is not made of.
UNSIGNED = (
    ("what does not fit is signed for", "else if (keep) came_q", "else if (push_i) came_q"),
    ("the mesh before is signed for", "else if (clear_i) came_q <= '1;", ""),
    ("coordinates without their signs", "bit_index : W - 1)", "bit_index : 0)"),
    ("bytes of the next coordinate", "32 + i * W + (bit", "32 + (i ^ 1) % 9 * W + (bit"),
    ("the signature is not inverted", "signature_o = ~came_q", "signature_o = came_q"),
)  # fmt: skip
# What one of two on the board permits, or does, alone.
ALONE = (
    ("stop is that of go's own", "board/nexys4ddr_top.sv", "stop_o = says_stop[1]", "stop_o = says_stop[0]",
     "check"),
    ("one watchdog for both", "board/nexys4ddr_top.sv", ".alive_i(alive[i])", ".alive_i(alive[0])", "check"),
    ("runners that differ are no fault", "board/nexys4ddr_top.sv", "runners_differ || frame_broken",
     "frame_broken", "check"),
    ("a broken frame is no fault", "board/nexys4ddr_top.sv", "runners_differ || frame_broken",
     "runners_differ", "Broken"),
    ("a fault of the engine is none", "board/nexys4ddr_top.sv", "engine_fault || board_fault_q;",
     "board_fault_q;", "Faults"),
    ("a trial of the runners that tries nothing", "board/nexys4ddr_top.sv", "misread[i] = trying_runner && ",
     "misread[i] = trying_frame && ", "TriedRunner"),
    ("one alone says that all is beyond a zone", "board/nexys4ddr_top.sv",
     "says_beyond[0] & says_beyond[1]", "says_beyond[0]", "BothBeyond"),
    ("one alone has the zones of another run", "board/triaxis_safety.sv", "(armed_q && clear) ?", "done_i ?",
     "check"),
    ("the zones that a runner has", "board/triaxis_runner.sv",
     "    zones_q,\n    summary_q", "    2'd0,\n    summary_q", "RunsDiffer"),
    ("the zones of a run that the host is not told", "board/nexys4ddr_top.sv", "zones: runs[0].zones",
     "zones: zones", "check"),
    ("the pose of a run", "board/triaxis_runner.sv", "    hold_q,\n    pose_q,\n    run_number_q",
     "    hold_q,\n    96'd0,\n    run_number_q", "RunsDiffer"),
    ("both runners are asked by one request", "board/nexys4ddr_top.sv", "fields_i(request[i].fields)",
     "fields_i(request[0].fields)", "AsAsked"),
    ("both runs begin by one command", "board/triaxis_command.sv", ".run_o    (run_o[i]),",
     ".run_o    (run_o[1-i]),", "RunOfItsOwn"),
    ("what is executed that was not judged just then", "board/triaxis_command.sv", " && good_q", "",
     "Executes"),
    ("a frame is judged that was not gathered", "board/triaxis_command.sv",
     " && place_q == place_t'(RequestBytes)", "", "Judged"),
    ("a code that turns to good", "board/triaxis_command.sv", " && judged == CodeOk", "", "Judged"),
    ("what is executed though its code is another", "board/triaxis_command.sv",
     " && code_q == CodeOk && !rep", " && !rep", "Executes"),
    ("what is gathered is not all kept", "board/triaxis_request.sv",
     "{data_i, request_q[$bits(request_t)-1:8]}", "{data_i, request_q[$bits(request_t)-1:9], 1'b0}",
     "Gathered"),
    ("the second is judged", "board/triaxis_command.sv", "request = request_o[0]", "request = request_o[1]",
     "First"),
)  # fmt: skip
BROKEN = (
    ("accepts more than the queue holds", "streams_m0", "core/triaxis_core.sv",
     "(in_flight_q != count_t'(Depth))", "1'b1", "Occupancy"),
    ("a clock too early", "streams_m0", "core/triaxis_core.sv",
     ".push_i (valid_q[Latency-1])", ".push_i (valid_q[Latency-2])", "check"),
    ("loses results now and then", "streams_m16", "core/triaxis_core.sv",
     ".push_i (valid_q[Latency-1])", ".push_i (valid_q[Latency-1] && result.tag[6:0] != 7'd77)",
     "check"),
    ("withdraws a waiting result", "streams_m0", "core/triaxis_fifo.sv",
     "if (pop_i) read_q", "if (pop_i || (valid_o && read_q[3:0] == 4'd9)) read_q", "check"),
    ("ready two clocks after reset", "streams_m0", "core/triaxis_core.sv",
     "awake_q <= 1'b1;", "awake_q <= valid_q[0] || in_flight_q == count_t'(0);\n"
     "      if (!awake_q) awake_q <= tag[0];", "check"),
    ("touching taken for clear", "interval_m0", "core/triaxis_interval.sv",
     "points_i[i] > own_i;", "points_i[i] >= own_i;", "Interval"),
    ("threshold a clock late", "interval_m16", "core/triaxis_interval.sv",
     "`TRIAXIS_STAGE(points, points_i)", "assign points = points_i;", "Interval"),
    ("one side alone", "box_m0", "core/triaxis_box.sv",
     "(a_to_b_q > margin) || (b_to_a_q > margin)", "(a_to_b_q > margin)", "Box"),
    ("margin one clock late", "box_m16", "core/triaxis_box.sv",
     ".Cycles(Comb ? 0 : BoxLatency - 1)", ".Cycles(Comb ? 0 : BoxLatency)", "Box"),
    ("a middle point taken for the lowest", "box_m0", "core/triaxis_extent.sv",
     "low[0] = below_q[0] && !below_q[2];", "low[0] = below_q[0];", "Lowest"),
    ("claims the last axis", "verdict_w16", "core/triaxis_verdict.sv",
     " & -separated_q[NumAxes-1:AxisNormalA]", "", "ClaimIsLowest"),
    ("a normal that is zero but for its upper bits", "verdict_w24", "core/triaxis_flags.sv",
     "normal_a_i[k] == 0", "normal_a_i[k][39:0] == 0", "FlagA"),
    ("an orientation that is zero but for its upper bits", "verdict_w32", "core/triaxis_flags.sv",
     "flat_b_i[k] == 0", "flat_b_i[k][59:0] == 0", "FlagCoplanar"),
    ("flags of a masked pair", "verdict_w16", "core/triaxis_verdict.sv",
     "coplanar_i && !gated_i", "coplanar_i", "FlagCoplanar"),
    ("the most negative component overflows", "threshold_space", "core/triaxis_threshold.sv",
     "-norm_t'(axis_i[k])", "norm_t'(CWidth'(-axis_i[k]))", "Norm"),
    ("margin before its components", "threshold_plane", "core/triaxis_threshold.sv",
     ".Cycles(Comb ? 0 : NormLatency)", ".Cycles(Comb ? 0 : NormLatency - 1)", "Margin"),
    ("threshold a bit too low", "threshold_small", "core/triaxis_threshold.sv",
     "product[CWidth+M-1:0]", "product[CWidth+M:1]", "Product"),
    ("touching projections are apart", "apart_m0", "core/triaxis_apart.sv",
     "above_q > span_t", "above_q >= span_t", "Apart"),
    ("the third vertex of B is forgotten", "apart_m16", "core/triaxis_apart.sv",
     "(low_b < b_q[2]) ? low_b : b_q[2]", "low_b", "Apart"),
    ("the first vertex of A is forgotten", "apart_small", "core/triaxis_apart.sv",
     "(high_a < 0) ? '0 : high_a", "high_a", "Apart"),
    ("a component of the axis left out", "reach", "core/triaxis_reach.sv",
     "norm_d = two_q + norm_t'(last_q);", "norm_d = two_q;", "Norm"),
    ("the margin of the next pair", "reach_small", "core/triaxis_reach.sv",
     ".Cycles(Comb ? 0 : 3)", ".Cycles(Comb ? 0 : 2)", "Margin"),
    ("two edges of a certificate swapped", "certificate", "core/triaxis_certifier.sv",
     "firsts[i]  = EdgeA + row;\n        seconds[i] = EdgeB + column;",
     "firsts[i]  = EdgeA + column;\n        seconds[i] = EdgeB + row;", "axis 6: "),
    ("a result by its place alone", "certified_upset", "core/triaxis_certified_core.sv",
     "oldest.result.number == delivered_q;",
     "oldest.result.number[0] == delivered_q[0];", "check"),
    ("the number is not compared", "certified", "core/triaxis_certified_core.sv",
     " && oldest.result.number == delivered_q;", ";", "check"),
    ("the parity of a pair is not compared", "certified", "core/triaxis_certified_core.sv",
     "kept_q.parity == parity_of(kept_q.pair);", "1'b1;", "check"),
    ("a pair without parity", "certified_upset", "core/triaxis_certified_core.sv",
     "kept_q.parity == parity_of(kept_q.pair);", "1'b1;", "check"),
    ("the parity of a result is not compared", "certified_upset", "core/triaxis_certified_core.sv",
     "oldest.parity == result_parity && ", "", "check"),
    ("the answer of the certifier is not heard", "certified", "core/triaxis_certified_core.sv",
     "(!shown.claim.is_near && !holds)", "1'b0", "check"),
    ("the claim of the next pair", "certified", "core/triaxis_certified_core.sv",
     "claim.claim = verdict_q;", "claim.claim = {core_word[12:8], core_word[3:0]};", "check"),
    ("a tag one clock early", "certified", "core/triaxis_certified_core.sv",
     "made.result.tag = shown.tag;", "made.result.tag = claims_q[Wait-2].tag;", "check"),
    ("the certifier is given the next pair", "certified", "core/triaxis_certified_core.sv",
     ".margin_i(kept_q.pair.margin)", ".margin_i(pairs_q[core_place].pair.margin)", "GivenThePair"),
    ("the top row counts positive", "multiply_narrow", "core/triaxis_narrow_mul.sv",
     "row[2*n] - row[2*n+1]", "row[2*n] + row[2*n+1]", "Product"),
    ("low piece with a sign", "multiply_small", "core/triaxis_mul.sv",
     "assign x_piece[i] = {1'b0, x[i*XStep+:XStep]};",
     "assign x_piece[i] = {x[i*XStep+XStep-1], x[i*XStep+:XStep]};", "Product"),
    ("low pieces of the second operand with a sign", "multiply_wide", "core/triaxis_mul.sv",
     "assign y_piece[j] = {1'b0, y[j*YStep+:YStep]};",
     "assign y_piece[j] = {y[j*YStep+YStep-1], y[j*YStep+:YStep]};", "not the operand"),
    ("a piece at the wrong place", "multiply_wide", "core/triaxis_mul.sv",
     "<<< (i * XStep + j * YStep)", "<<< (i * XStep + j * XStep)", "do not add up"),
    ("a piece's product one bit too narrow", "multiply_wide", "core/triaxis_mul.sv",
     "logic signed [XBits+YBits-1:0] piece_d, piece_q;",
     "logic signed [XBits+YBits-3:0] piece_d, piece_q;",
     "does not fit"),
    ("a piece's product at the falling edge", "multiply_wide", "core/triaxis_mul.sv",
     "`TRIAXIS_STAGE(piece, piece_q)", "always_ff @(negedge clk_i) piece <= piece_q;", "rising one of clk_i"),
    ("an area too many in edge x edge", "areas_w1", "core/triaxis_areas.sv",
     "across_a_1[i][(j+1)%3] - across_a_1[i][j]", "across_a_1[i][(j+1)%3]", "EdgeEdge"),
    ("projections one bit too narrow", "widths", "core/triaxis_pkg.sv",
     "return 3 * w + 3;", "return 3 * w + 2;", "too few at W = 8"),
    ("thresholds take two clocks more", "widths", "core/triaxis_pkg.sv",
     "return 1 + sum_latency(components) + mul", "return 3 + sum_latency(components) + mul", "come late"),
    ("sums of three one bit too narrow", "widths", "core/triaxis_pkg.sv",
     "return w + 2;", "return w + 1;", "sum of three"),
    ("operands one bit wider than needed", "widths", "core/triaxis_pkg.sv",
     "return w + 1;", "return w + 2;", "more than needed"),
    ("the margin counts once on both sides", "engine_skip", "mesh/triaxis_run_control.sv",
     "shift_o[0][k] <= grown_t'(move_o[k]) - grown_t'({1'b0, margins_o[ZoneWarn]});",
     "shift_o[0][k] <= grown_t'(move_o[k]);", "SumsAreExact"),
    ("touching boxes are skipped", "engine_skip", "mesh/triaxis_overlap.sv",
     "> grown_i[1][k]", ">= grown_i[1][k]", "ComparisonIsExact"),
    ("boxes of A stay where they were loaded", "engine_skip_small", "mesh/triaxis_grow.sv",
     "grown_t'(box_i[c][k]) + shift_i[c][k]", "grown_t'(box_i[c][k])", "SumsAreExact"),
    ("one LSB beyond the range is let in", "engine_skip", "mesh/triaxis_run_control.sv",
     "grown_t'(move_o[k]) > Highest", "grown_t'(move_o[k]) > Highest + grown_t'(1)", "OverflowIsExact"),
    ("a group's box forgets what was before", "engine_boxes", "mesh/triaxis_mesh_intake.sv",
     "if (!first_in_group && group_q[0][k] < box_o[0][k]) group_o[0][k] = group_q[0][k];", "", "HoldsGroup"),
    ("a group's box goes on from the one before", "engine_boxes", "mesh/triaxis_mesh_intake.sv",
     "(index_o & index_t'(Group - 1)) == '0", "(index_o & index_t'(Depth - 1)) == '0", "Smallest"),
    ("a word that is not written where another was read", "engine_memory", "mesh/triaxis_ram.sv",
     "if (write_i) memory_q", "if (write_i && !(read_i && write_address_i[2:0] == 3'd5)) memory_q", "Kept"),
    ("a word read of the address below", "engine_memory", "mesh/triaxis_ram.sv",
     "memory_q[read_address_i]", "memory_q[read_address_i & ~AddressWidth'(write_i)]", "Read"),
    ("a queue that is never full", "engine_queue", "mesh/triaxis_stream_fifo.sv",
     "held_d != count_t'(Depth)", "1'b1", "ReadyIfRoom"),
    ("the highest lane first", "engine_pick", "mesh/triaxis_pick.sv",
     "lane_o = lane_t'(Lanes - 1);\n    for (int l = int'(Lanes) - 2; l >= 0; l--) begin",
     "lane_o = lane_t'(0);\n    for (int l = 1; l < int'(Lanes); l++) begin", "LowestFirst"),
    ("what was aborted is complete", "engine_control", "mesh/triaxis_run_control.sv",
     "first_i ? StatusFirst : StatusAborted", "first_i ? StatusFirst : StatusComplete",
     "NeverCompleteIfCut"),
    ("cycles start again from 0", "engine_control", "mesh/triaxis_run_control.sv",
     " && cycles_o != '1)", ")", "Cycles"),
    ("a near pair takes the place of one that waits", "engine_near", "mesh/triaxis_near_pairs.sv",
     "!innermost || !m_axis_near_tvalid_o || m_axis_near_tready_i", "1'b1", "check"),
    ("a pair that is asked again is counted", "engine_near", "mesh/triaxis_near_pairs.sv",
     "take && !drop && !again;", "take && !drop;", "check"),
    ("a pair that is near in the widest zone is asked no more", "engine_near", "mesh/triaxis_near_pairs.sv",
     "near_found && !innermost;", "near_found && verdict_zone_i == ZoneSlow;", "check"),
    ("a pair is asked again in the same zone", "engine_near", "mesh/triaxis_near_pairs.sv",
     "within_warn = zones_o[ZoneSlow] ?", "within_warn = near_o != '0 ?", "check"),
    ("a zone with a near pair in it is empty", "engine_near", "mesh/triaxis_near_pairs.sv",
     "(verdict_zone_i != ZoneWarn)", "(verdict_zone_i == ZoneSlow)", "check"),
    ("zones of the run before", "engine_near", "mesh/triaxis_near_pairs.sv",
     "else if (start_i) zones_o <= ~wider_i;", "", "check"),
    ("a zone that was not asked about is free", "engine_near", "mesh/triaxis_near_pairs.sv",
     "zones_o <= ~wider_i;", "zones_o <= '0;", "NeverFreeUnasked"),
    ("a zone narrower than the one within it", "engine_control", "mesh/triaxis_run_control.sv",
     "wider_o[ZoneWarn] ? asked_q[ZoneWarn] : slow;", "asked_q[ZoneWarn];", "Ordered"),
    ("a zone that is as wide as another", "engine_control", "mesh/triaxis_run_control.sv",
     "wider_o[ZoneWarn] ? asked_q[ZoneWarn] :", "wider_o == '1 ? asked_q[ZoneWarn] :", "check"),
    ("a zone that is as wide as another is told as wider", "engine_control", "mesh/triaxis_run_control.sv",
     "asked_q[ZoneSlow] > asked_q[ZoneMargin];", "asked_q[ZoneSlow] >= asked_q[ZoneMargin];", "WiderIsWider"),
    ("zones of the run before are told as wider", "engine_control", "mesh/triaxis_run_control.sv",
     "asked_q[ZoneWarn] > slow;", "asked_q[ZoneWarn] > margins_o[ZoneSlow];", "WiderStays"),
    ("what is in the widest zone is skipped", "engine_control", "mesh/triaxis_run_control.sv",
     "+ grown_t'({1'b0, margins_o[ZoneWarn]})", "+ grown_t'({1'b0, margins_o[ZoneSlow]})", "ShiftsByWidest"),
    ("more pairs on their way than are counted for", "engine_walk", "mesh/triaxis_mesh.sv",
     "2 ** $clog2(CoreLatency) + 2;", "2 ** $clog2(CoreLatency) + 1;", "check"),
    ("a mesh counts what does not fit", "engine_boxes", "mesh/triaxis_mesh_intake.sv",
     "if (keep) count_q", "if (push_i) count_q", "Counted"),
    ("a triangle at the next one's number", "engine_boxes", "mesh/triaxis_mesh_intake.sv",
     "index_q <= count_q[IndexWidth-1:0];", "index_q <= count_q[IndexWidth-1:0] + index_t'(1);",
     "AtItsNumber"),
    ("a run reads where the scrub is", "engine_boxes", "mesh/triaxis_mesh_store.sv",
     "scrub_read ? scrub_index : triangle_index_i", "scrub_i ? triangle_index_i : scrub_index", "Triangle"),
    ("the box of another lane is scrubbed", "engine_boxes", "mesh/triaxis_mesh_store.sv",
     "LaneWidth'(scrubbed & LastLane)", "LaneWidth'(scrub_index & LastLane)", "check"),
    ("the scrub looks at no box's parity", "engine_boxes", "mesh/triaxis_mesh_store.sv",
     "triangle_intact_o && boxes_intact_o[box_lane] && ", "triangle_intact_o && ", "Handed"),
    ("a mesh is scrubbed that is still being written", "engine_boxes", "mesh/triaxis_mesh_store.sv",
     "scrub_i && settled_o", "scrub_i", "OnlyThen"),
    *((name, "board_go", "board/triaxis_safety.sv", old, new, "check") for name, old, new in UNSAFE),
    *((name, "board_go", "board/nexys4ddr_top.sv", old, new, "check") for name, old, new in MISWIRED),
    ("go although a pair is near", "board_go", "board/triaxis_safety.sv", " && near_i == '0", "", "Clear"),
    ("a watchdog of one clock more", "board_go", "board/triaxis_watchdog.sv",
     "left_q <= count_t'(Clocks);", "left_q <= count_t'(Clocks + 1);", "check"),
    ("repeats are signs of life", "board_go", "board/triaxis_command.sv",
     "(done && !repeated)", "done", "check"),
    ("a HELLO leaves the number of the session before", "board_go", "board/triaxis_session.sv",
     "if (take_i || executed_i)", "if (executed_i)", "check"),
    ("a session that a reset begins", "board_go", "board/triaxis_session.sv",
     "if (!rst_ni) session_q <= '0;", "if (!rst_ni) session_q <= 32'd1;", "check"),
    ("any sequence number will do", "board_go", "board/triaxis_judge.sv",
     "mine_i && !next_i && !repeat_i", "1'b0", "check"),
    ("runs on as many triangles of A as there are", "board_go", "board/triaxis_judge.sv",
     "run.count_a != count_a_i || ", "", "check"),
    ("a pose that is cut off", "board_go", "board/triaxis_judge.sv",
     "top == '0 || top == '1;", "1'b1;", "check"),
    ("triangles of B go to A", "board_go", "board/triaxis_loader.sv",
     "{state_q == Empty, mesh_q}", "{state_q == Empty, 1'b0}", "check"),
    ("a triangle's bytes in another order", "board_go", "board/triaxis_loader.sv",
     "{data_i, triangle_q[8*TriangleBytes-1:8]}", "{triangle_q[8*TriangleBytes-9:0], data_i}", "check"),
    ("the last row of groups is left out", "engine_walk", "mesh/triaxis_group_rows.sv",
     "count_t'(next_q) + count_t'(1) ==", "count_t'(next_q) + count_t'(2) ==", "check"),
    ("the last word of groups is left out", "engine_walk", "mesh/triaxis_group_words.sv",
     "(groups_b_i - count_t'(1))", "(groups_b_i - count_t'(2))", "check"),
    ("the last triangle has no lane", "engine_walk", "mesh/triaxis_lane_mask.sv",
     "CountWidth'(l) < count_i", "CountWidth'(l) + CountWidth'(1) < count_i", "check"),
    ("a pair that waits is written over", "engine_walk", "mesh/triaxis_pair_fetch.sv",
     "enable  = !valid_o || ready_i", "enable  = 1'b1", "check"),
    ("a box is compared in the name of the next", "engine_walk", "mesh/triaxis_pair_boxes.sv",
     "grown_index_q <= read_index_q", "grown_index_q <= index_a", "check"),
    ("the lowest lane instead of its own", "engine_walk", "mesh/triaxis_walk.sv",
     "index_t'(pair_word.word) * index_t'(Lanes) + index_t'(pair_lane)",
     "index_t'(pair_word.word) * index_t'(Lanes)", "check"),
    ("a run that is over with words in a queue", "engine_walk", "mesh/triaxis_walk.sv",
     "boxes_idle && !masked_valid && !pair_valid", "boxes_idle && !pair_valid", "check"),
    ("a run that is over with pairs to be asked again", "engine_walk", "mesh/triaxis_walk.sv",
     "&& !pair_valid && !again_valid &&", "&& !pair_valid &&", "check"),
    ("a new pair that is taken when another is asked again", "engine_walk", "mesh/triaxis_walk.sv",
     "pair_ready = fetch_ready && !again_valid;", "pair_ready = fetch_ready;", "check"),
    ("a port that is narrower than what is read of it", "engine_walk", "mesh/triaxis_mesh_pkg.sv",
     "$bits(mode_e) + $bits(trial_t);", "$bits(mode_e) + $bits(trial_t) - 1;", "bits are read"),
    ("a new pair in the place of one that is asked again", "engine_walk", "mesh/triaxis_walk.sv",
     "again_valid ? pair_again : pair_found;", "pair_valid ? pair_found : pair_again;", "check"),
    ("a verdict that waits although its pair is asked again", "engine_walk", "mesh/triaxis_near_pairs.sv",
     "verdict_ready_o = drop || !innermost ||", "verdict_ready_o = drop || !verdict_near_i ||", "check"),
    ("a pair that is asked with the margin of another zone", "engine_walk", "mesh/triaxis_walk.sv",
     "margins[core_zone_o]", "margins[ZoneMargin]", "AsItIs"),
    ("a pair in the zone of the next", "engine_walk", "mesh/triaxis_pair_fetch.sv",
     "zone_o <= read_zone_q;", "zone_o <= zone_i;", "check"),
    ("nothing is in a zone that was not asked about", "engine_walk", "mesh/triaxis_walk.sv",
     ".wider_i(wider),", ".wider_i('1),", "check"),
    ("moved along another axis", "engine_walk", "mesh/triaxis_pair_fetch.sv",
     "move_i[i%3]", "move_i[i/3]", "check"),
    ("a box that touches is skipped", "engine_walk", "mesh/triaxis_overlap.sv",
     "grown_t'(boxes_i[l][1][k]) < grown_i[0][k]", "grown_t'(boxes_i[l][1][k]) <= grown_i[0][k]",
     "Apart"),
    ("a box of a group that rests on no word", "engine_walk", "mesh/triaxis_group_words.sv",
     "assign used_o = decided;", "assign used_o = '0;", "Apart"),
    ("vertices that rest on no word", "engine_walk", "mesh/triaxis_pair_fetch.sv",
     "used_o  = read_valid_q && enable;", "used_o  = read_valid_q && valid_o;", "check"),
    ("the scrub reads in a run", "engine_walk", "mesh/triaxis_mesh.sv",
     "s_axis_run_tready_o && !s_axis_run_tvalid_i;", "!s_axis_run_tvalid_i;", "check"),
    *((name, "engine_checks", "mesh/triaxis_mesh.sv", *row) for name, *row in UNCHECKED),
    *((name, "engine_scrub", "mesh/triaxis_mesh_scrub.sv", *row) for name, *row in UNSCRUBBED),
    *((name, "engine_signature", "mesh/triaxis_mesh_scrub.sv", *row, "check") for name, *row in UNSIGNED),
    *((name, "engine_twice", file, *row) for name, file, *row in UNSEEN),
    *((name, "board_twice", file, *row) for name, file, *row in ALONE),
    ("intakes differ by what they begin with", "engine_intakes", "mesh/triaxis_mesh_intake.sv",
     "used ? group_q[c][k]", "write_o ? group_q[c][k]", "Alike"),
    ("an intake that is misread and not told", "engine_intakes", "mesh/triaxis_mesh_store.sv",
     "seen[1] ^ misread;", "seen[1];", "Alike"),
    ("parity without the address", "engine_parity", "mesh/triaxis_parity_ram.sv",
     "^{write_address_i, write_data_i[i]}", "^write_data_i[i]", "check"),
    ("the parity of one piece alone", "engine_parity", "mesh/triaxis_parity_ram.sv",
     "found.parity == due", "found.parity[0] == due[0]", "Broken"),
    ("a word is held to be of an address that was not read", "engine_parity_boxes",
     "mesh/triaxis_parity_ram.sv", "if (read_i) address_q", "address_q", "check"),
    ("a trial of a memory that tries nothing", "engine_parity_boxes", "mesh/triaxis_parity_ram.sv",
     "found.data[i], trial_i}", "found.data[i]}", "Intact"),
    ("a command reads its header twice", "board_go", "board/triaxis_command.sv",
     "address_t'(place_q)", "address_t'(place_q[2:0])", "Head"),
    ("a run that the engine may not take", "board_go", "board/triaxis_judge.sv",
     "CmdRun:  command_code = busy_i ? CodeBusy : run_code", "CmdRun:  command_code = run_code", "check"),
    ("a byte whose parity nobody looks at", "board_frame", "board/triaxis_frame_rx.sv",
     "((parity != ^data_o) || trial_i)", "trial_i", "Broken"),
    ("bytes are broken that nobody is shown", "board_frame", "board/triaxis_frame_rx.sv",
     "broken_o = shown && ", "broken_o = ", "Broken"),
    ("frames without a CRC", "board_frame", "board/triaxis_frame_rx.sv",
     " && crc == CrcResidue", "", "HandedOut"),
    ("a power too many in the polynomial", "board_frame", "mesh/triaxis_mesh_pkg.sv",
     "32'hEDB8_8320", "32'hEDB8_8321", "check"),
    ("a frame over one that is held", "board_frame", "board/triaxis_frame_rx.sv",
     "full_q || count_q == Longest", "count_q == Longest", "check"),
    ("a damaged frame that nobody hears of", "board_frame", "board/triaxis_frame_rx.sv",
     "(ended && !good) || ", "", "Told"),
    ("a frame goes on after a framing error", "board_slip", "board/triaxis_slip_rx.sv",
     "        seen_q  <= Error;\n        state_q <= Hunt;", "        seen_q  <= Error;", "check"),
    ("an escaped ESC comes back as END", "board_slip", "board/triaxis_slip_rx.sv",
     "unescaped_end ? SlipEnd : SlipEsc", "SlipEnd", "Escaped"),
    ("no END between two frames", "board_slip", "board/triaxis_slip_tx.sv",
     "last_i ? Last : Plain", "Plain", "check"),
    ("bits a clock before their middles", "board_bytes", "board/triaxis_uart_rx.sv",
     "ClocksPerThreeBits / 2 - 3", "ClocksPerThreeBits / 2 - 6", "check"),
    ("a bit that loses its thirds of a clock", "board_line", "board/triaxis_uart_tx.sv",
     "      count_q <= count_q + Whole;", "      count_q <= Whole;", "check"),
    ("near pairs counted to half a million", "board_ring", "board/triaxis_near_ring.sv",
     "written_q + 32'd1;", "(written_q + 32'd1) & 32'h0007_FFFF;", "check"),
    ("a ring that frees one pair too many", "board_ring", "board/triaxis_near_ring.sv",
     "freed_q <= number_i;", "freed_q <= number_i + 32'(number_i[19]);", "check"),
    ("a byte without a stop bit", "board_bytes", "board/triaxis_uart_rx.sv",
     "valid_o && !line;", "1'b0;", "Framing"),
    ("a run's cycles cut", "board_runs", "board/triaxis_runner.sv",
     "summary_q <= done_summary_i;", "summary_q <= done_summary_i & ~summary_t'(32'h8000_0000);", "Told"),
    ("a run's status is that of the run before", "board_runs", "board/triaxis_runner.sv",
     "        engine_status_q <= StatusNone;\n      end\n      if (done", "      end\n      if (done",
     "Status"),
    ("a run's trial is that of the run before", "board_runs", "board/triaxis_runner.sv",
     "trial_q <= asked.trial;", "trial_q <= trial_q;", "Asked"),
    ("a run's zones are those of the run before", "board_runs", "board/triaxis_runner.sv",
     "zones_q   <= '0;", "zones_q   <= zones_q;", "Zoned"),
    ("a run's margins in another order", "board_runs", "board/triaxis_runner.sv",
     "margins_q[z][M-1:0]", "margins_q[Zones-1-z][M-1:0]", "Handed"),
    ("errors are counted from 0 again", "board_errors", "board/triaxis_saturating_counter.sv",
     "sum[Width] ? '1 : sum[Width-1:0]", "sum[Width-1:0]", "Counted"),
    ("a bit of the payload again as it was", "board_reply", "board/triaxis_reply.sv",
     "~bytes_t'(again_q)", "~bytes_t'(again_q) ^ bytes_t'(8)", "check"),
    ("near pairs from the next one on", "board_reply", "board/triaxis_reply.sv",
     "number_q <= first_pair_i;", "number_q <= first_pair_i + 32'd1;", "check"),
    ("a reply without its CRC", "board_reply", "board/triaxis_reply.sv",
     "pairs_q == '0 ? Crc : Bytes", "pairs_q == '0 ? Next : Bytes", "KeepsOffering"),
    ("the other mesh's triangles are told", "board_reply", "board/triaxis_answer.sv",
     "? status_i.count_b : status_i.count_a", "? status_i.count_a : status_i.count_b", "check"),
    ("the other mesh's signature is told", "board_reply", "board/triaxis_answer.sv",
     "signatures_i[request_i.fields[0]]", "signatures_i[!request_i.fields[0]]", "check"),
)  # fmt: skip

# The proof of this group is the algebra of the core, or of a certificate, in the configuration named.
AXES = (
    ("wrong edge in one axis", "w16_m0", "core/triaxis_projections.sv",
     "edges_3[i][j] + across_3[i];", "edges_3[i][j] + across_3[i == 2 ? 0 : i];", "too few"),
    ("projection one register short", "w16_m0", "core/triaxis_projections.sv",
     "`TRIAXIS_STAGE(normal_a_2, normal_a_d)", "assign normal_a_2 = normal_a_d;", "several clocks"),
    ("area one bit too narrow", "w16_m0", "core/triaxis_areas.sv",
     "cross_t'(a_1[i] + across_a_1[i][j])", "cross_t'(signed'((2*W)'(a_1[i] + across_a_1[i][j])))", ""),
    ("a trapezoid with the wrong sign", "w16_m0", "core/triaxis_areas.sv",
     "cross_t'(b_1[j] + across_b_1[i][j])", "cross_t'(b_1[j] - across_b_1[i][j])", ""),
    ("differences one bit too narrow", "w16_m0", "core/triaxis_pkg.sv",
     "return w + 1;", "return w;", "too few"),
    ("axis from the wrong vertex", "w16_m0", "core/triaxis_areas.sv",
     "        .to_i  (a_i[(i+1)%3]),", "        .to_i  (a_i[(i+2)%3]),", ""),
    ("heights of another triangle", "w16_m0", "core/triaxis_prisms.sv",
     "height_t'(a_pair[i]) + height_t'(b[j])", "height_t'(a_pair[(i+1)%3]) + height_t'(b[j])", ""),
    ("the thresholds of two axes swapped", "w8_m8", "core/triaxis_thresholds.sv",
     "assign axes[AxisNormalA][k] = axis_comp_t'(normal_a_i[k]);",
     "assign axes[AxisNormalA][k] = axis_comp_t'(normal_b_i[k]);", "not the components of the axis"),
    ("interval tests that ignore their thresholds", "w8_m8", "core/triaxis_plane_axes.sv",
     "          .M(M),\n          .Comb(Comb)\n      ) u_b (",
     "          .M(0),\n          .Comb(Comb)\n      ) u_b (",
     "its M is not the core's"),
    ("operands move for decided pairs", "w16_m0", "core/triaxis_boxes.sv",
     "valid && (!Gating || separated == '0)", "valid", "gate"),
    ("a decision of the boxes one clock early", "w16_m0", "core/triaxis_datapath.sv",
     ".Cycles(TimeDecision * Stage)", ".Cycles((TimeDecision - 1) * Stage)", "several clocks"),
    ("the tag of the pair before", "w16_m0", "core/triaxis_core.sv",
     "      .T(tag_t),\n      .Cycles(Latency)\n", "      .T(tag_t),\n      .Cycles(Latency + 1)\n",
     "the tag of another pair"),
    ("two coordinates swapped at the input", "w16_m0", "core/triaxis_core.sv",
     "assign b[v][k] = s_axis_tdata_i[(9+3*v+k)*W+:W];",
     "assign b[v][k] = s_axis_tdata_i[(9+3*v+(k+1)%3)*W+:W];", "not the coordinates of its axis"),
    ("an axis at the wrong bit", "w16_m0", "core/triaxis_space_axes.sv",
     ".separated_o(separated_o[AxisEdgeEdge+3*i+j])", ".separated_o(separated_o[AxisEdgeEdge+3*j+i])",
     "axis"),
    ("a swapped port of the wrapper", "detector", "core/CollisionDetector.sv",
     "'{B1_x, B1_y, B1_z}", "'{B1_x, B1_z, B1_y}", ""),
    ("a vector by the number of the next pair", "certificate w8_m8", "core/triaxis_certifier.sv",
     "vectors[first_q]", "vectors[first_d]", "several clocks"),
    ("a projection from another vertex", "certificate w8_m8", "core/triaxis_certifier.sv",
     "points_d[3][k] = b_i[1][k] - a_i[0][k];", "points_d[3][k] = b_i[1][k] - a_i[1][k];",
     "not the projections on the axis"),
    ("a reach one clock late", "certificate w8_m8", "core/triaxis_certifier.sv",
     "ApartLatency - 1 - reach_latency", "ApartLatency - reach_latency", "at another clock"),
    ("an axis one bit too narrow", "certificate w8_m8", "core/triaxis_certifier.sv",
     "axis_comp_t plus, minus;", "logic signed [axis_width(W)-3:0] plus, minus;", "too few"),
    ("an answer one clock late", "certificate w8_m8", "core/triaxis_pkg.sv",
     "return 3 + mul_latency(diff_width", "return 4 + mul_latency(diff_width", "clocks instead of"),
)  # fmt: skip


def _proof(name: str) -> Proof:
    """Return a proof by name; by that of a configuration, or "detector", its algebra alone."""
    if name == "detector":
        return axes_proof("axes", (), detectors=(16,))
    if name.startswith("certificate "):
        return certificate((parse_configuration(name.split()[1]),))
    named = next((proof for proof in proofs() if proof.name == name), None)
    return named or axes_proof("axes", (parse_configuration(name),))


# One of each way to prove, by every run of the tests; the others take minutes.
QUICK = ("touching taken for clear", "a group's box forgets what was before", "a piece at the wrong place",
         "a HELLO leaves the number of the session before", "a frame goes on after a framing error",
         "projections one bit too narrow", *(row[0] for row in AXES))  # fmt: skip
CASES = [
    pytest.param(*row, id=name, marks=() if name in QUICK else pytest.mark.regress)
    for name, *row in BROKEN + AXES
]


def _says(finding: Finding, message: str) -> bool:
    """Return whether a proof says so: not its name, nor the path of a log, which may hold any word."""
    return any(message in problem.split(": ", 1)[1].rsplit(" (log: ", 1)[0] for problem in finding.problems)


def test_what_a_proof_says_is_neither_its_name_nor_a_path():
    unreached = Finding(("engine_checks: cover: FAIL: SeenTrial (log: /tmp/check/cover.log)",))
    assert not _says(unreached, "check") and _says(unreached, "SeenTrial")
    assert _says(Finding(("engine_checks: check: UNKNOWN: see the log (log: /tmp/check.log)",)), "check")


def test_a_stand_in_has_the_header_of_a_module_of_the_rtl():
    header = _header("triaxis_ram", DUT)
    assert header.startswith("module triaxis_ram") and header.endswith(");") and "endmodule" not in header
    with pytest.raises(InputError, match="no module triaxis_nothing"):
        _header("triaxis_nothing", DUT)


def test_faults_are_of_the_rtl_as_it_is(tmp_path):
    assert set(QUICK) <= {row[0] for row in BROKEN + AXES}
    for name, _, file, right, wrong, _ in BROKEN + AXES:
        broken_rtl(tmp_path / name, (file, right, wrong))


@pytest.mark.parametrize(("proof", "file", "right", "wrong", "message"), CASES)
def test_proof_fails(tmp_path, proof, file, right, wrong, message):
    # A proof must fail because it sees the fault, not because the tool does not come to an end.
    finding = _proof(proof).prove(broken_rtl(tmp_path, (file, right, wrong)), tmp_path / "proof")
    assert finding.result is Result.FAILED, finding
    assert _says(finding, message), finding.problems


def test_every_proof_is_seen_to_fail():
    # That of the theorem has tests of its own: no RTL breaks it.
    seen = {row[1] for row in BROKEN} | {"theorem"}
    assert {proof.name for proof in proofs() if not proof.name.startswith("axes")} <= seen


def test_what_is_not_covered_fails(tmp_path):
    # So does a window that has become too short: nothing is asserted in it, of a box that is a clock late.
    late = broken_rtl(tmp_path, ("core/triaxis_pkg.sv", "BoxLatency = 4", "BoxLatency = 5"))
    problems = _proof("box_m16").prove(late, tmp_path / "unreached").problems
    assert any("cover: FAIL: " in problem and "SeenApart" in problem for problem in problems), problems


@pytest.mark.parametrize("name", ["interval_m0", "multiply_small"])
def test_checkers_below_a_harness_count_from_its_first_clock(tmp_path, name):
    # Else what is covered is reached at once, of what registers happen to hold, and says nothing.
    proof, sources, log = _proof(name), tmp_path / "sources", tmp_path / "cover.log"
    assert isinstance(proof, SbyProof)
    sources.mkdir()
    proof._copy(DUT, sources)
    (tmp_path / "proof.sby").write_text(proof._configuration(sources))
    assert proof._run("cover", tmp_path, log) is None
    reached = re.findall(r"Reached cover statement in step (\d+)", log.read_text())
    assert reached and "0" not in reached


@pytest.mark.parametrize(
    ("proof", "file", "reason"),
    [("areas_w1", "core/triaxis_prisms.sv", "ERROR"), ("w16_m0", "core/triaxis_sum.sv", "yosys: ")],
)
def test_what_does_not_compile_is_not_decided(tmp_path, proof, file, reason):
    finding = _proof(proof).prove(broken_rtl(tmp_path, (file, "endmodule", "endmodul")), tmp_path / "proof")
    assert finding.result is Result.UNDECIDED
    assert any(reason in said for said in finding.undecided)


def _ends_silently(_: object, log: Path, *__: object) -> int:
    log.touch()
    return 0


def _is_ended(*_: object) -> int:
    raise EndedError("sby: still running")


@pytest.mark.parametrize("prover", [_ends_silently, _is_ended])
def test_a_prover_that_comes_to_no_end_decides_nothing(tmp_path, monkeypatch, prover):
    for module in ("verif.formal.proof", "sim.programs"):
        monkeypatch.setattr(f"triaxis.{module}.run_limited", prover)
    names = ("streams_m0", "verdict_w16", "axes_other", "multiply_wide")
    monkeypatch.setattr(proving, "proofs", lambda: tuple(_proof(name) for name in names))
    result = proving.prove_all(lambda step: None, folder=tmp_path)
    assert [outcome.finding.result for outcome in result.outcomes] == [Result.UNDECIDED] * len(names)
    assert not result.passed
    assert all(problem.startswith("not decided: ") for problem in result.problems)
    assert f"{len(names)} not decided" in result.summary


class _Given(Proof):
    """A proof that holds unless it is called bad."""

    def attempt(self, dut: Path, folder: Path) -> Finding:
        if self.name == "bad":
            raise NetlistError("not so")
        return Finding()


def test_one_failure_fails_all_and_a_part_is_no_evidence(tmp_path, monkeypatch):
    good = _Given("good", "a claim", "given", {}, ())
    monkeypatch.setattr(proving, "proofs", lambda: (good, replace(good, name="bad")))
    result = proving.prove_all(lambda step: None, folder=tmp_path)
    assert result.complete and not result.passed
    assert result.problems == ["bad: not so"]
    evidence = read_evidence(proving.write_result(result, "formal", tmp_path / "formal.json"))
    assert evidence is not None and not evidence["passed"]
    assert (evidence["total"], evidence["proved"]) == (2, 1)

    part = proving.prove_all(lambda step: None, only="g*", folder=tmp_path)
    assert part.passed and not part.complete
    assert not replace(part, changed=True).passed and not replace(part, outcomes=()).passed
    with pytest.raises(ValueError, match="no evidence"):
        proving.write_result(part, "formal", tmp_path / "part.json")
    with pytest.raises(InputError, match="no such proof"):
        proving.prove_all(lambda step: None, only="none", folder=tmp_path)
