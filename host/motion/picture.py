"""The picture of a path: what moves and what it passes in space; the proven clearance along the path."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from triaxis.host.enclosure import State
from triaxis.host.figures import GAP, LARGE, NORMAL, SMALL, A, B, write_figure
from triaxis.host.motion.clearance import Clearance, lengths
from triaxis.host.motion.contact import PARTS_OF_TOOL, Setup
from triaxis.host.motion.follow import ZONES
from triaxis.host.motion.kinematics import LINEAR, ROTARY, signs
from triaxis.host.motion.machine import TOOL, WORKPIECE
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_check import PathResult
from triaxis.host.motion.path_scene import PathScene
from triaxis.host.motion.rule_check import RuleCheck
from triaxis.host.quantise import Vector, vector
from triaxis.host.stl import Facets

_INCHES, _OF_MACHINE = (13.5, 7.0), (10.0, 8.5)
# Where a machine by itself is, in parts of the picture.
_WHOLE = (0.02, 0.02, 0.96, 0.86)
# Where the chart of the clearance is, in parts of the picture.
_CHART = (0.57, 0.11, 0.4, 0.73)
_DPI = 110
_WORK = "#9A9A9A"
_RAPID = "#56B4E9"
_LIGHT = np.array([0.35, -0.55, 0.76])
# Facets drawn of a mesh: beyond that a picture takes minutes, and shows no more.
_DRAWN = 6000
# Along the longest axis in space.
_TICKS = 8
_WAYS: list[tuple[str, dict[str, Any]]] = [
    ("rapid", {"color": _RAPID, "linestyle": "--"}),
    ("feed", {"color": "black"}),
]


def draw_path(
    path: Path, program: Program, checked: RuleCheck, profile: list[Clearance], zones: Sequence[Fraction] = ()
) -> None:
    """Draw into a file, ``.png`` or ``.svg``: whole or not at all. Raises InputError where it cannot.

    ``zones``: their widths in millimetres, from the innermost.
    """
    scene, result, names = checked.scene, checked.result, checked.rule.names
    figure = _titled(_INCHES, scene.program, _verdict(scene, result, names), result)
    space = figure.add_axes((0.0, 0.1, 0.5, 0.73), projection="3d")
    assert isinstance(space, Axes3D)
    _draw_space(space, scene, result, profile, names)
    _draw_clearance(figure.add_axes(_CHART), program, checked, profile, zones)
    write_figure(figure, path)


def draw_machine(
    path: Path, setup: Setup, program: Program, checked: RuleCheck, profile: list[Clearance],
    zones: Sequence[Fraction] = (),
) -> None:  # fmt: skip
    """Draw a machine with all its objects where two of them come near, else where the program begins.

    The path of the tool is drawn as the workpiece stands there, where nothing turns. Into a file as above.
    """
    result, names = checked.result, checked.rule.names
    first = checked.rule.program.moves[result.asked_at]
    near = result.near
    place, angles = (near.position, near.angles) if near else (first.start, first.turns[0])
    told = _verdict(checked.scene, result, names)
    if result.verdict == "clear":
        told = f"all is clear by more than {float(checked.scene.wanted.clearance):g} mm all along"
    figure = _titled(_INCHES if profile else _OF_MACHINE, program, told, result)
    axes = figure.add_axes((0.0, 0.02, 0.52, 0.86) if profile else _WHOLE, projection="3d")
    assert isinstance(axes, Axes3D)
    if profile:
        _draw_clearance(figure.add_axes(_CHART), program, checked, profile, zones)
    colours = dict(zip(names, (A.colour, B.colour), strict=True)) if result.verdict != "clear" else {}
    shown = _draw_objects(axes, setup, place, angles, colours)
    machine = vector(c + b for c, b in zip(place, setup.base, strict=True))
    mesh, file = setup.work
    work = setup.carried(WORKPIECE, mesh, str(file)).at
    turning = any(move.turning or any(move.turns[0]) for move in program.moves)
    if not turning:
        by = zip(work, signs(setup.machine.table), machine, strict=True)
        origin = np.array([float(o + s * m) for o, s, m in by])
        _add_ways(axes, [move.corners + origin for move in program.moves], program)
    _frame(axes, np.concatenate([facets.reshape(-1, 3) for facets in shown]))
    where = "at the first near pose" if near else "at the start"
    entries = [(f"{name.removeprefix('the ')} {where}", _of(colour)) for name, colour in colours.items()]
    entries += [("the rest of the machine" if colours else f"the machine {where}", _of(_WORK))]
    _add_legend(axes, entries if turning else [*entries, *_WAYS])
    write_figure(figure, path)


def draw_refused(
    path: Path, setup: Setup, told: str, names: tuple[str, str], place: Vector, angles: Vector
) -> None:
    """Draw all objects with the tool at a place, of which it is told what two of them are. As above."""
    figure = _figure(_OF_MACHINE, told, _place_words(place, angles))
    axes = figure.add_axes(_WHOLE, projection="3d")
    assert isinstance(axes, Axes3D)
    colours = dict(zip(names, (A.colour, B.colour), strict=True))
    shown = _draw_objects(axes, setup, place, angles, colours)
    _frame(axes, np.concatenate([facets.reshape(-1, 3) for facets in shown]))
    entries = [(name.removeprefix("the "), _of(colour)) for name, colour in colours.items()]
    _add_legend(axes, [*entries, ("all else", _of(_WORK))])
    write_figure(figure, path)


def _draw_objects(
    axes: Axes3D, setup: Setup, place: Vector, angles: Vector, colours: Mapping[str, str]
) -> list[npt.NDArray[np.floating]]:
    """Draw all objects where they are with the tool at a place; return their facets, in millimetres.

    Where the machine has no objects, in the frame of the workpiece.
    """
    axes.computed_zorder = False
    machine = vector(c + b for c, b in zip(place, setup.base, strict=True))
    whole, shown = setup.machine.objects or setup.machine.rotary, list[npt.NDArray[np.floating]]()
    for body in setup.bodies:
        if whole:
            facets = body.standing(machine, angles, setup.scale)
        else:
            by = np.array([float(c) for c in place]) * (body.name == TOOL)
            facets = body.mesh.facets * float(setup.scale) + by
        # A part of the tool is drawn as the tool.
        names = PARTS_OF_TOOL if body.name == TOOL else (f"the {body.name}",)
        colour = next((colours[name] for name in names if name in colours), None)
        _add_mesh(axes, facets, colour or _WORK, 0.55 if colour else 0.18)
        shown.append(facets)
    return shown


def _titled(inches: tuple[float, float], program: Program, told: str, result: PathResult) -> Figure:
    """Return a figure that says what was found."""
    length = f"{lengths(program).sum():.5g} mm"
    lines = f"{len(program.moves)} moves, {length}; {result.effort.poses} poses asked"
    if (near := result.near) is not None:
        lines += f"; first near pose at {_place_words(near.position, near.angles)}"
    return _figure(inches, f"{program.path.name}: {told}", lines)


def _place_words(position: Vector, angles: Vector) -> str:
    place = zip(LINEAR + ROTARY, (*position, *angles), strict=True)
    return "  ".join(f"{axis} {float(c):.3f}" for axis, c in place if c or axis in LINEAR)


def _figure(inches: tuple[float, float], title: str, line: str) -> Figure:
    figure = Figure(figsize=inches, dpi=_DPI)
    FigureCanvasAgg(figure)
    figure.text(0.03, 0.94, title, fontsize=LARGE, weight="bold")
    figure.text(0.03, 0.9, line, fontsize=NORMAL)
    return figure


def _verdict(scene: PathScene, result: PathResult, names: tuple[str, str]) -> str:
    clearance = f"{float(scene.wanted.clearance):g} mm"
    if result.insides.state in (State.INSIDE, State.UNDECIDED):
        return result.insides.parts[0].sentence(names)
    if result.near is not None:
        return f"{names[0]} comes within {clearance} of {names[1]} in line {result.near.line}"
    only = " (surfaces only)" if result.insides.state == State.NOT_ASKED else ""
    return f"{names[0]} is clear of {names[1]} by more than {clearance} all along{only}"


def _draw_space(
    axes: Axes3D, scene: PathScene, result: PathResult, profile: list[Clearance], names: tuple[str, str]
) -> None:
    # The order below: lines that pass behind a facet must still be seen.
    axes.computed_zorder = False
    scale = float(scene.wanted.scale)
    ways = [move.corners for move in scene.program.moves]
    work, tool = scene.work.facets * scale, scene.tool.facets * scale
    _add_mesh(axes, work, _WORK, 0.30)
    start = tool + ways[0][0]
    _add_mesh(axes, start, A.colour, 0.16)
    shown = [work, start, *ways]
    if result.near is not None:
        position = np.array([float(c) for c in result.near.position])
        _add_mesh(axes, tool + position, B.colour, 0.4)
        axes.plot(*position[:, None], marker="X", markersize=10, color="black", linestyle="", zorder=30)
        shown.append(tool + position)
    _add_ways(axes, ways, scene.program)
    close = np.array(
        [
            [float(c) for c in place.position]
            for place in profile
            if place.proven <= float(scene.wanted.clearance)
        ]
    )
    if len(close):
        axes.plot(*close.T, marker=".", markersize=7, color=B.colour, linestyle="", zorder=25)
    _frame(axes, np.concatenate([part.reshape(-1, 3) for part in shown]))
    what, of = (name.removeprefix("the ") for name in names)
    entries = [(of, _of(_WORK)), (f"{what} at the start", _of(A.colour))]
    if result.near is not None:
        entries.append((f"{what} at the first near pose", _of(B.colour)))
    entries += _WAYS
    if result.near is not None:
        entries.append(("first near pose", {"color": "black", "marker": "X", "linestyle": ""}))
    if len(close):
        entries.append(("not proven clear", {"color": B.colour, "marker": ".", "linestyle": ""}))
    _add_legend(axes, entries)


def _add_ways(axes: Axes3D, ways: Sequence[npt.NDArray[np.floating]], program: Program) -> None:
    for rapid, colour, style in ((True, _RAPID, "--"), (False, "black", "-")):
        chosen = [way for way, move in zip(ways, program.moves, strict=True) if move.rapid == rapid]
        if chosen:
            lines = Line3DCollection(chosen, colors=colour, linestyles=style, linewidths=1.3, zorder=20)
            axes.add_collection3d(lines)


def _add_mesh(axes: Axes3D, facets: Facets, colour: str, alpha: float) -> None:
    facets = facets[:: len(facets) // _DRAWN + 1]
    normals = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    shade = 0.6 + 0.4 * np.abs((normals / np.where(size, size, 1)) @ _LIGHT)
    red, green, blue = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    colours = np.column_stack([np.outer(shade, [red, green, blue]), np.full(len(shade), alpha)])
    axes.add_collection3d(Poly3DCollection(facets, facecolors=colours, linewidths=0))


def _frame(axes: Axes3D, points: npt.NDArray[np.floating]) -> None:
    """Show all points, at one scale in all directions."""
    low, high = points.min(0), points.max(0)
    middle, size = (low + high) / 2, np.maximum(high - low, 1e-9)
    # A thin column would leave no room for the words beside it.
    size = np.maximum(size, size.max() / 2)
    for limits, centre, span in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, size, strict=True):
        limits(centre - span / 2, centre + span / 2)
    axes.set_box_aspect(tuple(size))
    for axis, centre, span in zip((axes.xaxis, axes.yaxis, axes.zaxis), middle, size, strict=True):
        ticks = MaxNLocator(round(_TICKS * span / size.max())).tick_values(
            centre - span / 2, centre + span / 2
        )
        # Not at the ends, where another axis has its own.
        axis.set_ticks(ticks[abs(ticks - centre) < 0.46 * span])
    axes.view_init(elev=22, azim=-58)
    axes.tick_params(labelsize=SMALL)
    for label, name in zip((axes.set_xlabel, axes.set_ylabel, axes.set_zlabel), "XYZ", strict=True):
        label(f"{name} (mm)", fontsize=SMALL, labelpad=6)


def _of(colour: str) -> dict[str, Any]:
    return {"color": colour, "linewidth": 6, "alpha": 0.6}


def _add_legend(axes: Axes3D, entries: Sequence[tuple[str, dict[str, Any]]]) -> None:
    for name, style in entries:
        axes.plot([], [], [], label=name, **style)
    axes.legend(loc="upper left", fontsize=SMALL, framealpha=0.9)


def _draw_clearance(
    axes: Axes, program: Program, checked: RuleCheck, profile: list[Clearance], zones: Sequence[Fraction]
) -> None:
    asked, near = checked.scene.wanted, checked.result.near
    wanted = float(asked.clearance)
    along = np.array([place.along for place in profile])
    proven = np.array([place.proven for place in profile])
    seen = np.array([place.seen for place in profile])
    axes.fill_between(
        along, proven, seen, color=A.colour, alpha=0.25, linewidth=0, label="the clearance is here"
    )
    axes.plot(along, proven, color=A.colour, linewidth=1.2, label="proven lower bound")
    axes.axhline(wanted, color=B.colour, linestyle="--", linewidth=1.4, label=f"wanted: {wanted:g} mm")
    for name, style, width in zip(ZONES, ("-.", ":"), map(float, zones), strict=False):
        axes.axhline(width, color=B.colour, linestyle=style, linewidth=1.2, label=f"{name}: {width:g} mm")
    length = lengths(program)
    total = float(length.sum())
    if near is None:
        axes.axhspan(0, wanted, color=GAP, alpha=0.08, linewidth=0)
    else:
        number = checked.rule.numbers[near.move]
        at = float(length[:number].sum() + float(near.part_of_move) * length[number])
        axes.axvspan(at, total, color=_WORK, alpha=0.15, linewidth=0, label="after the first near pose")
        axes.plot([at], [wanted], marker="X", markersize=10, color="black", linestyle="", zorder=5)
        right = at > 0.6 * total
        axes.annotate(
            f"line {near.line}", (at, wanted), (-10 if right else 10, 12), textcoords="offset points",
            ha="right" if right else "left", fontsize=NORMAL, weight="bold",
        )  # fmt: skip
    # Linear where it matters, logarithmic above: a rapid far away must not flatten the rest.
    axes.set_yscale("symlog", linthresh=max(wanted, float(asked.resolution)) * 2, linscale=1.0)
    axes.set_ylim(0, max(seen.max(initial=0), 2 * wanted, *zones) * 1.3)
    axes.set_xlim(0, total or 1)
    ticks = [0.0, *_round_numbers(wanted, seen.max(initial=wanted))]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    axes.tick_params(labelsize=SMALL)
    axes.set_xlabel("along the path (mm)", fontsize=NORMAL)
    axes.set_ylabel("clearance (mm, Chebyshev)", fontsize=NORMAL)
    axes.set_title(f"clearance at {len(profile)} places", fontsize=NORMAL, loc="left")
    axes.legend(loc="upper right", fontsize=SMALL, framealpha=0.9)


def _round_numbers(wanted: float, most: float) -> list[float]:
    """Return 1, 2, 5, 10, .. from about the wanted clearance to the largest."""
    low = wanted if wanted > 0 else most / 1000
    numbers = [m * 10.0**e for e in range(-6, 7) for m in (1, 2, 5)]
    return [number for number in numbers if low * 0.9 <= number <= most * 1.3]
