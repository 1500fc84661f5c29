"""What a stress test leaves behind: build/bench/stress.json and its pictures."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

from triaxis.bench.stress.curves import PICTURES
from triaxis.bench.stress.measuring import ROUNDING_WIDTH, WIDTHS, Measured
from triaxis.bench.stress.orders import Errors
from triaxis.bench.stress.plot import draw
from triaxis.bench.stress.run import FamilyResult, StressResult
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import BUILD
from triaxis.verif.core.stimulus.symmetry import NUM_ORDERS

RESULT = BUILD / "bench" / "stress.json"


def _errors(errors: Errors) -> dict[str, Any]:
    return {**asdict(errors), "wrong_rate": errors.rate, "changing_rate": errors.changing_rate}


def _setting(label: str, measured: Measured) -> dict[str, Any]:
    return {
        "setting": label,
        "pairs": measured.pairs,
        "near_pairs": measured.near_pairs,
        "judged_pairs": measured.judged_pairs,
        "core_width_as_given": measured.own_width,
        "core_at_its_own_resolution": _errors(measured.core),
        "methods": {name: _errors(errors) for name, errors in measured.methods.items()},
        "rounded": {
            "width": ROUNDING_WIDTH,
            "resolution": measured.resolution,
            "without_margin": _errors(measured.rounded),
            "no_miss": _errors(measured.no_miss),
            "band_pairs": measured.band_pairs,
            "false_alarms_beyond_band": measured.beyond_band,
            "farthest_false_alarm_lsb": measured.farthest,
        },
    }


def _family(result: FamilyResult) -> dict[str, Any]:
    family = result.family
    settings = zip(family.settings, result.measured, strict=True)
    return {
        "name": family.name,
        "knob": family.knob,
        "about": family.about,
        "settings": [_setting(setting.label, measured) for setting, measured in settings],
    }


def summary(result: StressResult) -> str:
    """Return what was found, in a line."""
    core, no_miss = result.core, result.no_miss
    return (
        f"core: {core.wrong} of {core.answers:,} answers wrong at its own resolution; no-miss mode: "
        f"{no_miss.misses} of {no_miss.answers:,} missed, {no_miss.false_alarms:,} false alarms"
    )


def write_result(result: StressResult) -> list[Path]:
    """Write build/bench/stress.json and the pictures beside it, each whole or not at all."""
    content = {
        **asdict(result.provenance),
        "command": f"triaxis bench stress --seed {result.seed} --pairs {result.pairs}",
        "passed": not result.problems,
        "problems": result.problems,
        "summary": summary(result),
        "seconds": round(result.seconds, 1),
        "seed": result.seed,
        "pairs_a_setting": result.pairs,
        "orders": NUM_ORDERS,
        "core_widths": WIDTHS,
        "families": [_family(family) for family in result.families],
    }
    pictures = [path for picture in PICTURES for path in draw(RESULT.parent, picture, result)]
    return [write_evidence(RESULT, content), *pictures]
