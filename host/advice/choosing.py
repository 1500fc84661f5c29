"""The choice: the smallest width that meets what is wanted and fits the board, its reasons, its report."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from itertools import takewhile
from typing import Any

from triaxis.host.advice.measuring import Measured, Position, measure
from triaxis.host.advice.wanted import AdviceScene, Wanted
from triaxis.host.advice.widths import Board, WidthRow, length, resources_reason
from triaxis.host.engines import Progress, unwatched
from triaxis.host.quantise import extent_of, widest_extent
from triaxis.host.report import milliseconds
from triaxis.sim.build import rtl_hash


@dataclass(frozen=True)
class Advice:
    """All widths, what each does on the scene (None: not measured), and the one chosen, if any.

    ``reasons``: one sentence each. ``changes``: what to change where nothing fits.
    """

    rows: tuple[WidthRow, ...]
    measured: tuple[Measured | None, ...]
    chosen: WidthRow | None
    reasons: tuple[str, ...]
    changes: tuple[str, ...] = ()


def advise(
    scene: AdviceScene, wanted: Wanted, board: Board, rows: Sequence[WidthRow], positions: list[Position],
    progress: Progress = unwatched,
) -> Advice:  # fmt: skip
    """Measure each width at the positions, and choose; ``progress`` is told of each width."""
    measured: list[Measured | None] = []
    for row in rows:
        measured.append(measure(scene, row, positions))
        progress(1)
    chosen = next((row for row in rows if row.meets), None)
    if chosen is None:
        reasons, changes = _why_none(wanted, rows), _changes(scene, wanted, board, rows)
        return Advice(tuple(rows), tuple(measured), None, reasons, changes)
    done = measured[list(rows).index(chosen)]
    reasons = (
        f"W = {chosen.width} is the smallest width whose band of false alarms, {_band(chosen, wanted)}, is "
        f"within the {length(wanted.band, wanted)} wanted and that fits the board",
        _why_not_smaller(rows, chosen),
        _what_larger_costs(wanted, rows, chosen),
        _margin_reason(scene, wanted, chosen),
        f"DSP blocks of the whole board: {chosen.dsps} of {board.dsps}; {resources_reason(chosen.resources)}",
        *_memory_reasons(scene, chosen),
        *_measured_reasons(done),
    )
    return Advice(tuple(rows), tuple(measured), chosen, reasons)


def _band(row: WidthRow, wanted: Wanted) -> str:
    return length(row.band, wanted)


def _why_not_smaller(rows: Sequence[WidthRow], chosen: WidthRow) -> str:
    place = rows.index(chosen)
    if place == 0:
        return f"no smaller width exists: {chosen.width} is the least"
    return f"W = {rows[place - 1].width} is not enough: {'; '.join(rows[place - 1].problems)}"


def _what_larger_costs(wanted: Wanted, rows: Sequence[WidthRow], chosen: WidthRow) -> str:
    above = rows[rows.index(chosen) + 1 :]
    if not above:
        return f"no larger width exists: {chosen.width} is the most"
    larger = above[0]
    if not larger.meets:
        return f"W = {larger.width} will not do: {'; '.join(larger.problems)}"
    more = (larger.dsps or 0) - (chosen.dsps or 0)
    cost = (
        f"costs {more} more DSP blocks, {larger.dsps}" if more > 0 else f"takes {larger.dsps} DSP blocks too"
    )
    if more < 0:
        cost = f"takes {-more} DSP blocks fewer, {larger.dsps}"
    lanes = "" if larger.shape == chosen.shape else f", with Lanes = {larger.shape.lanes}"
    said = f"W = {larger.width} {cost}{lanes}, and narrows the band to {_band(larger, wanted)}"
    dsps = chosen.dsps or 0
    at_no_more = [*takewhile(lambda row: row.meets and (row.dsps or 0) <= dsps, above)]
    if len(at_no_more) > 1:
        widest = at_no_more[-1]
        said += (
            f"; up to W = {widest.width} no more blocks are needed, with a band of {_band(widest, wanted)}"
        )
    return said


def _margin_reason(scene: AdviceScene, wanted: Wanted, row: WidthRow) -> str:
    moved = ", that of the position among them" if scene.travels else ""
    return (
        f"margin {row.margin:,} steps of {length(row.grid.resolution, wanted)}: the clearance of "
        f"{length(wanted.clearance, wanted)} and one step for the rounding{moved}, rounded up; M = "
        f"{row.margin_bits} bits hold it"
    )


def _memory_reasons(scene: AdviceScene, row: WidthRow) -> list[str]:
    depth = row.shape.depth
    large = [mesh for mesh in scene.meshes if len(mesh.mesh.facets) > depth]
    if not large:
        return [f"each mesh fits the engine's {depth:,} triangles"]
    return [
        f"{mesh.name}: {len(mesh.mesh.facets):,} facets do not fit the engine's {depth:,}: it is run in "
        f"{-(-len(mesh.mesh.facets) // depth)} parts, loaded anew for each pose; --depth sets the engine's"
        for mesh in large
    ]


def _measured_reasons(measured: Measured | None) -> list[str]:
    if measured is None:
        return ["not measured on the scene: too many pairs come near"]
    places = f"at {measured.positions} position{'s' if measured.positions > 1 else ''}"
    cycles = (
        f"the mesh engine takes {measured.least_cycles:,} to {measured.most_cycles:,} cycles, at most "
        f"{milliseconds(measured.most_cycles):.3g} ms at 100 MHz, for the position that takes most"
    )
    if not measured.tested:
        return [f"{places}: boxes decide all facet pairs: false alarms show at closer positions", cycles]
    undecided = f", {measured.undecided:,} more were not judged" if measured.undecided else ""
    return [
        f"{places}: of {measured.tested:,} facet pairs that no box decides {measured.alarms:,} give an "
        f"alarm, {measured.false_alarms:,} of them falsely ({measured.false_share:.2%} of the pairs"
        f"{undecided}); none within the clearance was missed",
        cycles,
    ]


def _why_none(wanted: Wanted, rows: Sequence[WidthRow]) -> tuple[str, ...]:
    """Return why no width does: the first that is precise enough, and the last that fits the board."""
    precise = next((row for row in rows if row.band <= wanted.band), None)
    fitting = _widest_fitting(rows)
    found: list[str] = []
    if precise is None:
        found.append(f"no width up to {rows[-1].width} has a band within {length(wanted.band, wanted)}")
    else:
        found.append(f"a band within the wanted one needs W = {precise.width}: {'; '.join(precise.problems)}")
    if fitting is None:
        found.append(f"no width fits the board: W = {rows[0].width}: {'; '.join(rows[0].problems)}")
    else:
        found.append(f"the widest that fits the board is W = {fitting.width}: {'; '.join(fitting.problems)}")
    return tuple(found)


def _widest_fitting(rows: Sequence[WidthRow]) -> WidthRow | None:
    """Return the widest with a band as its only problem."""
    fitting = [row for row in rows if row.dsps is not None and len(row.problems) == 1]
    return next((row for row in reversed(fitting) if row.problems[0].startswith("its band")), None)


def _changes(scene: AdviceScene, wanted: Wanted, board: Board, rows: Sequence[WidthRow]) -> tuple[str, ...]:
    fitting = _widest_fitting(rows)
    if fitting is None:
        # Blocks are counted where the margin fits.
        counted = any(row.dsps is not None for row in rows)
        more = "a part with more DSP blocks (--dsps)" if counted else "more --margin-bits"
        return (f"take a smaller clearance, or {more}",)
    extent = widest_extent(wanted.band, fitting.width, scene.rounding, scene.travels)
    found = [f"accept false alarms up to {_band(fitting, wanted)} beyond the clearance (--band)"]
    if extent:
        found.append(
            f"or work in a volume of at most {length(extent, wanted)} across, not "
            f"{length(extent_of([scene.volume]), wanted)} (--travel, --volume)"
        )
    precise = next((row for row in rows if row.band <= wanted.band), None)
    if precise is not None and precise.dsps is not None:
        found.append(f"or take a part with {precise.dsps} DSP blocks (--dsps)")
    return tuple(found)


def advice_report(
    scene: AdviceScene, wanted: Wanted, board: Board, advice: Advice, simulated_cycles: int | None
) -> dict[str, Any]:
    """Return what `triaxis.host.report.write_report` writes."""
    unit = wanted.unit
    return {
        "command": "triaxis scene advise",
        "rtl_hash": rtl_hash(),
        "meshes": [
            {"file": named.name, "facets": len(named.mesh.facets), "moves": named is scene.moving}
            for named in scene.meshes
        ],
        "unit_mm": unit,
        "move_mm": [c * unit for c in scene.move],
        "travel_mm": [[c * unit for c in corner] for corner in scene.travel],
        "volume_mm": [[c * unit for c in corner] for corner in scene.volume],
        "clearance_mm": wanted.clearance * unit,
        "wanted_band_mm": wanted.band * unit,
        "board": asdict(board),
        "widths": [
            _row_entry(row, measured, unit)
            for row, measured in zip(advice.rows, advice.measured, strict=True)
        ],
        "chosen": None if advice.chosen is None else advice.chosen.width,
        "cycles_simulated": simulated_cycles,
        "reasons": advice.reasons,
        "changes": advice.changes,
    }


def _row_entry(row: WidthRow, measured: Measured | None, unit: Fraction) -> dict[str, Any]:
    resolution = row.grid.resolution * unit
    same = ("width", "margin", "margin_bits", "dsps", "resources", "meets", "problems")
    return {
        **{name: getattr(row, name) for name in same},
        **asdict(row.shape),
        "resolution_mm": resolution,
        "resolution_exactly": str(resolution),
        "offset_mm": [c * unit for c in row.grid.offset],
        "band_mm": row.band * unit,
        "measured": None if measured is None else _measured_entry(measured),
    }


def _measured_entry(measured: Measured) -> dict[str, Any]:
    return {
        **asdict(measured),
        "false_share_of_tested": measured.false_share,
        "milliseconds_at_least": milliseconds(measured.least_cycles),
        "milliseconds_at_most": milliseconds(measured.most_cycles),
    }
