"""The advice as JSON: lengths in millimetres, exact ones as fractions too."""

from dataclasses import asdict
from fractions import Fraction
from typing import Any

from triaxis.host.advice.choosing import Advice
from triaxis.host.advice.measuring import Measured
from triaxis.host.advice.scene import AdviceScene, Wanted
from triaxis.host.advice.widths import Board, WidthRow
from triaxis.host.scene_report import milliseconds
from triaxis.sim.build import rtl_hash


def advice_report(
    scene: AdviceScene, wanted: Wanted, board: Board, advice: Advice, simulated_cycles: int | None
) -> dict[str, Any]:
    """Return what `triaxis.host.scene_report.write_report` writes."""
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
            _row(row, measured, unit) for row, measured in zip(advice.rows, advice.measured, strict=True)
        ],
        "chosen": None if advice.chosen is None else advice.chosen.width,
        "cycles_simulated": simulated_cycles,
        "reasons": advice.reasons,
        "changes": advice.changes,
    }


def _row(row: WidthRow, measured: Measured | None, unit: Fraction) -> dict[str, Any]:
    resolution = row.grid.resolution * unit
    return {
        "width": row.width,
        "resolution_mm": resolution,
        "resolution_exactly": str(resolution),
        "offset_mm": [c * unit for c in row.grid.offset],
        "margin": row.margin,
        "margin_bits": row.margin_bits,
        "band_mm": None if row.band is None else row.band * unit,
        "dsps": row.dsps,
        "depth": row.shape.depth,
        "group": row.shape.group,
        "lanes": row.shape.lanes,
        "resources": None if row.resources is None else asdict(row.resources),
        "meets": row.meets,
        "problems": row.problems,
        "measured": None if measured is None else _measured(measured),
    }


def _measured(measured: Measured) -> dict[str, Any]:
    return {
        **asdict(measured),
        "false_share_of_tested": measured.false_share,
        "milliseconds_at_least": milliseconds(measured.least_cycles),
        "milliseconds_at_most": milliseconds(measured.most_cycles),
    }
