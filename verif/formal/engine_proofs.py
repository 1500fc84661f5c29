"""The proofs of the mesh engine: its queues, what it skips, how its runs end."""

from collections.abc import Mapping
from pathlib import Path

from triaxis.verif.formal.sby_proof import Method, SbyProof

_WIDTH = 16
_PACKAGE = "mesh/triaxis_mesh_pkg.sv"
_RESET = "a reset holds at the first clock, and from then on is asserted and released at any clocks"


def _engine(
    name: str,
    claim: str,
    modules: tuple[str, ...],
    parameters: Mapping[str, int],
    cover_depth: int,
    assumptions: tuple[str, ...] = (),
    window: int | None = None,
) -> SbyProof:
    """Return a proof of the first module, in its formal harness: by induction, or over a window."""
    top = f"{Path(modules[0]).name}_formal"
    return SbyProof(
        name=name, claim=claim, method=Method.INDUCTION if window is None else Method.WINDOW, top=top,
        dut_files=(_PACKAGE, *(f"{module}.sv" for module in reversed(modules))),
        formal_files=(f"{top}.sv",), parameters=parameters,
        assumptions=(_RESET, *assumptions) if window is None else assumptions,
        depth=window or 1, cover_depth=cover_depth,
    )  # fmt: skip


def _skip(name: str, width: int, whole: bool) -> SbyProof:
    steps = (
        "A box of A, moved, is skipped exactly where one axis separates it from the box of B by more than "
        "the margin, and boxes around two boxes only where these are"
    )
    claim = (
        f"{steps}, for all boxes, translations and margins of few bits."
        if whole
        else "Every sum and every comparison behind a skip is that of whole numbers; boxes around two boxes "
        "are skipped only where these are; a run is refused exactly where A moved leaves the range."
    )
    return _engine(
        name,
        claim,
        ("mesh/triaxis_overlap", "mesh/triaxis_grow", "mesh/triaxis_run_control"),
        {"W": width, "M": width, "Whole": int(whole)},
        5,
        ("what was asked for is not exchanged while a run compares boxes: it is taken on acceptance alone",),
        window=4,
    )


def engine_proofs() -> tuple[SbyProof, ...]:
    """Return the proofs of the mesh engine."""
    return (
        _skip("engine_skip", _WIDTH, whole=False),
        _skip("engine_skip_small", 4, whole=True),
        _engine(
            "engine_boxes",
            "The box of a group, and that of the mesh, is the smallest around its triangles' boxes, by "
            "induction over the triangles.",
            (
                "mesh/triaxis_mesh_store",
                "mesh/triaxis_ram",
                "core/triaxis_extent",
                "core/triaxis_delay",
                "core/triaxis_pkg",
            ),
            {"W": _WIDTH, "Depth": 16, "Group": 4, "Lanes": 2},
            8,
            window=2,
        ),
        _engine(
            "engine_queue",
            "For all time and under every pattern of stalls and resets: a queue between two streams loses, "
            "duplicates and reorders nothing; a word that waits stays; it is ready exactly where it "
            "has room, one clock after a reset.",
            ("mesh/triaxis_stream_fifo", "core/triaxis_fifo"),
            {"Width": 8, "Depth": 4},
            12,
        ),
        _engine(
            "engine_pick",
            "For all time: of each mask every lane comes once, the lowest first, with its word and without "
            "gaps; draining leaves nothing.",
            ("mesh/triaxis_pick",),
            {"Width": 8, "Lanes": 8},
            12,
            ("masks are not zero: words without a lane are not valid where they come from",),
        ),
        _engine(
            "engine_control",
            "For all time: a summary waits unchanged, and stays until the next run; it says complete only of "
            "a run that was neither aborted nor ended early and in whose last clock nothing was left to do; "
            "an abort is said; what is refused was not run; cycles are those since acceptance, or the "
            "largest number.",
            ("mesh/triaxis_run_control",),
            {"W": 8, "CycleBits": 4},
            24,
            ("once a run has ended at its first near pair it keeps saying so: shown by `engine_near`",),
        ),
        _engine(
            "engine_near",
            "For all time: each near pair is offered once, in order, unchanged until it is taken; none after "
            "the first where one was asked for, none where only counts were; the counts are those of the "
            "verdicts; idle means nothing on offer and nothing on its way.",
            ("mesh/triaxis_near_pairs",),
            {"IndexWidth": 3, "InFlight": 34},
            12,
            (
                "no more verdicts than pairs that were issued, and no more of these on their way than the "
                "core's queue and the two steps before it hold",
                "a run starts when the last one is over, so when all is idle",
            ),
        ),
    )
