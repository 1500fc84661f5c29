"""``triaxis board follow``: a machine is permitted to go through a program, as long as the board agrees."""

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from triaxis.golden.errors import InputError
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_numbers
from triaxis.host.cli.engine import BOARD, about, add_port, add_trust, board_of, self_tested, width_of
from triaxis.host.cli.path import add_program, read_moves
from triaxis.host.cli.terminal import progress_bar
from triaxis.host.enclosure import Enclosure, State
from triaxis.host.engines import BULK, SceneEngine, scene_engine
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.link.hal import HalPositions
from triaxis.host.link.positions import Positions
from triaxis.host.motion.contact import Setup
from triaxis.host.motion.follow import (
    LONGEST,
    Followed,
    Follower,
    Piece,
    Report,
    SimulatedTool,
    StrayedError,
    follow,
    pieces,
)
from triaxis.host.motion.machine import Tool
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_check import insides_at
from triaxis.host.motion.path_scene import GridPoint, PathScene, Wanted, prepare_path
from triaxis.host.motion.supervision import Names, Supervision
from triaxis.host.page import Page
from triaxis.host.report import write_report
from triaxis.host.stl import Facets, read_stl

_LENGTH, _HOLD, _LAG = Fraction(5), 50, Fraction(20)
# What a tool is told to be in that is beyond none, or the first, of the zones asked for; else "free".
_ZONES = ("slow", "warn")
# Lines that are listed; between two signs of life: the board's watchdog waits 100 ms.
_LISTED, _ALIVE_SECONDS = 10, 0.03


def add_follow(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``board follow``."""
    parser.description = (
        "Permit a machine to go through a program without a stop: while the tool is in one piece of the "
        "path, the next is checked on the board, whose output says go from one to the next. It says stop "
        "where a piece is near, where the tool is not where it may be, and where an answer or a position is "
        "late. The control says where the tool is, in lines of three numbers in millimetres: X Y Z; their "
        "end is the end of the machining. It says stop while a tool is changed, until that is where the next "
        "part of the program begins. What is cut is not known: give what must not be touched."
    )
    add_program(parser, Fraction(1, 100))
    add_numbers(parser, "--speed", "V", "the fastest that any axis moves, in mm/s", None)
    add_numbers(
        parser,
        "--length",
        "L",
        f"length of a piece, in mm, below which it is not cut further where it is near ({_LENGTH})",
        _LENGTH,
    )
    slow = "width of the zone, in mm, in which the machine is to be slow: beyond it full speed is said"
    add_numbers(parser, "--slow", "D", slow, None)
    warn = "width of the zone around that one, in mm, of which people are told"
    add_numbers(parser, "--warn", "D", warn, None)
    add_numbers(
        parser, "--lag", "MS",
        f"longest time from a position to the answer of the piece asked after it, in ms ({_LAG})", _LAG,
    )  # fmt: skip
    add_numbers(parser, "--braking", "B", "the way in which the machine stops, in mm (0)", Fraction(0))
    parser.add_argument(
        "--hold", type=int, default=_HOLD, metavar="MS",
        help=f"how long a permission counts at most, in ms ({_HOLD})",
    )  # fmt: skip
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--positions", type=argparse.FileType(errors="replace"), default=sys.stdin, metavar="FIFO",
        help="where positions come from while the machine moves (standard input)",
    )  # fmt: skip
    where.add_argument(
        "--hal", action="store_true",
        help="positions are those of pins of LinuxCNC's HAL: this is its component triaxis",
    )  # fmt: skip
    where.add_argument(
        "--simulate", action="store_true",
        help="no machine: a simulated tool goes along the program at --speed while the board says go",
    )  # fmt: skip
    parser.add_argument(
        "--page", type=int, metavar="PORT",
        help="show it in a browser of this computer, at a port (0: any): scene, go or stop, and until when",
    )  # fmt: skip
    add_port(parser)
    add_trust(parser)
    parser.set_defaults(run=run, engine=BOARD, width=None)


Source = Positions | HalPositions


def run(options: argparse.Namespace) -> int:
    """Follow a machine, and print how far it came."""
    if options.speed is None or options.speed <= 0:
        raise InputError("--speed: say how fast any axis may move, in mm/s, as in --speed 250")
    for name in ("length", "lag"):
        if getattr(options, name) <= 0:
            raise InputError(f"--{name}: must be more than 0: correct it")
    if options.braking < 0:
        raise InputError("--braking: must not be negative: correct it")
    if options.warn is not None and options.slow is None:
        raise InputError("--warn: is around the zone of --slow: give that, too")
    widths = [options.clearance, *_widths(options)]
    if sorted(set(widths)) != widths:
        raise InputError("--clearance, --slow, --warn: each must be wider than the one before: correct them")
    if not 1 <= options.hold <= LONGEST:
        raise InputError(f"hold {options.hold}: must be 1..{LONGEST} ms")
    program, machine, given = read_moves(options)
    if machine.rotary:
        raise InputError(
            f"{options.tool}: {', '.join(sorted(machine.rotary))}: the board holds meshes as they stand: "
            "check what turns with path"
        )
    work, parts = read_stl(options.work), program.stretches
    tools = [given or machine.tools[part.moves[0].tool] for part in parts]
    with board_of(options) as board:
        assert board
        operations = [
            _operation(options, board, Setup(tool, (work, options.work), None, machine, options.scale), part)
            for tool, part in zip(tools, parts, strict=True)
        ]
        count = sum(len(one.pieces) for one in operations)
        for one in operations if not options.surfaces_only else ():
            for insides, files, names in one.insides():
                if insides.state != State.OUTSIDE:
                    insides.refuse_undecided(files)
                    return _told(options, Followed(), count, "inside", names)
        print(f"board: {about(board.description)}")
        print(f"path: {program.path}, {len(program.moves)} moves, {count} pieces")
        for note in program.notes:
            print(f"note: {note}")
        if lines := sorted({piece.line for one in operations for piece in one.pieces if piece.near}):
            print(
                f"note: the machine will be stopped before line {', '.join(map(str, lines[:_LISTED]))}: near"
            )
        for width, entry in zip(_widths(options), _zones(options, operations), strict=True):
            told = f", lines {', '.join(map(str, entry['lines'][:_LISTED]))}" if entry["pieces"] else ""
            more = ", .." if len(entry["lines"]) > _LISTED else ""
            print(f"within {float(width):g} mm, or nearly: {entry['pieces']} of {count} pieces{told}{more}")
        page = None if options.page is None else Page(options.page)
        if page is not None:
            print(f"page: {page.address}", flush=True)
        try:
            done, verdict, names = _follow(options, board, operations, bool(machine.tools), page)
        except InputError as error:
            if page is not None:
                page.tell(stopped=str(error))
            raise
    more = self_tested(options) | {"zones": _zones(options, operations)}
    return _told(options, done, count, verdict, names, more)


def _widths(options: argparse.Namespace) -> list[Fraction]:
    """Return how wide the zones are that are asked for, from the innermost."""
    return [width for width in (options.slow, options.warn) if width is not None]


def _zones(options: argparse.Namespace, operations: Sequence["_Operation"]) -> list[dict[str, Any]]:
    """Return how many pieces are not shown to be beyond each zone, and the lines that they begin in."""
    found = [piece for one in operations for piece in one.pieces]
    entries = []
    for number, width in enumerate(_widths(options)):
        within = [piece.line for piece in found if piece.beyond <= number]
        entries.append({"within": width, "pieces": len(within), "lines": sorted(set(within))})
    return entries


@dataclass(frozen=True)
class _Operation:
    """A part of the program with one tool, and its pieces."""

    tool: Tool
    supervised: Supervision
    scene: PathScene
    engine: SceneEngine
    pieces: Sequence[Piece]

    def insides(self) -> Iterator[tuple[Enclosure, Names, Names]]:
        """Yield whether one of two is inside the other at the start, their files, and their names."""
        sides = self.supervised.tool, self.supervised.work
        files, names = (sides[0].files, sides[1].files), (sides[0].name, sides[1].name)
        yield insides_at(self.scene), files, names
        for beside in self.supervised.beside:
            yield beside.insides, beside.rule.files, beside.rule.names

    def near_objects(self, piece: Piece) -> Names:
        """Return two objects that are near in a piece, by the engine that cut it."""
        if piece.beside is not None:
            return piece.beside
        near = self.engine.run(piece.sample, piece.margin, stop_at_first=True).near
        a, b = map(int, near[0]) if len(near) else (0, 0)
        return self.supervised.tool.named(a), self.supervised.work.named(b)


def _operation(options: argparse.Namespace, board: Board, setup: Setup, program: Program) -> _Operation:
    wanted = Wanted(
        options.clearance, options.resolution, options.length, options.scale, width_of(options, board)
    )
    supervised = Supervision.of(setup, program, wanted)
    tool, work = supervised.tool, supervised.work
    scene = prepare_path(tool.mesh, work.mesh, (tool.files, work.files), program, wanted)
    engine = scene_engine(BULK, scene.a, scene.b, scene.grid.width)
    with progress_bar("pieces are cut", 1) as progress:
        around = [
            (scene.within(width), partial(supervised.within(width).near_beside, scene))
            for width in _widths(options)
        ]
        beside = partial(supervised.near_beside, scene)
        found = pieces(scene, engine, options.length, beside=beside, zones=around)
        progress(1)
    return _Operation(setup.tool, supervised, scene, engine, found)


def _follow(
    options: argparse.Namespace, board: Board, operations: Sequence[_Operation], numbered: bool,
    page: Page | None,
) -> tuple[Followed, str, Names | None]:  # fmt: skip
    """Follow the machine through one operation after the other.

    Returns how far it came, the verdict, and, where that is near, what is near.
    """
    if not options.hal:
        positions = None if options.simulate else Positions(options.positions)
        return _through(options, board, operations, numbered, positions, page)
    pins = HalPositions()
    try:
        return _through(options, board, operations, numbered, pins, page)
    finally:
        pins.close()


def _through(
    options: argparse.Namespace, board: Board, operations: Sequence[_Operation], numbered: bool,
    positions: Source | None, page: Page | None,
) -> tuple[Followed, str, Names | None]:  # fmt: skip
    done = Followed()
    for number, one in enumerate(operations):
        scene = one.scene
        with progress_bar("facets loaded", len(scene.a) + len(scene.b)) as progress:
            on_board = BoardEngine(board, scene.a, scene.b, progress=progress)
            on_board.load()
        if page is not None:
            page.show(*_shown(options, one))
        start = f", with {one.tool.name} from line {one.pieces[0].line} on" if len(operations) > 1 else ""
        print(f"ready: the machine may start where go is said{start}", flush=True)
        follower = Follower(scene, one.pieces, options.speed, options.lag / 1000, options.braking)
        if positions is None:
            tool_of = SimulatedTool(
                scene.program, options.speed, time.monotonic, partial(getattr, on_board, "says_go")
            )
            report = tool_of.report
        else:
            report = partial(_with_tool, positions, one.tool, numbered)
            if not _come_to_start(board, positions, one.tool, follower if number else None):
                return done, "ended", None
        ends = one is operations[-1]
        display = _Display(follower, scene, len(_widths(options)), done.asked, positions, page)
        try:
            permit, hold = on_board.permit, options.hold
            done.add(
                follow(follower, permit, report, time.monotonic, hold, ends, display.seen, display.ahead)
            )
        finally:
            display.nothing()
        if done.near:
            return done, "near", one.near_objects(done.near)
        if not follower.at_the_end:
            return done, "ended", None
    return done, "followed", None


def _shown(options: argparse.Namespace, one: _Operation) -> tuple[Facets, Facets, NDArray[np.float64], str]:
    """Return what a page shows of an operation: in millimetres, in the program's frame."""
    scale = float(options.scale)
    places = [one.pieces[0].start, *(piece.end for piece in one.pieces)]
    ends = np.array([_millimetres(one.scene, place) for place in places])
    title = f"{one.tool.name} along {one.scene.program.path.name}"
    tool, work = (side.mesh.facets * scale for side in (one.supervised.tool, one.supervised.work))
    return tool, work, ends, title


def _millimetres(scene: PathScene, place: GridPoint) -> list[float]:
    return [float(c * scene.wanted.scale) for c in scene.path.position(place)]


class _Display:
    """What shows how a machine is followed: a page, pins of HAL, and, of zones, the output."""

    def __init__(
        self, follower: Follower, scene: PathScene, zones: int, asked: int, positions: Source | None,
        page: Page | None,
    ) -> None:  # fmt: skip
        """Begin with a tool of which nothing is known. ``asked``: how many answers there were before."""
        self._follower, self._scene, self._zones, self._asked = follower, scene, zones, asked
        self._pins, self._page = positions if isinstance(positions, HalPositions) else None, page
        self._beyond: int | None = None

    def ahead(self, number: int, beyond: int) -> None:
        """Show what zone the tool may be in, where that changes, before a piece is asked about."""
        if not self._zones or beyond == self._beyond:
            return
        self._beyond = beyond
        zone = _ZONES[beyond] if beyond < self._zones else "free"
        if self._pins is not None:
            self._pins.beyond(beyond)
        print(f"zone: {zone}, line {self._follower.pieces[number].line}", flush=True)
        if self._page is not None:
            self._page.tell(zone=zone)

    def seen(self, number: int, hold: int, clear: bool, lag: float) -> None:
        """Show what an answer was."""
        self._asked += 1
        if self._pins is not None:
            self._pins.said(clear)
        if self._page is not None:
            self._page.tell(
                position=_millimetres(self._scene, self._follower.place),
                line=self._follower.pieces[number].line, hold=hold, verdict="clear" if clear else "near",
                lag=round(1000 * lag, 1), asked=self._asked, permitted=self._follower.permitted,
            )  # fmt: skip

    def nothing(self) -> None:
        """Show that from here on nothing is known."""
        if self._pins is not None:
            self._pins.said(False)
            self._pins.beyond(0)
        if self._page is not None and self._zones:
            self._page.tell(zone=None)


def _come_to_start(board: Board, positions: Source, tool: Tool, follower: Follower | None) -> bool:
    """Wait until there is a position, and for a follower one of that tool where its first piece may begin.

    Returns whether there is one. A board that hears nothing gives no go; until it is asked it says stop.
    """
    while not positions.wait(_ALIVE_SECONDS):
        board.status()
    while follower is not None:
        here = positions.report()
        if here is None:
            return False
        if positions.tool is None:
            raise InputError(
                "several tools: positions must say which one is in the spindle: X Y Z and its number"
            )
        try:
            if positions.tool == tool.number:
                follower.moved(here[0])
                break
        except StrayedError:
            pass
        board.status()
    return True


def _with_tool(positions: Source, tool: Tool, numbered: bool) -> Report:
    """Return the last position; raise InputError where it is of another tool.

    ``numbered``: it is one of a machine file, and not that of an STL file, which may have any number.
    """
    here = positions.report()
    if here is not None and numbered and positions.tool not in (None, tool.number):
        raise InputError(
            f"tool {positions.tool} is in the spindle, and not {tool.number}; the machine is stopped: "
            "change it"
        )
    return here


def _told(
    options: argparse.Namespace,
    done: Followed,
    count: int,
    verdict: str,
    names: Names | None,
    more: dict[str, Any] | None = None,
) -> int:
    """Print what came of it, and write the report."""
    if options.json is not None:
        write_report(
            options.json,
            {
                "verdict": verdict, "pieces": count, "permitted": done.permitted, "asked": done.asked,
                "line": done.near.line if done.near else None,
                "what": names[0] if names else None, "of": names[1] if names else None,
                "shortest_hold_ms": done.shortest_hold, "longest_lag_ms": 1000 * done.longest_lag,
                **(more or {}),
            },
        )  # fmt: skip
    one, other = names or ("", "")
    what = {
        "near": f"NEAR: line {done.near.line if done.near else 0}: the machine was stopped before it, where "
        f"{one} comes near {other}",
        "inside": f"NEAR: of {one} and {other} one is inside the other at the start: go was never said",
        "followed": "FOLLOWED: to the end of the program",
        "ended": "ENDED: the positions ended before the program did",
    }[verdict]
    print(
        f"{what}; {done.permitted} of {count} pieces permitted, asked {done.asked} times, shortest hold "
        f"{done.shortest_hold} ms, longest lag {1000 * done.longest_lag:.1f} ms"
    )
    return DONE if verdict == "followed" else NO
