"""The core's proofs by assertions: of its streams, of the certified core, and of the modules of both."""

from triaxis.golden.pairs import MAX_WIDTH
from triaxis.verif.formal.proof import WIDTH, SbyProof, harness_proof

# The multiplier and what it is made of.
_MULTIPLIER = ("core/triaxis_mul", "core/triaxis_narrow_mul", "core/triaxis_sum", "core/triaxis_delay")


def _streams(margin: int) -> SbyProof:
    return harness_proof(
        f"streams_m{margin}",
        "For all time and under every pattern of stalls and resets: results are stable while they wait; none "
        "is lost, duplicated or out of order, each carries its own tag and verdict; the latency is the "
        "documented one exactly; one pair per clock while results are taken; a reset discards everything, "
        "and one clock after it the core is ready; never more pairs in flight than the queue has places.",
        ("core/triaxis_core", "core/triaxis_fifo", "core/triaxis_delay"),
        {"W": WIDTH, "M": margin, "TAG": 16},
        48,
        (
            "the verdict of a pair is any nine bits, documented latency after it: the streams carry "
            "verdicts and never look at them; the proofs `axes_*` show that the data path has that latency",
        ),
        beside=("triaxis_datapath", "triaxis_stream_rules"),
    )


def _verdict(width: int) -> SbyProof:
    return harness_proof(
        f"verdict_w{width}",
        "Near exactly where none of 32 free axis bits is set, otherwise the claim is the lowest one set; "
        "degenerate and coplanar exactly where the normal and all free orientations are zero; no "
        "flag of a masked pair.",
        ("core/triaxis_verdict", "core/triaxis_flags", "core/triaxis_delay"),
        {"W": width, "NormalWait": 9, "DetWait": 6},
        13,
        window=True,
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
    return harness_proof(
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
        edits={f"{_CERTIFIED}.sv": _UPSETS} if upset else None,
    )


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
            WIDTH,
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
    return harness_proof(
        f"interval_m{margin}",
        "An interval test separates exactly where all points lie beyond 0 and the triangle's own other end "
        "by more than the threshold, on one side, strictly, for free projections and thresholds.",
        ("core/triaxis_interval",),
        {"W": WIDTH, "M": margin},
        4 if margin else 3,
        ("the end moved by the threshold fits: shown by the proofs `axes_*`",),
        window=True,
    )


def _box(margin: int) -> SbyProof:
    return harness_proof(
        f"box_m{margin}",
        "A box test separates exactly where all gaps of the nine pairs of vertices, one way or the other, "
        "exceed the margin, for free coordinates and margins.",
        ("core/triaxis_box", "core/triaxis_extent", "core/triaxis_delay"),
        {"W": WIDTH, "M": margin},
        5,
        window=True,
    )


def _threshold(name: str, components: int, size: int, margin: int, clocks: int, exact: bool) -> SbyProof:
    product = (
        "the threshold is their product" if exact else "the threshold is what the multiplier makes of them"
    )
    return harness_proof(
        name,
        "The sum of the absolutes of free components and the free margin reach the multiplier exactly, at "
        f"one clock, and {product}.",
        ("core/triaxis_threshold", *_MULTIPLIER),
        {"Components": components, "CWidth": size, "M": margin, "Exact": int(exact)},
        clocks,
        ("the sum of absolutes fits: shown by the proofs `axes_*`",),
        window=True,
    )


def _reach(name: str, width: int, margin: int, clocks: int, exact: bool) -> SbyProof:
    product = "the reach is their product" if exact else "the reach is what the multiplier makes of them"
    return harness_proof(
        name,
        "In the certifier the sum of the absolutes of an axis's free components and the free margin reach "
        f"the multiplier exactly, at one clock, and {product}.",
        ("core/triaxis_reach", *_MULTIPLIER),
        {"W": width, "M": margin, "Exact": int(exact)},
        clocks,
        ("the sum of absolutes fits, none being the lowest number: shown by `certificate`",),
        window=True,
    )


def _apart(name: str, width: int, margin: int, nine: bool) -> SbyProof:
    exactly = (
        "all nine differences of a projection of B and one of A, or all nine the other way, exceed the reach"
        if nine
        else "the lowest projection of one lies above the highest of the other by more than the reach, as "
        "whole numbers (so all nine differences do)"
    )
    return harness_proof(
        name,
        f"The certifier finds two triangles apart on an axis exactly where {exactly}, strictly, for free "
        "projections and reaches.",
        ("core/triaxis_apart",),
        {"W": width, "M": margin, "Nine": int(nine)},
        5,
        (
            "projections are from the first vertex of A, and the nine differences fit: shown by the proof "
            "`certificate`",
        ),
        window=True,
    )


def _multiply() -> SbyProof:
    ports = (("DspPortA = 25", "DspPortA = 4"), ("DspPortB = 18", "DspPortB = 3"))
    ports += (("NarrowBits = 5", "NarrowBits = 2"),)
    return harness_proof(
        "multiply_small",
        "The multiplier gives the product of its operands at the documented latency, whole and split into "
        "three or four pieces, straight and swapped.",
        _MULTIPLIER,
        {},
        6,
        (
            "the ports of a DSP block have 4 x 3 bits in the copy that is proved, and narrow pieces 2, so "
            "that small operands are split",
        ),
        window=True,
        edits={"core/triaxis_pkg.sv": ports},
    )


def core_proofs() -> tuple[SbyProof, ...]:
    """Return the proofs of the core and of the modules that it is made of, the longest first."""
    return (
        *certified_proofs(),
        _apart("apart_m16", WIDTH, WIDTH, nine=False),
        _streams(0),
        _streams(WIDTH),
        _intervals(WIDTH),
        _multiply(),
        _intervals(0),
        _box(WIDTH),
        _box(0),
        _threshold("threshold_space", 3, 34, WIDTH, 8, exact=False),
        _threshold("threshold_plane", 2, 17, WIDTH, 6, exact=False),
        _threshold("threshold_small", 3, 5, 3, 7, exact=True),
        _apart("apart_m0", WIDTH, 0, nine=True),
        _apart("apart_small", 1, 1, nine=True),
        _reach("reach", WIDTH, WIDTH, 8, exact=False),
        _reach("reach_small", 2, 5, 7, exact=True),
        *(_verdict(width) for width in (WIDTH, 24, MAX_WIDTH)),
        harness_proof(
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
            window=True,
        ),
        harness_proof(
            "multiply_narrow",
            "The multiplier of narrow pieces gives the product of its operands, for pieces of 1 to 5 bits.",
            ("core/triaxis_narrow_mul",),
            {"Wide": 6},
            3,
            window=True,
        ),
    )
