"""A mill of three linear and two rotary axes to try things on: its meshes, machine file, and programs.

The head goes along Z, the table along Y and X; on the table a trunnion tilts by A, and on that a platter
turns by C, with a vise and a blank. With all axes at 0 the tool is above the middle of the platter.
"""

from pathlib import Path

import numpy as np

from triaxis.golden.outputs import write_whole
from triaxis.host.scenes import box, revolved, write_stl
from triaxis.host.stl import Facets

_MACHINE = """# Three linear axes, a trunnion that tilts (A), and a platter on it that turns (C).
rapids = "straight"
path_tolerance = 0.01
turn_tolerance = 0.01        # degrees
loaded = 1

[offsets]                    # the origin of vise.stl is in the middle of the platter's face
G54 = [0.0, 0.0, -450.0]

[[tools]]
number = 1                   # an end mill, its shank, and the holder
length = 105
parts = [
    { diameter = 10, length = 25, cuts = true }, { diameter = 10, length = 20 },
    { diameter = 50, length = 60 },
]

[[tools]]
number = 2                   # a drill, and the holder
length = 120
parts = [{ diameter = 6, length = 60, cuts = true }, { diameter = 40, length = 60 }]

[[objects]]
name = "bed"                 # with the column that the head slides on
mesh = "bed.stl"
may_touch = ["saddle", "head"]

[[objects]]
name = "saddle"
axis = "-Y"
mesh = "saddle.stl"
may_touch = ["table"]

[[objects]]
name = "table"               # with the two bearings of the trunnion
on = "saddle"
axis = "-X"
mesh = "table.stl"

[[objects]]
name = "trunnion"
on = "table"
axis = "-A"
pivot = [0.0, 0.0, 170.0]
mesh = "trunnion.stl"
may_touch = ["platter"]

[[objects]]
name = "platter"
on = "trunnion"
axis = "-C"
pivot = [0.0, 0.0, 150.0]
mesh = "platter.stl"

[[objects]]
name = "head"
axis = "Z"
mesh = "head.stl"

[spindle]
on = "head"
nose = [0.0, 0.0, 600.0]

[workpiece]
on = "platter"
"""

# A slot, then along a tilted edge, then holes; what lifts the tool before the trunnion tilts.
_PROGRAM = """G21 G90 G61 G17
T1 M6
G43 H1
G0 X-60 Y0
Z55
G1 X60 F800
G0 Z{lifted}
X0
A30
X-60 Y-1
Z65
G1 X60
G0 Z200
A0 C90
T2 M6
G43 H2
G0 X0 Y10
Z80
G98 G81 Z25 R62 F200
Y-10
G80
G0 Z200
M2
"""


def _meshes() -> dict[str, Facets]:
    """Return all objects where they stand with all axes at 0, vise and blank on the platter's face."""
    column, bed = box((-150, 330, -60), (150, 450, 1000)), box((-400, -300, -160), (400, 450, -60))
    bearings = [box((side * 165 - 15, -50, 40), (side * 165 + 15, 50, 200)) for side in (-1, 1)]
    cheeks = [box((side * 130 - 10, -40, 135), (side * 130 + 10, 40, 200)) for side in (-1, 1)]
    jaws = [box((-50, low, 15), (50, low + 15, 40)) for low in (-40, 25)]
    spindle = revolved([(0, 600), (40, 600), (40, 660), (0, 660)])
    return {
        "bed": np.concatenate([bed, column]),
        "saddle": box((-220, -150, -60), (220, 150, 0)),
        "table": np.concatenate([box((-250, -130, 0), (250, 130, 40)), *bearings]),
        "trunnion": np.concatenate([box((-140, -80, 115), (140, 80, 135)), *cheeks]),
        "platter": revolved([(0, 135), (80, 135), (80, 150), (0, 150)], 48),
        "head": np.concatenate([spindle, box((-70, -80, 660), (70, 330, 900))]),
        "vise": np.concatenate([box((-50, -50, 0), (50, 50, 15)), *jaws]),
        "blank": box((-40, -24.5, 20), (40, 24.5, 60)),
    }


def write_mill(folder: Path) -> list[tuple[Path, str]]:
    """Write it, with a program that is clear and one that is not; return what a command is given."""
    for name, facets in _meshes().items():
        write_stl(folder / f"{name}.stl", facets)
    files = {
        "machine.toml": (_MACHINE, "a mill with a tilting and a turning table, vise.stl and blank.stl on it"),
        "part.nc": (_PROGRAM.format(lifted=200), "a program for it"),
        "crash.nc": (
            _PROGRAM.format(lifted=62),
            "the same, but the tool is not lifted before the trunnion tilts",
        ),
    }
    for name, (text, _) in files.items():
        write_whole(folder / name, text)
    return [(folder / name, about) for name, (_, about) in files.items()]
