"""``triaxis watch``: a machine is permitted to go through a program, as long as the board agrees."""

import argparse
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from triaxis.golden.errors import InputError
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_numbers
from triaxis.host.cli.engine import BOARD, about, add_port, add_trust, board_of, trust_entry, width_of
from triaxis.host.cli.program import (
    add_program,
    add_zones,
    place_words,
    print_zones,
    read_moves,
    read_stocks,
    zone_widths,
)
from triaxis.host.cli.terminal import progress_bar
from triaxis.host.enclosure import State
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine, check_depth
from triaxis.host.link.exchange import LinkError
from triaxis.host.link.hal import HalPositions
from triaxis.host.link.positions import Positions
from triaxis.host.motion.contact import NOT_TRACKED, Setup
from triaxis.host.motion.follow import (
    LONGEST,
    ZONES,
    Followed,
    Follower,
    Piece,
    Report,
    SimulatedTool,
    StrayedError,
    follow,
)
from triaxis.host.motion.moves import Program
from triaxis.host.motion.operations import NearTurn, Operation, check_told_apart, parts_of
from triaxis.host.motion.path_scene import GridPoint, PathScene, Wanted
from triaxis.host.motion.supervision import Names
from triaxis.host.page import Page
from triaxis.host.quantise import NOWHERE, Vector
from triaxis.host.report import write_report
from triaxis.host.stl import Facets, read_stl

_LENGTH, _HOLD, _LAG, _DEVIATION = Fraction(5), 50, Fraction(20), Fraction(1, 100)
# Lines that are listed; between two signs of life: the board's watchdog waits 100 ms.
_LISTED, _ALIVE_SECONDS = 10, 0.03


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Permit a machine to go through a program without a stop: while the tool is in one piece of the
    path, the next is checked on the board, whose output says go from one to the next. It says stop where
    a piece is near, where the tool is not where it may be, and where an answer or a position is late. The
    control says where the tool is, in lines of X Y Z in millimetres, with the tool's number and A B C in
    degrees where these change; their end is the end of the machining. It says stop while a tool is
    changed, or A, B, C turn, until the machine is where the next part of the program begins. What is cut
    away is not known: give what must not be touched, and the blank as --stock.
    """
    add_program(parser, Fraction(1, 100))
    add_numbers(parser, "--speed", "V", "the fastest that any axis moves, in mm/s: needed", None)
    add_numbers(
        parser,
        "--length",
        "L",
        f"length of a piece, in mm, below which it is not cut further where it is near ({_LENGTH})",
        _LENGTH,
    )
    add_zones(
        parser,
        "width of the zone, in mm, in which the machine is to be slow: beyond it full speed is said",
        "width of the zone around that one, in mm, of which people are told",
    )
    add_numbers(
        parser, "--lag", "MS",
        f"longest time from a position to the answer of the piece asked after it, in ms ({_LAG})", _LAG,
    )  # fmt: skip
    add_numbers(
        parser, "--age", "MS", "how old a position may be when it is read, in ms, of the lag (0)", Fraction(0)
    )
    add_numbers(parser, "--braking", "B", "the way in which the machine stops, in mm (0)", Fraction(0))
    off = (
        "how far positions may be off the path, in mm, beyond what the program lets the control leave it by "
        f"({float(_DEVIATION):g})"
    )
    add_numbers(parser, "--deviation", "D", off, _DEVIATION)
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
    parser.add_argument(
        "--picture", type=Path, metavar="FILE.png", help="draw the objects where two of them came near"
    )
    add_port(parser)
    add_trust(parser)
    parser.set_defaults(run=run, engine=BOARD, width=None)


Source = Positions | HalPositions


def run(options: argparse.Namespace) -> int:
    """Follow a machine, and print how far it came."""
    _check_numbers(options)
    widths = zone_widths(options)
    page = None if options.page is None else Page(options.page)
    # Read from the start, so that no control waits with a line that was true before.
    positions = None if options.simulate or options.hal else _lines(options.positions)
    program, machine, given = read_moves(options)
    deviating = (replace(move, slack=move.slack + options.deviation) for move in program.moves)
    program = replace(program, moves=tuple(deviating))
    if machine.rotary and machine.turn_tolerance is None:
        raise InputError(
            f"{options.tool}: turn_tolerance: say by how many degrees {', '.join(sorted(machine.rotary))} "
            "may be off: it decides whether they are where the program has them"
        )
    work, stocks = read_stl(options.work), read_stocks(options, len(program.stretches))
    with board_of(options) as board:
        assert board
        trust = trust_entry(options, board.description)
        wanted = Wanted(
            options.clearance, options.resolution, options.length, options.scale, width_of(options, board),
            margin_bits=board.description.margin_bits,
        )  # fmt: skip
        setups = [
            Setup(
                given or machine.tools[stretch.moves[0].tool], (work, options.work), stock, machine,
                options.scale,
            )
            for stretch, stock in zip(program.stretches, stocks, strict=True)
        ]  # fmt: skip
        operations = _operations(program, setups, wanted, widths)
        if isinstance(operations, NearTurn):
            told = trust | {"line": operations.line}
            return _told(options, Followed(), 0, "near", operations.names, told)
        for one in operations:
            # Before the machine starts, and not in the middle.
            check_depth(one.supervised.tool.name, one.scene.a, board.description)
            check_depth(one.supervised.work.name, one.scene.b, board.description)
        count = sum(len(one.pieces) for one in operations)
        opened = dict[str, None]()
        for one in operations if not options.surfaces_only else ():
            for insides, files, names in one.insides():
                opened |= dict.fromkeys(insides.notes(names))
                if insides.state != State.OUTSIDE:
                    insides.refuse_undecided(files)
                    return _told(options, Followed(), count, "inside", names, trust)
        print(f"board: {about(board.description)}")
        print(f"path: {program.path}, {len(program.moves)} moves, {count} pieces")
        for note in (*program.notes, *((NOT_TRACKED,) if options.stock else ()), *opened):
            print(f"note: {note}")
        if lines := sorted({piece.line for one in operations for piece in one.pieces if piece.near}):
            print(
                f"note: the machine will be stopped before line {', '.join(map(str, lines[:_LISTED]))}: near"
            )
        zones = _zones(widths, operations)
        print_zones(zones, "pieces", count)
        if page is not None:
            print(f"page: {page.address}", flush=True)
        try:
            done, verdict, names = _follow(options, board, operations, positions, page)
            stopped = f"near: {' and '.join(names)}" if names else "the positions ended"
        except (InputError, KeyboardInterrupt) as error:
            if page is not None:
                page.tell(stopped=str(error) or "interrupted")
            raise
        if page is not None and verdict != "followed":
            page.tell(stopped=stopped)
    where = "hal" if options.hal else "simulated" if options.simulate else "lines"
    more = trust | {"positions": where, "zones": zones}
    status = _told(options, done, count, verdict, names, more)
    if options.picture is not None and names and done.near and done.place is not None:
        one = next(one for one in operations if any(piece is done.near for piece in one.pieces))
        _draw(options.picture, one, done.near, names, done.place)
    return status


def _check_numbers(options: argparse.Namespace) -> None:
    if options.speed is None or options.speed <= 0:
        raise InputError("--speed: say how fast any axis may move, in mm/s, as in --speed 250")
    for name in ("length", "lag", "scale"):
        if getattr(options, name) <= 0:
            raise InputError(f"--{name}: must be more than 0: correct it")
    for name in ("age", "braking", "deviation"):
        if getattr(options, name) < 0:
            raise InputError(f"--{name}: must not be negative: correct it")
    if options.age >= options.lag:
        raise InputError(
            f"--age {float(options.age):g}: must be less than --lag {float(options.lag):g}, which holds it: "
            "correct them"
        )
    if not 1 <= options.hold <= LONGEST:
        raise InputError(f"hold {options.hold}: must be 1..{LONGEST} ms")


def _operations(
    program: Program, setups: Sequence[Setup], wanted: Wanted, widths: Sequence[Fraction]
) -> list[Operation] | NearTurn:
    """Return the parts of the program, each cut into pieces; where it begins with a turn that is near, that.

    ``setups``: of each stretch. Raises InputError where there is nothing to follow, or positions cannot tell
    one part from the next.
    """
    operations = list[Operation]()
    with progress_bar("path cut into pieces", len(setups)) as progress:
        for stretch, setup in zip(program.stretches, setups, strict=True):
            for part in parts_of(setup, stretch, wanted, widths):
                if isinstance(part, Operation):
                    operations.append(part)
                elif operations:
                    operations[-1] = operations[-1].stopped_before(part)
                else:
                    return part
            progress(1)
    if not operations:
        raise InputError(f"{program.path}: no line moves X, Y or Z: there is nothing to follow")
    check_told_apart(operations)
    ends = not (program.changes or program.moves[-1].turning)
    operations[-1] = replace(operations[-1], ends=ends)
    return operations


def _zones(widths: Sequence[Fraction], operations: Sequence[Operation]) -> list[dict[str, Any]]:
    """Return how many pieces are not shown to be beyond each zone, and the lines that they begin in."""
    found = [piece for one in operations for piece in one.pieces]
    entries = []
    for number, width in enumerate(widths):
        within = [piece.line for piece in found if piece.beyond <= number]
        entries.append({"within": width, "pieces": len(within), "lines": sorted(set(within))})
    return entries


def _lines(file: TextIO | None) -> Positions:
    """Return the positions that come in lines; raise InputError where nothing is open that they could."""
    try:
        if file is not None:
            return Positions(file.fileno())
    # Of what is no file of the system.
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
    raise InputError(
        "positions: standard input is closed: give them there, or by --positions FIFO, --hal or --simulate"
    )


def _follow(
    options: argparse.Namespace, board: Board, operations: Sequence[Operation], positions: Positions | None,
    page: Page | None,
) -> tuple[Followed, str, Names | None]:  # fmt: skip
    """Follow the machine through one operation after the other.

    Returns how far it came, the verdict, and, where that is near, what is near.
    """
    if not options.hal:
        return _through(options, board, operations, positions, page)
    pins = HalPositions(operations[0].machine.rotary, _several(operations))
    try:
        return _through(options, board, operations, pins, page)
    finally:
        pins.close()


def _several(operations: Sequence[Operation]) -> bool:
    """Return whether the program has several tools."""
    return len({id(one.tool) for one in operations}) > 1


def _through(
    options: argparse.Namespace, board: Board, operations: Sequence[Operation],
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
        follower = Follower(scene, one.pieces, options.speed, options.lag / 1000, options.braking, one.ends)
        start = place_words(one.scene.program.moves[0].start, NOWHERE)
        start += f" {one.words(one.angles)}" if one.machine.rotary else ""
        start += f", with {one.tool.name} from line {one.pieces[0].line} on" if len(operations) > 1 else ""
        # The board has heard nothing for as long as that took.
        board.status()
        print(f"ready: the machine may start where go is said, at {start}", flush=True)
        if positions is None:
            tool_of = SimulatedTool(
                scene.program, options.speed, time.monotonic, partial(getattr, on_board, "says_go")
            )
            report = tool_of.report
        else:
            several = _several(operations)
            report = partial(_as_expected, positions, one, follower, several, float(options.age / 1000))
            # Of a machine that turns, and of one whose pins are there before it is, no position is a mistake.
            waits = number > 0 or bool(one.machine.rotary) or options.hal
            if not _come_to_start(board, positions, one, follower, several, waits):
                return done, "ended", None
        shown = (len(zone_widths(options)), done.asked, positions, page, options.lag / 1000)
        display = _Display(follower, scene, *shown)
        try:
            permit, hold = on_board.permit, options.hold
            done.add(follow(follower, permit, report, time.monotonic, hold, display.seen, display.ahead))
        finally:
            display.end(board)
        if done.near:
            return done, "near", one.near_objects(done.near)
        if not follower.at_the_end:
            return done, "ended", None
    return done, "followed", None


def _draw(path: Path, one: Operation, near: Piece, names: Names, place: Vector) -> None:
    # Matplotlib loads for a picture alone.
    from triaxis.host.motion.picture import draw_refused

    told = f"{one.scene.program.path.name}: stopped before line {near.line}: {names[0]} comes near {names[1]}"
    draw_refused(path, one.setup, told, names, place, one.angles)


def _shown(options: argparse.Namespace, one: Operation) -> tuple[Facets, Facets, NDArray[np.float64], str]:
    """Return what a page shows of an operation: in millimetres, in the program's frame."""
    scale = float(options.scale)
    places = [one.pieces[0].start, *(piece.end for piece in one.pieces)]
    ends = np.array([_millimetres(one.scene, place) for place in places])
    title = f"{one.tool.name} along {one.scene.program.path.name}"
    tool, work = (side.mesh.facets * scale for side in (one.supervised.tool, one.supervised.shown))
    return tool, work, ends, title


def _millimetres(scene: PathScene, place: GridPoint) -> list[float]:
    return [float(c * scene.wanted.scale) for c in scene.path.position(place)]


class _Display:
    """What shows how a machine is followed: a page, pins of HAL, and, of zones, the output."""

    def __init__(
        self, follower: Follower, scene: PathScene, zones: int, asked: int, positions: Source | None,
        page: Page | None, lag: Fraction,
    ) -> None:  # fmt: skip
        """Begin with a tool of which nothing is known. ``asked``: how many answers there were before.

        ``lag``: seconds in which an answer has to come.
        """
        self._follower, self._scene, self._zones, self._asked = follower, scene, zones, asked
        self._pins, self._page = positions if isinstance(positions, HalPositions) else None, page
        self._beyond: int | None = None
        # When go ends that was said last.
        self._lag, self._go_ends = float(lag), 0.0

    def ahead(self, number: int, beyond: int, since: float) -> None:
        """Show what zone the tool may be in, where that changes, before a piece is asked about."""
        if self._pins is not None:
            # An answer that does not come in time says nothing any more.
            self._pins.known_until(min(self._go_ends, since + self._lag))
            self._pins.beyond(beyond if self._zones else 0)
        if not self._zones or beyond == self._beyond:
            return
        self._beyond = beyond
        zone = ZONES[beyond] if beyond < self._zones else "free"
        print(f"zone: {zone}, line {self._follower.line_beyond(beyond, number)}", flush=True)
        if self._page is not None:
            self._page.tell(zone=zone)

    def seen(self, number: int, hold: int, clear: bool, since: float, answered: float) -> None:
        """Show what an answer was."""
        self._asked += 1
        if self._pins is not None:
            self._go_ends = answered + hold / 1000 if clear else 0.0
            self._pins.known_until(self._go_ends)
            self._pins.said(clear)
        if self._page is not None:
            self._page.tell(
                position=_millimetres(self._scene, self._follower.place),
                line=self._follower.pieces[number].line, hold=hold, verdict="clear" if clear else "near",
                lag=round(1000 * (answered - since), 1), asked=self._asked,
                permitted=self._follower.permitted,
            )  # fmt: skip

    def end(self, board: Board) -> None:
        """End what the board permits, and show that nothing is known; pins wait for no line that is dead."""
        if self._pins is not None:
            self._pins.known_until(0.0)
        try:
            with suppress(LinkError):
                board.abort()
        finally:
            self._nothing()

    def _nothing(self) -> None:
        if self._page is not None:
            self._page.tell(verdict=None, **({"zone": None} if self._zones else {}))
        if self._zones and self._beyond is not None:
            print("zone: unknown", flush=True)


def _come_to_start(
    board: Board, positions: Source, one: Operation, follower: Follower, several: bool, waits: bool
) -> bool:
    """Wait until there is a position; ``waits``: until it is of the part's tool, angles and start.

    ``several``: the program has several tools. Returns whether there is one. Raises StrayedError where the
    first is not at the start, and nothing else is to be waited for: a machine that stands where the program
    ends has not gone through it. A board that hears nothing gives no go; until it is asked it says stop.
    """
    while not positions.wait(_ALIVE_SECONDS):
        board.status()
    told = False
    while True:
        here = positions.report() if waits or isinstance(positions, HalPositions) else positions.look()
        if here is None:
            return False
        _check_told(positions, several)
        ready = _has_tool(positions, one) and one.stands(_angles(positions, one))
        if (ready or not waits) and follower.is_at_start(here[0]):
            return True
        where, start = (place_words(place, NOWHERE) for place in (here[0], one.scene.program.moves[0].start))
        if not waits:
            raise StrayedError(f"the tool is at {where}, and the program begins at {start}: bring it there")
        if ready and not told:
            print(f"waiting: the tool is at {where}, not at {start}", flush=True)
            told = True
        board.status()


def _check_told(positions: Source, several: bool) -> None:
    """Raise InputError where positions do not say which of several tools is in the spindle."""
    if several and positions.tool is None:
        raise InputError(
            "several tools: positions must say which one is in the spindle: X Y Z and its number"
        )


def _has_tool(positions: Source, one: Operation) -> bool:
    """Return whether the part's tool is in the spindle, for all that is said; of an STL file it is any."""
    return not one.machine.tools or positions.tool in (None, one.tool.number)


def _angles(positions: Source, one: Operation) -> Vector:
    """Return where A, B, C are; raise InputError where positions do not say it of a machine that has them."""
    if positions.angles is None and one.machine.rotary:
        raise InputError(
            f"{', '.join(sorted(one.machine.rotary))} turn: positions must say where they are: X Y Z, the "
            "tool's number, A B C; the machine is stopped"
        )
    return positions.angles or NOWHERE


def _as_expected(positions: Source, one: Operation, follower: Follower, several: bool, age: float) -> Report:
    """Return the last position; raise InputError where it is of another tool, or of other angles.

    ``several``: the program has several tools; ``age``: seconds that a position is old when it is read, at
    most. At the end of a part the next turn may have begun, or the change of the tool.
    """
    here = positions.report()
    if here is None:
        return None
    _check_told(positions, several)
    position, since = here[0], here[1] - age
    angles, wrong = _angles(positions, one), ""
    if not _has_tool(positions, one):
        wrong = f"tool {positions.tool} is in the spindle, and not {one.tool.number}"
    elif not one.stands(angles):
        wrong = f"axes are at {one.words(angles)}, not at {one.words(one.angles)}"
    if wrong:
        follower.moved(position, since)
        if follower.ends or not follower.at_the_end:
            raise InputError(f"{wrong}; the machine is stopped: correct it, and begin anew")
        follower.is_over = True
    return position, since


def _told(
    options: argparse.Namespace,
    done: Followed,
    count: int,
    verdict: str,
    names: Names | None,
    more: dict[str, Any] | None = None,
) -> int:
    """Print what came of it, and write the report; ``more``: of it."""
    line = done.near.line if done.near else (more or {}).get("line")
    if options.json is not None:
        write_report(
            options.json,
            {
                "verdict": verdict, "pieces": count, "permitted": done.permitted, "asked": done.asked,
                "line": line, "position": done.place, "stock": options.stock,
                "what": names[0] if names else None, "of": names[1] if names else None,
                "shortest_hold_ms": done.shortest_hold if done.asked else None,
                "longest_lag_ms": 1000 * done.longest_lag if done.asked else None,
                **(more or {}),
            },
        )  # fmt: skip
    one, other = names or ("", "")
    at = f", with the tool at about {place_words(done.place, NOWHERE)}" if done.place else ""
    what = {
        "near": f"NEAR: line {line}: the machine was stopped before it, where {one} comes near {other}{at}",
        "inside": f"NEAR: of {one} and {other} one is inside the other at the start: go was never said",
        "followed": "FOLLOWED: to the end of the program",
        "ended": "ENDED: the positions ended before the program did",
    }[verdict]
    times = f", shortest hold {done.shortest_hold} ms, longest lag {1000 * done.longest_lag:.1f} ms"
    print(
        f"{what}; {done.permitted} of {count} pieces permitted, asked {done.asked} times"
        f"{times if done.asked else ''}"
    )
    return DONE if verdict == "followed" else NO
