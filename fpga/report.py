"""The resource report: the core's builds against the part's budget and their own limits."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from triaxis.fpga.part import XC7A100T, Resources


@dataclass(frozen=True)
class Build:
    """A build to be reported, with the DSP blocks that it may take at most."""

    name: str
    meaning: str
    parameters: Mapping[str, int]
    dsp_limit: int | None


BUILDS = (
    Build("all_axes", "W = 16, all 32 axes, M = 0", {"W": 16, "M": 0}, 124),
    Build("no_edge_box", "W = 16, without edge x box, M = 0", {"W": 16, "M": 0, "EdgeBox": 0}, 86),
    Build("margins", "W = 16, all 32 axes, M = 16", {"W": 16, "M": 16}, None),
)


@dataclass(frozen=True)
class Row:
    """A build and what it takes."""

    build: Build
    used: Resources

    @property
    def within_limit(self) -> bool:
        """Return whether the DSP limit is kept."""
        return self.build.dsp_limit is None or self.used.dsps <= self.build.dsp_limit


def write_report(path: Path, rows: list[Row], rtl_hash: str, tool: str) -> None:
    """Write the rows as JSON, whole or not at all."""
    content = {
        "part": "XC7A100T",
        "available": asdict(XC7A100T),
        "rtl_hash": rtl_hash,
        "tool": tool,
        "builds": {
            row.build.name: {
                "meaning": row.build.meaning,
                "parameters": dict(row.build.parameters),
                **asdict(row.used),
                "dsp_limit": row.build.dsp_limit,
                "within_limit": row.within_limit,
            }
            for row in rows
        },
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial")
    partial.write_text(json.dumps(content, indent=2) + "\n")
    partial.replace(path)
