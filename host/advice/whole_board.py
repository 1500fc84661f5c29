"""What the whole board takes at an advised width besides DSP blocks: look-up tables, flip-flops, block RAM.

Those are known only from synthesis, which takes minutes: it is done on demand, and its figures are kept for
these very sources.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path

from triaxis.fpga.board_build import TOP, WHOLE_PART, XC7A100T, Resources, bitstream_sources
from triaxis.fpga.resources import synthesise
from triaxis.golden.outputs import write_whole
from triaxis.host.advice.widths import WidthRow
from triaxis.sim.build import content_hash
from triaxis.sim.paths import BUILD, DUT
from triaxis.sim.programs import yosys_version

_NAMES = {"luts": "look-up tables", "ffs": "flip-flops", "brams": "block RAMs"}
_FOLDER = BUILD / "fpga" / "advised"


def _parameters(row: WidthRow) -> Mapping[str, int]:
    sizes = {"Depth": row.shape.depth, "Group": row.shape.group, "Lanes": row.shape.lanes}
    return {"W": row.width, "M": row.margin_bits or 0, **sizes}


def _key(row: WidthRow) -> str:
    values = [f"{name}={value}" for name, value in _parameters(row).items()]
    return content_hash([*bitstream_sources(DUT), *sorted((DUT / "core").glob("*.svh"))], TOP, *values)


def _kept(row: WidthRow) -> Path:
    return _FOLDER / f"{_key(row)[:24]}.json"


def known_resources(row: WidthRow) -> Resources | None:
    """Return what an earlier synthesis of this very build found; None where there was none."""
    try:
        return Resources(**json.loads(_kept(row).read_text(encoding="utf-8"))["used"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def synthesised_resources(row: WidthRow) -> Resources:
    """Return what the whole board takes, synthesised where that is not known; minutes.

    Raises InputError where the synthesiser is missing or fails.
    """
    known = known_resources(row)
    if known is not None:
        return known
    kept = _kept(row)
    made = synthesise(bitstream_sources(DUT), DUT / "core", TOP, _parameters(row), kept.with_suffix(""))
    content = {"tool": yosys_version(), "parameters": _parameters(row), "used": asdict(made.used)}
    write_whole(kept, json.dumps(content, indent=2) + "\n")
    return made.used


def with_resources(row: WidthRow, used: Resources | None) -> WidthRow:
    """Return the row with what its board takes, which is a problem where the part has less."""
    if used is None:
        return row
    exceeded = [name for name in WHOLE_PART.exceeded(used) if name != "dsps"]
    problems = [
        f"it takes {vars(used)[name]:,g} {_NAMES[name]} of {vars(XC7A100T)[name]:,g}" for name in exceeded
    ]
    return replace(row, resources=used, problems=(*row.problems, *problems))


def resources_reason(used: Resources | None) -> str:
    """Return what is known besides DSP blocks as a part of a sentence."""
    if used is None:
        return "look-up tables and block RAM were not synthesised: --synthesise does, in minutes"
    shares = (f"{vars(used)[key]:,g} of {vars(XC7A100T)[key]:,g} {name}" for key, name in _NAMES.items())
    return f"{', '.join(shares)}, synthesised, before routing"
