"""Machines of objects, as files: what the tests of `path` and `watch` move."""

import json

from triaxis.host import scenes

HEAD = 'rapids = "straight"\nloaded = 1\n[offsets]\nG54 = [0.0, 0.0, -250.0]\n'
TOOL = '[[tools]]\nnumber = 1\nlength = {}\nmesh = "tool.stl"\n'


def entry(name, on=None, axis=None, pivot=None, mesh=None, at=None, may_touch=None):
    """Return an object of a machine file."""
    values = {"on": on, "axis": axis, "pivot": pivot, "mesh": mesh, "at": at, "may_touch": may_touch}
    lines = [f"{key} = {json.dumps(value)}" for key, value in values.items() if value is not None]
    return "\n".join(("[[objects]]", f'name = "{name}"', *lines, ""))


def carriers(spindle, workpiece, nose=(0.0, 0.0, 0.0)):
    """Return what carries tool and workpiece."""
    return f'[spindle]\non = "{spindle}"\nnose = {list(nose)}\n[workpiece]\non = "{workpiece}"\n'


# A table on a slide on a saddle, which may turn, and a post beside it; a head above.
MILL = (
    HEAD
    + TOOL.format(50)
    + entry("bed", mesh="post.stl")
    + entry("saddle", axis="-Y")
    + entry("slide", "saddle", "-X")
    + entry("table", "slide", "C", [0.0, 0.0, 0.0], "table.stl")
    + entry("head", axis="Z", mesh="head.stl", at=[0.0, 0.0, 250.0])
    + carriers("head", "table", (0.0, 0.0, 250.0))
)

# The same without what turns.
STRAIGHT_MILL = MILL.replace(
    entry("slide", "saddle", "-X") + entry("table", "slide", "C", [0.0, 0.0, 0.0], "table.stl"),
    entry("table", "saddle", "-X", mesh="table.stl"),
)


def write_meshes(folder):
    """Write the tool, and the objects of the mill."""
    for name, corners in {
        "tool": ((-3, -3, 0), (3, 3, 50)), "table": ((-50, -50, -10), (50, 50, 0)),
        "post": ((60, -5, -30), (70, 5, 60)), "head": ((-40, -40, 0), (65, 40, 60)),
    }.items():  # fmt: skip
        scenes.write_stl(folder / f"{name}.stl", scenes.box(*corners))
