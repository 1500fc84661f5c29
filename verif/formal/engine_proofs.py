"""The mesh engine's proofs: of its walks and checks, meshes in memory, queues, and what a run says."""

from triaxis.verif.formal.proof import WIDTH, SbyProof, harness_proof

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


def _skip(name: str, width: int, whole: bool) -> SbyProof:
    claim = (
        "A box of A, moved, is skipped exactly where one axis separates it from the box of B by more than "
        "the widest margin, and boxes around two boxes only where these are, for all boxes, translations and "
        "margins of few bits."
        if whole
        else "Every sum and every comparison behind a skip is that of whole numbers; boxes around two boxes "
        "are skipped only where these are; a run is refused exactly where A moved leaves the range."
    )
    return harness_proof(
        name,
        claim,
        ("mesh/triaxis_overlap", "mesh/triaxis_grow", "mesh/triaxis_run_control"),
        {"W": width, "M": width, "Whole": int(whole)},
        4,
        ("what was asked for is not exchanged while a run compares boxes: it is taken on acceptance alone",),
        window=True,
    )


def _walk() -> SbyProof:
    few = {
        "mesh/triaxis_walk.sv": (("QueueDepth = 16", "QueueDepth = 4"),),
        "mesh/triaxis_mesh.sv": (
            ("CoreLatency = Certify ? certified_latency(W, M) : core_latency(W, M);", "CoreLatency = 2;"),
        ),
    }
    return harness_proof(
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
        edits=few,
    )


def _checks() -> SbyProof:
    return harness_proof(
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
            "all that walks do shows a clock later: `engine_twice`",
            "a walk that has ended a run says something of it, and no fault: `engine_control`",
            "nothing is broken or refuted when the first walk has ended its run: `engine_walk`",
        ),
        beside=("triaxis_checks_surroundings",),
        harness="triaxis_checks_formal",
    )


def _twice() -> SbyProof:
    return harness_proof(
        "engine_twice",
        "Whatever one walk asks of a memory or of the core, or says, that the other does not, shows as a "
        "difference in the next clock; whatever one intake counts, writes or says of a mesh that the other "
        "does not, too; for any states of the two. After a reset they are alike.",
        (*_WALK, *_MESH),
        {"W": 8, "M": 8, "Depth": 16, "Group": 4, "Lanes": 2},
        2,
        ("the box of a mesh counts where it has triangles that have settled: `engine_walk`",),
        window=True,
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
    return harness_proof(
        name,
        f"For all time: of a memory of words of {pieces} pieces a word that is read as it was written, where "
        "it was, is intact; with any one bit of it, of its parity, of the address that it is read at or of "
        "the one that is remembered inverted it is not, and neither is it on trial.",
        ("mesh/triaxis_parity_ram", "mesh/triaxis_ram"),
        {"Pieces": pieces, "PieceWidth": WIDTH, "Words": words},
        6,
        resets=False,
        edits={"mesh/triaxis_parity_ram.sv": _PARITY_UPSETS},
        cover_from_reset=False,
    )


# What a triangle makes of a CRC.
_ANY_CRC = (
    (
        "assign crc_d = after_triangle(push_i ? came_q : crc_q, push_i ? triangle_i : triangle_read_i);",
        "logic [31:0] free_crc;\n  assign crc_d = free_crc;",
    ),
)


def _scrub() -> SbyProof:
    return harness_proof(
        "engine_scrub",
        "For all time and under every pattern of loads, pauses and resets: a mesh is scrubbed a triangle a "
        "clock, in order, over and over from the last load on, so each within as many of these clocks as "
        "there are triangles. In the clock after it was read, if nothing is loaded then, a triangle is found "
        "broken exactly where a word is not intact, a vertex is outside its box, that outside its group's, "
        "or, of the last one, the CRC of all that was read is not that of all that was pushed; so nothing is "
        "of a mesh that is as it was pushed, and within its boxes. What is tried of a bound is found at each "
        "triangle of such a mesh, what is tried of the CRC at its last.",
        ("mesh/triaxis_mesh_scrub",),
        {"W": WIDTH, "Depth": 8},
        12,
        (
            "a mesh counts what it is given: `engine_boxes`",
            "what a triangle makes of a CRC is anything, but the same of the same, of what is pushed as of "
            "what is read: `engine_signature`",
        ),
        harness="triaxis_scrub_formal",
        edits={"mesh/triaxis_mesh_scrub.sv": _ANY_CRC},
    )


def engine_proofs() -> tuple[SbyProof, ...]:
    """Return the proofs of the mesh engine."""
    return (
        _walk(),
        _checks(),
        _twice(),
        _skip("engine_skip", WIDTH, whole=False),
        _skip("engine_skip_small", 4, whole=True),
        harness_proof(
            "engine_boxes",
            "A mesh counts the triangles that it is given, and writes each at its number; the box of a "
            "group, and that of the mesh, is the smallest around its triangles' boxes, by induction over "
            "the triangles. A run reads each memory where it asks; the scrub a triangle with its own box and "
            "that of its group, when all is written.",
            _STORE,
            {"W": WIDTH, "Depth": 16, "Group": 4, "Lanes": 2},
            5,
            ("while a mesh is scrubbed no run reads: `engine_walk`",),
            window=True,
        ),
        harness_proof(
            "engine_intakes",
            "For all time and under every pattern of loads and resets: the two intakes of a mesh, "
            "whatever their registers begin with, show no difference but where one is misread; that is "
            "told.",
            _STORE,
            {"W": WIDTH, "Depth": 16, "Group": 4, "Lanes": 2},
            8,
            harness="triaxis_intakes_formal",
            # As many clocks as a triangle is under way, and one.
            depth=4,
        ),
        _scrub(),
        harness_proof(
            "engine_signature",
            "From any CRC, with any triangle, what is made of it is the remainder of the division by the "
            "polynomial of CRC-32, over nine coordinates with their signs, each the lowest byte first: of "
            "what is pushed, from ones on after a reset and when it is cleared, and of what is read. The "
            "signature is the complement of the first.",
            ("mesh/triaxis_mesh_scrub",),
            {"W": 12, "Depth": 8},
            2,
            window=True,
            harness="triaxis_signature_formal",
        ),
        harness_proof(
            "engine_memory",
            "For all time: a word that is read of a memory is the one that was written last at its "
            "address, and stays until the next read.",
            ("mesh/triaxis_ram",),
            {"Width": 9 * WIDTH, "Words": 4096},
            6,
            resets=False,
            cover_from_reset=False,
        ),
        _parity("engine_parity", 9, 4096),
        _parity("engine_parity_boxes", 6, 512),
        harness_proof(
            "engine_queue",
            "For all time and under every pattern of stalls and resets: a queue between two streams loses, "
            "duplicates and reorders nothing; a word that waits stays; it is ready exactly where it "
            "has room, one clock after a reset.",
            ("mesh/triaxis_stream_fifo", "core/triaxis_fifo"),
            {"Width": 8, "Depth": 4},
            12,
            beside=("triaxis_stream_rules",),
        ),
        harness_proof(
            "engine_pick",
            "For all time: of each mask every lane comes once, the lowest first, with its word and without "
            "gaps; draining leaves nothing.",
            ("mesh/triaxis_pick",),
            {"Width": 8, "Lanes": 8},
            12,
            ("masks are not zero: words without a lane are not valid where they come from",),
        ),
        harness_proof(
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
        harness_proof(
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
