"""The resource report: builds of the core and of the whole board against the part and their own limits."""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from triaxis.fpga.board_build import TOP
from triaxis.fpga.logic_depth import LogicDepth
from triaxis.fpga.part import BOARD_LIMITS, NO_LIMITS, WHOLE_PART, XC7A100T, Limits, Resources
from triaxis.golden.outputs import write_whole

CORE = "triaxis_core"

# The memories of the mesh engine that are as deep as the meshes: vertices, and boxes of triangles.
_DEEP = re.compile(r"\.u_store_[ab]\.(?:.*\.)?(?:u_triangles|u_boxes)\.")


@dataclass(frozen=True)
class Build:
    """A build to be reported, with the most that it may take."""

    name: str
    meaning: str
    parameters: Mapping[str, int]
    limits: Limits = NO_LIMITS
    top: str = CORE


BUILDS = (
    Build("all_axes", "core, W = 16, all 32 axes, M = 0", {"W": 16, "M": 0}, Limits(dsps=124)),
    Build(
        "no_edge_box",
        "core, W = 16, without edge x box, M = 0",
        {"W": 16, "M": 0, "EdgeBox": 0},
        Limits(dsps=86),
    ),
    Build("margins", "core, W = 16, all 32 axes, M = 16", {"W": 16, "M": 16}),
    Build(
        "board",
        "board, W = 16, M = 16, 4,096 triangles, 8 lanes",
        {"W": 16, "M": 16, "Depth": 4096, "Group": 8, "Lanes": 8},
        BOARD_LIMITS,
        TOP,
    ),
    # One margin bit covers the rounding to the grid, and takes no DSP block.
    Build(
        "board_fine",
        "board, W = 24, M = 1, 4,096 triangles, 1 lane",
        {"W": 24, "M": 1, "Depth": 4096, "Group": 8, "Lanes": 1},
        WHOLE_PART,
        TOP,
    ),
)


@dataclass(frozen=True)
class Row:
    """A build, what it takes, and what each of its memories is made of: block or look-up tables."""

    build: Build
    used: Resources
    memories: Mapping[str, str] = field(default_factory=dict)
    depth: LogicDepth | None = None

    @property
    def problems(self) -> list[str]:
        """Return what is beyond its limit, and memories that should be block RAM and are not."""
        found = self.build.limits.exceeded(self.used)
        if self.build.top != TOP:
            return found
        deep = {name: kind for name, kind in self.memories.items() if _DEEP.search(name)}
        misplaced = sorted(name for name, kind in deep.items() if kind != "block")
        if not deep:
            misplaced = ["the memories of the meshes: none found"]
        return found + [f"{name}: not in block RAM" for name in misplaced]

    @property
    def within_limit(self) -> bool:
        """Return whether the build has no problem."""
        return not self.problems


def write_report(path: Path, rows: Sequence[Row], rtl_hash: str, tool: str) -> None:
    """Write the rows as JSON, whole or not at all."""
    content = {
        "part": "XC7A100T",
        "available": asdict(XC7A100T),
        "rtl_hash": rtl_hash,
        "tool": tool,
        "builds": {
            row.build.name: {
                "meaning": row.build.meaning,
                "top": row.build.top,
                "parameters": dict(row.build.parameters),
                **asdict(row.used),
                "limits": asdict(row.build.limits),
                "memories": dict(row.memories),
                "logic_depth": asdict(row.depth) if row.depth else None,
                "problems": row.problems,
                "within_limit": row.within_limit,
            }
            for row in rows
        },
    }
    write_whole(path, json.dumps(content, indent=2) + "\n")
