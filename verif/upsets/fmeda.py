"""The failure modes of the board, block by block, with what a campaign of upsets found of each; a plot of it.

The terms are those of IEC 61508-2: a failure is dangerous where go or clear is said wrongly; the diagnostic
coverage of a block is the share of its upsets that would be dangerous and are not, with the measures.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from triaxis.verif.upsets.builds import MEASURES

_TOP = r"TOP\.nexys4ddr_top\."


@dataclass(frozen=True)
class Block:
    """A part of the board: registers whose place begins so; what goes wrong there; what is done about it."""

    name: str
    places: str
    failure: str
    measure: str


# The first that fits counts. The last takes what is left.
BLOCKS = (
    Block(
        "meshes in memory", r"u_mesh\.u_store_[ab]\.(u_triangles|g_lane)",
        "a vertex or a box is another one",
        "parity of each coordinate and of the address, where it is used, and between runs; then the CRC-32 "
        "of the whole mesh, too",
    ),
    Block(
        "scrub", r"u_mesh\.u_store_[ab]\.u_scrub",
        "a word is not looked at, or something else than what came is held against it",
        "needs a second fault; the host compares the signature",
    ),
    Block(
        "intake of meshes", r"u_mesh\.u_store_[ab]\.",
        "a box is too small, a triangle is stored elsewhere or not counted", "twice, compared each clock",
    ),
    Block(
        "walk of a run", r"u_mesh\.g_walk",
        "a pair is left out, another pose, another margin, a wrong count", "twice, compared each clock",
    ),
    Block(
        "core", r"u_mesh\.g_core\.u_core\.u_core\.",
        "an axis that does not separate is claimed", "each clear is shown again from vertices kept elsewhere",
    ),
    Block(
        "certificates", r"u_mesh\.g_core\.",
        "a pair, its result or its order is lost; a check says yes",
        "parity and numbers; needs a second fault",
    ),
    Block("faults", r"u_mesh\.|board_fault", "a fault is forgotten", "needs a second fault"),
    Block(
        "runs", r"g_runner",
        "another pose or margin is run or told, a wrong summary is told", "twice, compared each clock",
    ),
    Block(
        "go", r"g_safety|g_watchdog|u_beat",
        "go without a reason, go for too long", "twice, of which go needs both",
    ),
    Block(
        "line from the host", r"u_receiver",
        "a command is another one", "CRC-32 of the frame; then parity of each byte until it is gathered",
    ),
    Block(
        "commands", r"u_command",
        "a command is not executed, or as another one",
        "what runs are asked with is kept twice; sequence numbers; the host compares each answer",
    ),
    Block(
        "line to the host", r"u_transmitter|u_ring|u_errors",
        "a host is told something else", "payload twice, once inverted; CRC-32; the host's audit",
    ),
    Block("display and rest", "", "a light is wrong", "none: nothing rests on it"),
)  # fmt: skip


def block_of(register: str) -> str:
    """Return the block of a register, by its place from the top on."""
    return next(block.name for block in BLOCKS if re.match(f"{_TOP}({block.places})", register))


@dataclass(frozen=True)
class BlockCounts:
    """Bits of a block, and upsets of any kind in it: with the measures, and without."""

    bits: int
    tried: int
    dangerous: int
    noticed: int
    tried_without: int
    dangerous_without: int


def table(counts: Mapping[str, BlockCounts]) -> str:
    """Return the table in Markdown."""
    whole = sum(one.bits for one in counts.values())
    lines = [
        "| block | bits | share | failure mode | measure | upsets | dangerous | noticed | without measures |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for block in BLOCKS:
        one = counts.get(block.name)
        if one is None:
            continue
        lines.append(
            f"| {block.name} | {one.bits:,} | {100 * one.bits / whole:.1f} % | {block.failure} | "
            f"{block.measure} | {one.tried:,} | {one.dangerous} | {one.noticed} | "
            f"{one.dangerous_without} of {one.tried_without:,} |"
        )
    return "\n".join(lines) + "\n"


def plot(left: Mapping[str, int]) -> str:
    """Return a plot, SVG, of how many dangerous upsets are left as measures are added."""
    # Matplotlib loads for a plot alone.
    from matplotlib.ticker import MaxNLocator

    from triaxis.host.figures import chart, drawn

    titles = {"none": "no measure", **{one.name: f"+ {one.title}" for one in MEASURES}}
    with chart((8.5, 0.9 + 0.32 * len(left)), 100) as figure:
        figure.set_layout_engine("constrained")
        axes = figure.subplots()
        values: Sequence[int] = list(left.values())
        bars = axes.barh([titles[name] for name in left], values, height=0.65, color="#4477aa")
        axes.bar_label(bars, [f"{value}" for value in values], padding=3)
        axes.set_xlim(0, max(1, *values) * 1.12)
        axes.set_xlabel("dangerous, of the same upsets")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.invert_yaxis()
        return drawn(figure).decode()
