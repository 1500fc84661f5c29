"""All proofs, by name: of the theory, the core, the mesh engine, and what decides go on the board."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.sim.configuration import Configuration
from triaxis.verif.formal.axis_proofs import axes_proof
from triaxis.verif.formal.certifier_proof import certificate
from triaxis.verif.formal.coq import theorem
from triaxis.verif.formal.pieces import multiply_wide
from triaxis.verif.formal.proof import Method, Proof, SbyProof
from triaxis.verif.formal.widths import widths

_WIDTH = 16
_RESET = "a reset holds at the first clock, and from then on is asserted and released at any clocks"


def _assertions(
    name: str,
    claim: str,
    modules: tuple[str, ...],
    parameters: Mapping[str, int],
    cover_depth: int,
    assumptions: tuple[str, ...] = (),
    *,
    window: int | None = None,
    beside: tuple[str, ...] = (),
    harness: str | None = None,
) -> SbyProof:
    """Return a proof of the first module, in a formal harness: by induction, or over a window of clocks.

    ``beside``: files of rtl/ that the harness needs. ``harness``: its module, where it is not called as the
    first module.
    """
    top = harness or f"{Path(modules[0]).name}_formal"
    packages = ["core/triaxis_pkg"]
    packages += ["mesh/triaxis_mesh_pkg"] if modules[0].startswith(("mesh/", "board/")) else []
    packages += ["board/triaxis_board_pkg"] if modules[0].startswith("board/") else []
    return SbyProof(
        name=name, claim=claim, method=Method.INDUCTION if window is None else Method.WINDOW, top=top,
        dut_files=tuple(f"{module}.sv" for module in (*packages, *reversed(modules))),
        formal_files=(*(f"{file}.sv" for file in beside), f"{top}.sv"), parameters=parameters,
        assumptions=(_RESET, *assumptions) if window is None else assumptions,
        depth=window or 1, cover_depth=cover_depth,
    )  # fmt: skip


# The multiplier and what it is made of.
_MULTIPLIER = ("core/triaxis_mul", "core/triaxis_narrow_mul", "core/triaxis_sum", "core/triaxis_delay")


def _streams(margin: int) -> SbyProof:
    return _assertions(
        f"streams_m{margin}",
        "For all time and under every pattern of stalls and resets: results are stable while they wait; none "
        "is lost, duplicated or out of order, each carries its own tag and verdict; the latency is the "
        "documented one exactly; one pair per clock while results are taken; a reset discards everything, "
        "and one clock after it the core is ready; never more pairs in flight than the queue has places.",
        ("core/triaxis_core", "core/triaxis_fifo", "core/triaxis_delay"),
        {"W": _WIDTH, "M": margin, "TAG": 16},
        48,
        (
            "the verdict of a pair is any nine bits, documented latency after it: the streams carry "
            "verdicts and never look at them; the proofs `axes_*` show that the data path has that latency",
        ),
        beside=("triaxis_datapath", "triaxis_stream_rules"),
    )


def _verdict(width: int) -> SbyProof:
    return _assertions(
        f"verdict_w{width}",
        "Near exactly where none of 32 free axis bits is set, otherwise the claim is the lowest one set; "
        "degenerate and coplanar exactly where the normal and all free orientations are zero; no "
        "flag of a masked pair.",
        ("core/triaxis_verdict", "core/triaxis_flags", "core/triaxis_delay"),
        {"W": width, "NormalWait": 9, "DetWait": 6},
        14,
        window=13,
    )


_CERTIFIED = "core/triaxis_certified_core"
# Where a bit can be inverted, once: a kept pair, its place in the core and after it, a claim, a result.
_UPSETS = (
    (
        "logic [PlaceWidth-1:0] core_place, place_q;",
        "logic [PlaceWidth-1:0] core_place, place_q, sent_place, free_place, free_late_place;\n"
        "  assign core_place = sent_place ^ free_place;\n  kept_pair_t free_kept;",
    ),
    (".m_axis_tuser_o (core_place)", ".m_axis_tuser_o (sent_place)"),
    ("kept_q <= pairs_q[core_place];", "kept_q <= pairs_q[core_place] ^ free_kept;"),
    ("place_q <= core_place;", "place_q <= core_place ^ free_late_place;"),
    (
        "assign shown = claims_q[Wait-1];",
        "claim_t free_claim;\n  assign shown = claims_q[Wait-1] ^ free_claim;\n"
        "  kept_result_t free_result, pushed;\n  assign pushed = made ^ free_result;",
    ),
    (".data_i (made)", ".data_i (pushed)"),
)


def _certified(name: str, width: int, claim: str, upset: bool, *assumptions: str) -> SbyProof:
    proof = _assertions(
        name,
        claim,
        (_CERTIFIED, "core/triaxis_core", "core/triaxis_fifo", "core/triaxis_delay"),
        {"W": width, "M": width, "TAG": width, "Upset": int(upset)},
        68,
        (
            "verdicts of the data path and answers of the certifier are any, at each clock: a verdict is "
            "that of the pair accepted the documented latency before (`axes_*`), an answer that to what was "
            "given its own latency before (`certificate`)",
            *assumptions,
        ),
        beside=("triaxis_certified_surroundings", "triaxis_stream_rules"),
    )
    return replace(proof, edits={f"{_CERTIFIED}.sv": _UPSETS} if upset else {})


def certified_proofs() -> tuple[SbyProof, ...]:
    """Return the proofs of the certified core."""
    return (
        _certified(
            "certified_upset",
            8,
            "For all time and under every pattern of stalls and resets: with one bit inverted once, at any "
            "clock, of what is kept of a pair, its place in the core and after it, a claim on its way, or a "
            "result that waits, a pair that is near is answered near, in its turn.",
            True,
            "nothing holds of a pair that is near: `certificate`, and the axes' own theory",
            "all pairs try nothing, and memories are zeros at power-up; what counts and what says that a "
            "stage holds a pair is not inverted",
            "where a word waits or moves on, its bit is inverted at the latest when it is looked at: nothing "
            "looks at it before",
        ),
        _certified(
            "certified",
            _WIDTH,
            "For all time and under every pattern of stalls and resets: clear is answered only of a pair "
            "whose claim was clear, or was tried, and for which the certifier, given exactly its vertices, "
            "its margin and the claimed axis, said that it holds; a fault is told exactly where a clear "
            "claim does not hold or a check was tried, and then the pair is near; else verdict, flags and "
            "axis are the core's. Results are stable while they wait; none is lost, duplicated or out of "
            "order, each carries its own tag; the latency is the documented one exactly; one pair per clock "
            "while results are taken; a reset discards everything; never more in flight than places. What is "
            "kept where nothing is on offer is not intact.",
            False,
        ),
    )


def _intervals(margin: int) -> SbyProof:
    return _assertions(
        f"interval_m{margin}",
        "An interval test separates exactly where all points lie beyond 0 and the triangle's own other end "
        "by more than the threshold, on one side, strictly, for free projections and thresholds.",
        ("core/triaxis_interval",),
        {"W": _WIDTH, "M": margin},
        5,
        ("the end moved by the threshold fits: shown by the proofs `axes_*`",),
        window=4 if margin else 3,
    )


def _box(margin: int) -> SbyProof:
    return _assertions(
        f"box_m{margin}",
        "A box test separates exactly where all gaps of the nine pairs of vertices, one way or the other, "
        "exceed the margin, for free coordinates and margins.",
        ("core/triaxis_box", "core/triaxis_extent", "core/triaxis_delay"),
        {"W": _WIDTH, "M": margin},
        6,
        window=5,
    )


def _threshold(name: str, components: int, size: int, margin: int, depth: int, exact: bool) -> SbyProof:
    product = (
        "the threshold is their product" if exact else "the threshold is what the multiplier makes of them"
    )
    return _assertions(
        name,
        "The sum of the absolutes of free components and the free margin reach the multiplier exactly, at "
        f"one clock, and {product}.",
        ("core/triaxis_threshold", *_MULTIPLIER),
        {"Components": components, "CWidth": size, "M": margin, "Exact": int(exact)},
        depth + 1,
        ("the sum of absolutes fits: shown by the proofs `axes_*`",),
        window=depth,
    )


def _reach(name: str, width: int, margin: int, depth: int, exact: bool) -> SbyProof:
    product = "the reach is their product" if exact else "the reach is what the multiplier makes of them"
    return _assertions(
        name,
        "In the certifier the sum of the absolutes of an axis's free components and the free margin reach "
        f"the multiplier exactly, at one clock, and {product}.",
        ("core/triaxis_reach", *_MULTIPLIER),
        {"W": width, "M": margin, "Exact": int(exact)},
        depth + 1,
        ("the sum of absolutes fits, none being the lowest number: shown by `certificate`",),
        window=depth,
    )


def _apart(name: str, width: int, margin: int, nine: bool) -> SbyProof:
    exactly = (
        "all nine differences of a projection of B and one of A, or all nine the other way, exceed the reach"
        if nine
        else "the lowest projection of one lies above the highest of the other by more than the reach, as "
        "whole numbers (so all nine differences do)"
    )
    return _assertions(
        name,
        f"The certifier finds two triangles apart on an axis exactly where {exactly}, strictly, for free "
        "projections and reaches.",
        ("core/triaxis_apart",),
        {"W": width, "M": margin, "Nine": int(nine)},
        6,
        (
            "projections are from the first vertex of A, and the nine differences fit: shown by the proof "
            "`certificate`",
        ),
        window=5,
    )


def _multiply() -> SbyProof:
    proof = _assertions(
        "multiply_small",
        "The multiplier gives the product of its operands at the documented latency, whole and split into "
        "three or four pieces, straight and swapped.",
        _MULTIPLIER,
        {},
        7,
        (
            "the ports of a DSP block have 4 x 3 bits in the copy that is proved, and narrow pieces 2, so "
            "that small operands are split",
        ),
        window=6,
    )
    ports = (("DspPortA = 25", "DspPortA = 4"), ("DspPortB = 18", "DspPortB = 3"))
    ports += (("NarrowBits = 5", "NarrowBits = 2"),)
    return replace(proof, edits={"core/triaxis_pkg.sv": ports})


def _skip(name: str, width: int, whole: bool) -> SbyProof:
    claim = (
        "A box of A, moved, is skipped exactly where one axis separates it from the box of B by more than "
        "the widest margin, and boxes around two boxes only where these are, for all boxes, translations and "
        "margins of few bits."
        if whole
        else "Every sum and every comparison behind a skip is that of whole numbers; boxes around two boxes "
        "are skipped only where these are; a run is refused exactly where A moved leaves the range."
    )
    return _assertions(
        name,
        claim,
        ("mesh/triaxis_overlap", "mesh/triaxis_grow", "mesh/triaxis_run_control"),
        {"W": width, "M": width, "Whole": int(whole)},
        5,
        ("what was asked for is not exchanged while a run compares boxes: it is taken on acceptance alone",),
        window=4,
    )


# The engine, from its top down to what it compares.
_WALK = (
    *(
        f"mesh/triaxis_{module}"
        for module in (
            "mesh", "walk", "run_control", "near_pairs", "pair_fetch", "pair_boxes", "pick", "group_words",
            "group_rows", "stream_fifo", "lane_mask", "overlap", "grow",
        )
    ),
    "core/triaxis_fifo",
)  # fmt: skip


_EXTENT = ("core/triaxis_extent", "core/triaxis_delay")
# A mesh in memory, without its memories.
_MESH = ("mesh/triaxis_mesh_store", "mesh/triaxis_mesh_scrub", "mesh/triaxis_mesh_intake", *_EXTENT)
_STORE = (*_MESH, "mesh/triaxis_parity_ram", "mesh/triaxis_ram")


def _walk() -> SbyProof:
    proof = _assertions(
        "engine_walk",
        "For all time and under every pattern of stalls, aborts and resets: of a run that is said to be "
        "complete each pair of triangles was handed to the core, once, or again in a narrower zone, with "
        "the vertices that are stored, A's moved as asked, and the margin of the zone, and verdicts of all "
        "that was handed over were taken; its last one is that it is near, of the margin itself, and then "
        "the run says that something is in each zone, or that it is clear, of a margin no less than that of "
        "each zone in which the run says that nothing is, which is never one that is no wider than the one "
        "within it; or its boxes, or those of its groups or of the "
        "whole of B around them, lie apart on one axis by more than the widest margin. Each pair that is to "
        "be asked again is, in the next clock, before any that is new; no more are on their way to a verdict "
        "than can be counted. While a mesh is scrubbed no run goes on, and nothing of it "
        "is read.",
        _WALK,
        {"W": 4, "M": 4, "Depth": 16, "Group": 4, "Lanes": 2},
        30,
        (
            "queues of four places in the copy that is proved, as in `engine_queue`, and a core of two; what "
            "is on its way is counted for a core of any latency by the same formula",
            "what is read of a memory is what was written: `engine_memory`; it is read where a run asks, and "
            "boxes lie around their triangles: `engine_boxes`",
            "the core gives one verdict a pair, in order and with its own tag, at any time, and takes a pair "
            "a clock as long as verdicts are taken at once: `streams`, `certified`",
        ),
        beside=("triaxis_mesh_surroundings",),
    )
    few = {
        "mesh/triaxis_walk.sv": (("QueueDepth = 16", "QueueDepth = 4"),),
        "mesh/triaxis_mesh.sv": (
            ("CoreLatency = Certify ? certified_latency(W, M) : core_latency(W, M);", "CoreLatency = 2;"),
        ),
    }
    return replace(proof, edits=few)


def _checks() -> SbyProof:
    return _assertions(
        "engine_checks",
        "For all time and under every pattern of stalls and resets: where the walks differ, or the intakes "
        "of a mesh, where something rests on a word that is not intact, a mesh is not as it was loaded, or "
        "the core tells a fault, a fault is told two clocks later at the latest, and until it is "
        "acknowledged; the run of then, and each that begins before that, ends with that status, whatever "
        "the walks say, and so does one whose walks differ in its summary; else the status is that of the "
        "first walk, and no fault is told. Of a run that is over the status stays, whatever comes. Meshes "
        "are scrubbed between runs, and only then. A run that tries the walks ends in a fault where these do "
        "the same in any of its clocks before; what is tried of memories, intakes, scrub and core is just "
        "what was asked for, until it is acknowledged or a mesh is found broken.",
        ("mesh/triaxis_mesh",),
        {"W": 4, "M": 4, "Depth": 16, "Group": 4, "Lanes": 2},
        12,
        (
            "what walks show of a summary is that summary, and all else that they do shows: `engine_twice`",
            "a walk that has ended a run says something of it, and no fault: `engine_control`",
            "nothing is broken or refuted when the first walk has ended its run: `engine_walk`",
        ),
        beside=("triaxis_checks_surroundings",),
        harness="triaxis_checks_formal",
    )


def _twice() -> SbyProof:
    return _assertions(
        "engine_twice",
        "Whatever one walk asks of a memory or of the core, or says, that the other does not, shows as a "
        "difference in the next clock, and what it says of a summary at once; whatever one intake counts, "
        "writes or says of a mesh that the other does not, too; for any states of the two. In a reset they "
        "are alike.",
        (*_WALK, *_MESH),
        {"W": 8, "M": 8, "Depth": 16, "Group": 4, "Lanes": 2},
        3,
        ("the box of a mesh counts where it has triangles that have settled: `engine_walk`",),
        window=2,
        beside=("triaxis_twice_surroundings",),
        harness="triaxis_twice_formal",
    )


# Where bits can be inverted: of a word as it is read, of where it is read, and of where it is held to be.
_PARITY_UPSETS = (
    (
        "word_t written, found;",
        "word_t written, found, kept, free_word;\n  assign found = kept ^ free_word;\n"
        "  logic [AddressWidth-1:0] free_read, free_late;",
    ),
    (".read_address_i,\n      .read_data_o (found)",
     ".read_address_i(read_address_i ^ free_read),\n      .read_data_o (kept)"),
    ("assign due[i] = ^{", "assign due[i] = ^free_late ^ ^{"),
)  # fmt: skip


def _parity(name: str, pieces: int, words: int) -> SbyProof:
    proof = _assertions(
        name,
        f"For all time: of a memory of words of {pieces} pieces a word that is read as it was written, where "
        "it was, is intact; with any one bit of it, of its parity, of the address that it is read at or of "
        "the one that is remembered inverted it is not, and neither is it on trial.",
        ("mesh/triaxis_parity_ram", "mesh/triaxis_ram"),
        {"Pieces": pieces, "PieceWidth": _WIDTH, "Words": words},
        6,
    )
    return replace(
        proof, assumptions=(), cover_from_reset=False, edits={"mesh/triaxis_parity_ram.sv": _PARITY_UPSETS}
    )


# What a triangle makes of a CRC.
_ANY_CRC = (
    ("came_q <= after_triangle(came_q, triangle_i);", "came_q <= free_came;"),
    ("assign crc_d = after_triangle(crc_q, triangle_read_i);", "assign crc_d = free_crc;"),
    ("logic [31:0] came_q;", "logic [31:0] came_q, free_came, free_crc;"),
)


def _scrub() -> SbyProof:
    proof = _assertions(
        "engine_scrub",
        "For all time and under every pattern of loads, pauses and resets: a mesh is scrubbed a triangle a "
        "clock, in order, over and over from the last load on, so each within as many of these clocks as "
        "there are triangles. In the clock after it was read, if nothing is loaded then, a triangle is found "
        "broken exactly where a word is not intact, a vertex is outside its box, that outside its group's, "
        "or, of the last one, the CRC of all that was read is not that of all that was pushed; so nothing is "
        "of a mesh that is as it was pushed, and within its boxes. What is tried of a bound is found at each "
        "triangle of such a mesh, what is tried of the CRC at its last.",
        ("mesh/triaxis_mesh_scrub",),
        {"W": _WIDTH, "Depth": 8},
        12,
        (
            "a mesh counts what it is given: `engine_boxes`",
            "what a triangle makes of a CRC is anything, but the same of the same, of what is pushed as of "
            "what is read: `engine_signature`",
        ),
        harness="triaxis_scrub_formal",
    )
    return replace(proof, edits={"mesh/triaxis_mesh_scrub.sv": _ANY_CRC})


def engine_proofs() -> tuple[SbyProof, ...]:
    """Return the proofs of the mesh engine."""
    return (
        _walk(),
        _checks(),
        _twice(),
        _skip("engine_skip", _WIDTH, whole=False),
        _skip("engine_skip_small", 4, whole=True),
        _assertions(
            "engine_boxes",
            "A mesh counts the triangles that it is given, and writes each at its number; the box of a "
            "group, and that of the mesh, is the smallest around its triangles' boxes, by induction over "
            "the triangles. A run reads each memory where it asks; the scrub a triangle with its own box and "
            "that of its group, when all is written.",
            _STORE,
            {"W": _WIDTH, "Depth": 16, "Group": 4, "Lanes": 2},
            8,
            ("while a mesh is scrubbed no run reads: `engine_walk`",),
            window=5,
        ),
        replace(
            _assertions(
                "engine_intakes",
                "For all time and under every pattern of loads and resets: the two intakes of a mesh, "
                "whatever their registers begin with, show no difference but where one is misread; that is "
                "told.",
                _STORE,
                {"W": _WIDTH, "Depth": 16, "Group": 4, "Lanes": 2},
                8,
                harness="triaxis_intakes_formal",
            ),
            # As many clocks as a triangle is under way, and one.
            depth=4,
        ),
        _scrub(),
        _assertions(
            "engine_signature",
            "From any CRC, with any triangle, what is made of it is the remainder of the division by the "
            "polynomial of CRC-32, over nine coordinates with their signs, each the lowest byte first: of "
            "what is pushed, from ones on after a reset and when it is cleared, and of what is read. The "
            "signature is the complement of the first.",
            ("mesh/triaxis_mesh_scrub",),
            {"W": 12, "Depth": 8},
            3,
            window=2,
            harness="triaxis_signature_formal",
        ),
        replace(
            _assertions(
                "engine_memory",
                "For all time: a word that is read of a memory is the one that was written last at its "
                "address, and stays until the next read.",
                ("mesh/triaxis_ram",),
                {"Width": 9 * _WIDTH, "Words": 4096},
                6,
            ),
            assumptions=(),
            cover_from_reset=False,
        ),
        _parity("engine_parity", 9, 4096),
        _parity("engine_parity_boxes", 6, 512),
        _assertions(
            "engine_queue",
            "For all time and under every pattern of stalls and resets: a queue between two streams loses, "
            "duplicates and reorders nothing; a word that waits stays; it is ready exactly where it "
            "has room, one clock after a reset.",
            ("mesh/triaxis_stream_fifo", "core/triaxis_fifo"),
            {"Width": 8, "Depth": 4},
            12,
            beside=("triaxis_stream_rules",),
        ),
        _assertions(
            "engine_pick",
            "For all time: of each mask every lane comes once, the lowest first, with its word and without "
            "gaps; draining leaves nothing.",
            ("mesh/triaxis_pick",),
            {"Width": 8, "Lanes": 8},
            12,
            ("masks are not zero: words without a lane are not valid where they come from",),
        ),
        _assertions(
            "engine_control",
            "For all time: a summary waits unchanged, and stays until the next run; it says complete only "
            "of a run that was neither aborted nor ended early and in whose last clock nothing was left to "
            "do; an abort is said; what is refused was not run; cycles are those since acceptance, or the "
            "largest number. The margin itself is the one asked for; each outer zone has the margin asked "
            "for it, or is as wide as the one within it where that is wider; boxes are moved by the widest "
            "when the scan begins. Which zones are wider than the one within is told rightly, and the same "
            "from the clock after the run is accepted on.",
            ("mesh/triaxis_run_control",),
            {"W": 8, "M": 8, "CycleBits": 4},
            24,
            ("once a run has ended at its first near pair it keeps saying so: shown by `engine_near`",),
        ),
        _assertions(
            "engine_near",
            "For all time: each near pair is offered once, in order, unchanged until it is taken; none "
            "after the first where one was asked for, none where only counts were; the counts are those of "
            "the pairs' last verdicts; idle means nothing on offer and nothing on its way. Each verdict "
            "that is near in an outer zone has its pair asked again, in a narrower one, unless the run is "
            "over; pairs are asked in the widest zone that is wider than the one within and in which "
            "nothing was found. Of each outer zone the run says that something is in it exactly where a "
            "verdict was near in it or within, or it is no wider when the run begins.",
            ("mesh/triaxis_near_pairs",),
            {"IndexWidth": 15, "InFlight": 66},
            12,
            (
                "no more verdicts than pairs that were issued, and no more of these on their way than the "
                "core's queue and the two steps before it hold: shown by `engine_walk`",
                "a verdict is of one of the zones: shown by `engine_walk`",
                "a run starts when the last one is over, so when all is idle",
                "which zones are wider is told when it starts: shown by `engine_control`",
            ),
        ),
    )


# The board, from its packages up to its top, without what stands in for it.
_BOARD = (
    "core/triaxis_pkg", "mesh/triaxis_mesh_pkg", "board/triaxis_board_pkg",
    *(
        f"board/triaxis_{module}"
        for module in (
            "reset_sync", "session", "judge", "loader", "command", "watchdog", "runner", "saturating_counter",
            "answer", "safety", "beat",
        )
    ),
    "board/nexys4ddr_top",
)  # fmt: skip

# As it ships: of the top's own times those that go rests on.
_BOARD_SIZES = {
    "W": _WIDTH, "M": _WIDTH, "Depth": 4096, "WatchdogClocks": 10_000_000, "HoldClocks": 100_000,
}  # fmt: skip


def _board_twice() -> SbyProof:
    return SbyProof(
        name="board_twice",
        claim="Whatever the one of two does, the other permits nothing but from the end of a complete run "
        "that found nothing near, to the deadline that it counts itself, and on its own sign of life, with "
        "no change, error or fault since; go is that of the one, stop the contrary of the other; what is "
        "beyond a zone both must say, each with its own go alone, of what the run that began it found; for "
        "any states of the two. Two runners that differ in anything that they say or ask for, a byte that "
        "is broken, and what is tried of these, are a fault in the next clock, and nothing else is, until "
        "the next HELLO; a fault is told to the host, and so are margin, pose, zones and number of the "
        "first, whole.",
        method=Method.WINDOW,
        parameters=_BOARD_SIZES,
        assumptions=("the engine tells its faults: `engine_checks`; a frame its own: `board_frame`",),
        top="triaxis_board_twice_formal",
        dut_files=tuple(f"{file}.sv" for file in _BOARD),
        formal_files=("triaxis_board_surroundings.sv", "triaxis_board_twice_formal.sv"),
        depth=2,
        cover_depth=3,
    )


def _board_go() -> SbyProof:
    return SbyProof(
        name="board_go",
        claim="For all time, from power-up: go is said only where the last run that the engine ended was "
        "complete and found nothing near, and its hold, if it has one, is not over; a run that has begun "
        "since then holds; both are as they were acknowledged to the host: pose, margins, mode and trial "
        "asked for; the meshes are those acknowledged, byte by byte, as many triangles as the runs named, "
        "and nothing was loaded since; no frame was damaged or refused since the last run was asked for; a "
        "command that was no repeat was acknowledged at most WatchdogClocks + 1 clocks ago; and no fault "
        "stands, or has come since that run was asked for, and a fault stands until a HELLO. Go lasts until "
        "one of these ends it, whatever was found in the outer zones; beyond a zone is said exactly with "
        "go, where the last run that ended looked at it and found nothing in it. Go and stop always differ; "
        "the beat ends with go. The signatures that a LOAD is answered with are the engine's.",
        method=Method.INDUCTION,
        parameters=_BOARD_SIZES,
        assumptions=(
            "frames are whole, have their CRC and stay until they are released: shown by `board_frame`, "
            "`board_slip` and `board_bytes`; they come at any clocks",
            "the engine takes nothing during a run, and ends it once: shown by `engine_control`; it counts "
            "and places triangles: shown by `engine_boxes`; what it says of a run is free, and is what the "
            "other proofs of the engine and the core make of it",
            "replies leave at any pace, and what RESULTS may ask for is anything",
        ),
        top="triaxis_go_formal",
        dut_files=tuple(f"{file}.sv" for file in _BOARD),
        formal_files=("triaxis_board_surroundings.sv", "triaxis_go_formal.sv"),
        depth=1,
        cover_depth=10,
        cover_from_reset=False,
    )


def _board_reply() -> SbyProof:
    return replace(
        _assertions(
            "board_reply",
            "For all time: a request is answered once, with the head and the payload that the protocol "
            "gives that answer, every byte at its place, the payload again inverted, the near pairs "
            "of the ring from the number asked for, and their own CRC-32; nothing else is sent. A byte is "
            "offered in each clock, or in the one after it, until all are sent.",
            ("board/triaxis_reply", "board/triaxis_answer", "board/triaxis_crc32"),
            {"IndexWidth": 12},
            4,
            (
                "only a LOAD is refused for its place, and only known commands are executed: shown by "
                "`board_go`",
                "the ring gives the pair of a number a clock after that: words of a memory, shown by "
                "`engine_memory`",
            ),
        ),
        cover_from_reset=False,
    )


def board_proofs() -> tuple[SbyProof, ...]:
    """Return the proofs of what the board's go rests on, the longest first."""
    return (
        _board_go(),
        _board_twice(),
        replace(
            _assertions(
                "board_bytes",
                "For all time and for any line: a byte is given exactly where one was, each of its bits as "
                "the line was in the middle of it, after a start bit and before a stop bit; without a stop "
                "bit it is an error, told once.",
                ("board/triaxis_uart_rx",),
                {"ClocksPerThreeBits": 25},
                54,
            ),
            cover_from_reset=False,
        ),
        replace(
            _assertions(
                "board_line",
                "For all time and for any bytes: each that is accepted is on the line from the next clock "
                "on, start bit, its bits, stop bit, each as long as the rate says to a clock; then the next "
                "is accepted; the line is high besides.",
                ("board/triaxis_uart_tx",),
                {"ClocksPerThreeBits": 25},
                3,
            ),
            cover_from_reset=False,
        ),
        replace(
            _assertions(
                "board_ring",
                "For all time: the ring takes every near pair until it holds 1,024, and those that it holds "
                "are given by their numbers, which have 32 bits; what finds no place waits, or is dropped "
                "where a run is aborted.",
                ("board/triaxis_near_ring", "mesh/triaxis_ram"),
                {"Width": 24, "Entries": 1024},
                3,
                ("pairs are freed up to one that is held, or to the next: no other RESULTS is executed",),
            ),
            cover_from_reset=False,
        ),
        replace(
            _assertions(
                "board_frame",
                "For all time and under any bytes, ends and errors: a frame that is handed out is what came "
                "between two ends, 13 to 256 bytes, unchanged until it is released, its last four the "
                "complement of the remainder of the others divided by the polynomial of CRC-32; every such "
                "frame is handed out unless it came while another was held; every other is told as an error. "
                "A byte of it that is shown is told as broken where one bit of it or of its parity is "
                "inverted, or that is tried, and otherwise not.",
                ("board/triaxis_frame_rx", "board/triaxis_crc32"),
                {},
                18,
                ("of byte, end and error one comes at a time: shown by `board_slip`",),
            ),
            edits={
                "board/triaxis_frame_rx.sv": (
                    (
                        "logic parity, shown;\n  assign {parity, data_o} = memory_q[address_i];",
                        "logic parity, shown;\n  logic [8:0] free_inverted;\n"
                        "  assign {parity, data_o} = memory_q[address_i] ^ free_inverted;",
                    ),
                )
            },
        ),
        _assertions(
            "board_slip",
            "For all time and for any line: nothing is given but from an END on and up to what is wrong or "
            "the next END, and what is wrong is told; what the encoder makes of a frame is given back byte "
            "by byte, with an end and without an error.",
            ("board/triaxis_slip_rx", "board/triaxis_slip_tx"),
            {},
            6,
            ("frames for the encoder stay as they are until they are taken",),
        ),
        _assertions(
            "board_runs",
            "For all time: what is said of a run is what the engine said at its end, every number of the "
            "summary and the zones whole, until the next run or HELLO, and zeros before; the run is the one "
            "that was asked for, pose, margins, trial and hold included, and its number counts the runs "
            "since HELLO.",
            ("board/triaxis_runner",),
            {"W": _WIDTH, "M": _WIDTH},
            10,
            (
                "commands come one at a time, none but ABORT during a run: shown by `board_go`",
                "the engine ends a run once: shown by `engine_control`",
            ),
        ),
        replace(
            _assertions(
                "board_errors",
                "For all time: the count of errors grows by what happens in a clock, two things at most, and "
                "stays at the largest number that it can show.",
                ("board/triaxis_saturating_counter",),
                {"Width": 12},
                3,
            ),
            cover_from_reset=False,
        ),
    )


@cache
def proofs() -> tuple[Proof, ...]:
    """Return all proofs, the longest first, so that two at a time end together."""
    margins = tuple(Configuration(width, width) for width in range(MIN_WIDTH, MAX_WIDTH + 1))
    without_margins = tuple(Configuration(width, 0) for width in (8, 13, 16, 24, 32))
    other = (
        *without_margins,
        Configuration(13, 4),
        Configuration(16, 8),
        Configuration(24, 10),
        # Margins by additions, and on the wider port of a multiplier.
        Configuration(32, 3),
        Configuration(32, 20),
        Configuration(16, 0, edge_box=False),
        Configuration(16, 0, gating=False),
    )
    return (
        _board_reply(),
        axes_proof("axes_margins", margins),
        axes_proof("axes_other", other, detectors=(8, 16, 32)),
        _apart("apart_m16", _WIDTH, _WIDTH, nine=False),
        certificate(),
        *certified_proofs(),
        _streams(0),
        _streams(_WIDTH),
        _intervals(_WIDTH),
        _multiply(),
        _intervals(0),
        _box(_WIDTH),
        _box(0),
        _threshold("threshold_space", 3, 34, _WIDTH, 8, exact=False),
        _threshold("threshold_plane", 2, 17, _WIDTH, 6, exact=False),
        _threshold("threshold_small", 3, 5, 3, 7, exact=True),
        _apart("apart_m0", _WIDTH, 0, nine=True),
        _apart("apart_small", 1, 1, nine=True),
        _reach("reach", _WIDTH, _WIDTH, 8, exact=False),
        _reach("reach_small", 2, 5, 7, exact=True),
        *engine_proofs(),
        *board_proofs(),
        *(_verdict(width) for width in (_WIDTH, 24, MAX_WIDTH)),
        _assertions(
            "areas_w1",
            "The areas of three vertices and the volumes of four, multipliers included, are the determinants "
            "of the definition, for each kind of them. Being affine in each coordinate, they are known by "
            "two values of each.",
            (
                "core/triaxis_areas",
                "core/triaxis_trapezoid",
                "core/triaxis_prisms",
                "core/triaxis_projections",
                *_MULTIPLIER,
            ),
            {"W": 1},
            1,
            window=1,
        ),
        _assertions(
            "multiply_narrow",
            "The multiplier of narrow pieces gives the product of its operands, for pieces of 1 to 5 bits.",
            ("core/triaxis_narrow_mul",),
            {"Wide": 6},
            4,
            window=3,
        ),
        multiply_wide(),
        widths(),
        theorem(),
    )
