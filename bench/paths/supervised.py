"""A machine that never stops: a long program supervised by the simulated board, and collisions planted in it.

The whole design is simulated, with its line. A tool goes on for as long as go is said, at a speed at which
each segment is asked about hardly more than once: 9 m/s if a clock is 10 ns, beyond any machine. A collision
is a segment of the program with the tool lowered into the relief, asked about while the tool moves; then the
segment as it is, with which go begins anew. What is measured is how long go stands after the last byte of the
first RUN, and compared with what follows from the scene, docs/mesh-engine.md, before it is asked.
"""

import argparse
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from triaxis.bench.harness import FOLDER, Findings, Progress, report
from triaxis.bench.paths.report import ball_nosed, program_text, relief
from triaxis.golden.errors import InputError
from triaxis.golden.scene import scene_answer
from triaxis.host.cli.arguments import positive
from triaxis.host.cli.terminal import progress_bar, table
from triaxis.host.engines import BULK, Translation, scene_engine
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.link.messages import Description
from triaxis.host.motion.follow import Follower, SimulatedTool, follow, pieces
from triaxis.host.motion.path_scene import PathScene, Wanted, prepare_path
from triaxis.host.motion.program import read_program
from triaxis.host.quantise import vector
from triaxis.host.stl import StlMesh
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.mesh_engine import spatial_order
from triaxis.sim.simulated_board import SimulatedTop
from triaxis.sim.simulated_line import SimulatedLine, SimulatedWire

RESULT = FOLDER / "follow.json"
SEGMENTS, PLANTED = 100_000, 1000
# Segments for each planted one: what is asked beside the others costs holds of theirs.
_APART = 100
# Longest segment, in mm; squares and sides of the meshes; facets that the board holds.
_LENGTH, _SQUARES, _SIDES, _DEPTH = Fraction(11, 10), 28, 16, 2048
# Time is drawn out a hundred times, so that a hold is a small part of what an answer takes.
_CLOCKS_PER_SECOND, _HOLD_CLOCKS = 1_000_000, 1000
# Of the fastest axis, in mm/s; hold that is aimed at, in ms; lag, in seconds, with two questions in it.
_SPEED, _HOLD, _LAG = Fraction(90), 200, Fraction(1, 25)
# The last line of the approach. Steps by which the tool is lowered: 5 mm, more than it is above anything.
_APPROACHED, _LOWERED = 3, 500
# Clocks until a RUN that is whole on the line is executed; until the engine has it, and its end is told.
_EXECUTED, _TOLD = 43, 8
# Clocks of a run, besides those of its scene: with certificates.
_RUN = 70


class _WatchedLine(SimulatedLine):
    """A line that knows how long go will have been said when a frame is heard, the first of ``frames``."""

    def __init__(self, top: SimulatedTop) -> None:
        super().__init__(SimulatedWire(top, _CLOCKS_PER_SECOND))
        self._top, self.frames, self.heard_at = top, 0, 0

    def send(self, data: bytes) -> None:
        if not self.frames:
            self.heard_at = (
                self._top.go_clocks + 10 * self._top.parameters.clocks_per_three_bits * len(data) // 3
            )
        self.frames += 1
        super().send(data)


@dataclass(frozen=True)
class Supervised:
    """What came of it. ``wanted``: segments that were to be; ``false_stops``: times that go ended without
    a collision.

    ``reaction_clocks``, ``run_clocks``, ``bound_clocks``: the longest from a planted RUN to stop, of the run
    in that, and of what its scene allows; ``late``: planted ones after which stop came later than that.
    """

    wanted: int
    segments: int
    facets: int
    asked: int
    false_stops: int
    clocks: int
    shortest_hold: int
    planted: int
    missed: int
    late: int
    reaction_clocks: int
    run_clocks: int
    bound_clocks: int


def add_follow(parser: argparse.ArgumentParser) -> None:
    """Supervise a moving tool on the simulated board, segment by segment, without a stop; plant
    collisions all over the program, and measure how soon each stops it. Writes build/bench/follow.json.
    """
    parser.add_argument(
        "--segments", type=positive, default=SEGMENTS, metavar="N", help=f"so many ({SEGMENTS:,})"
    )
    parser.add_argument(
        "--planted", type=positive, default=PLANTED, metavar="N",
        help=f"so many, at most one in {_APART} segments ({PLANTED:,})",
    )  # fmt: skip
    parser.set_defaults(run=lambda options: report(RESULT, lambda: _measured(options)))


def most_cycles(scene: PathScene, board: Description, translation: Translation, margin: int) -> int:
    """Return how many cycles a run takes at most, one after the other what it may do at once."""
    a, b = (mesh[spatial_order(mesh, board.group)] for mesh in (scene.a, scene.b))
    answer = scene_answer(a + np.array(translation), b, margin, board.group)
    rows, groups = answer.groups_apart.shape
    words = -(-groups // board.lanes) * int((~answer.rows_apart).sum())
    pairs = board.group**2 // board.lanes * answer.group_pairs_opened + answer.tested
    return _RUN + rows + words + pairs


def supervised(folder: Path, segments: int, planted: int, progress: Progress) -> Supervised:
    """Go along the whole program, and ask about the planted collisions on the way."""
    tool, work = StlMesh(ball_nosed(_SIDES), Fraction(0)), StlMesh(relief(_SQUARES), Fraction(0))
    path = folder / "followed.nc"
    # Some short moves are one segment.
    moves = segments + segments // 25
    path.write_text(program_text(moves, max(1, moves // 100)))
    start = vector((Fraction(-50), Fraction(-50), Fraction(30)))
    wanted = Wanted(Fraction(1, 10), Fraction(1, 100), _LENGTH, Fraction(1), 16)
    program = read_program(path, start)
    scene = prepare_path(tool, work, ("tool", "relief"), program, wanted)
    engine = scene_engine(BULK, scene.a, scene.b, scene.grid.width)
    # The approach is cut as is needed.
    found = tuple(
        replace(piece, moves=range(first + piece.moves.start, first + piece.moves.stop))
        for first, last, longest in ((0, 2, None), (2, len(program.moves), _LENGTH))
        for piece in pieces(
            replace(scene, program=replace(program, moves=program.moves[first:last])),
            engine,
            _LENGTH,
            longest,
        )
    )
    with SimulatedTop(BoardParameters(16, 16, _DEPTH, hold_clocks=_HOLD_CLOCKS)) as top:
        line = _WatchedLine(top)
        board = Board(line)
        board.hello()
        on_board = BoardEngine(board, scene.a, scene.b)
        on_board.load()
        follower = Follower(scene, found, _SPEED, _LAG)
        moving = SimulatedTool(program, _SPEED, line.now, lambda: top.go)
        # Above the approach there is nothing to be lowered into.
        low = 1 + next(number for number, piece in enumerate(found) if piece.line > _APPROACHED)
        places = {low + (2 * place + 1) * (len(found) - low) // (2 * planted) for place in range(planted)}
        assert len(places) == planted
        stops, said, asked, shown = 0, False, 0, 0
        missed = late = reaction = cycles = most = 0

        def plant(translation: Translation, margin: int, hold: int) -> None:
            nonlocal missed, late, reaction, cycles, most
            x, y, z = translation
            lowered = x, y, z - _LOWERED
            bound = _EXECUTED + most_cycles(scene, board.description, lowered, margin) + _TOLD
            line.frames = 0
            permitted = top.go
            near = not on_board.permit(lowered, margin, hold)
            missed += not (permitted and near) or top.go
            stood = top.go_clocks - line.heard_at
            late += stood > bound
            if stood > reaction:
                reaction, cycles, most = stood, on_board.status.cycles, bound
            progress(1)

        def permit(translation: Translation, margin: int, hold: int, *_: object) -> bool:
            nonlocal stops, said, shown
            if asked in places:
                places.remove(asked)
                plant(translation, margin, hold)
                said = False
            before, since = top.go_clocks, top.clocks
            clear = on_board.permit(translation, margin, hold)
            # From the first go on it is said at every clock.
            stops += said and top.go_clocks - before != top.clocks - since
            said = said or top.go
            # There are some more than asked for.
            now = min(follower.permitted, segments)
            progress(now - shown)
            shown = now
            return clear

        def ahead(number: int, *_: object) -> None:
            nonlocal asked
            asked = number

        done = follow(follower, permit, moving.report, line.now, _HOLD, ahead=ahead)
        clocks = top.clocks
    facets = len(scene.a) + len(scene.b)
    if done.near is not None or not follower.at_the_end:
        stops += 1
    return Supervised(
        segments, len(found), facets, done.asked, stops, clocks, done.shortest_hold, planted,
        missed + len(places), late, reaction, cycles, most,
    )  # fmt: skip


def _measured(options: argparse.Namespace) -> Findings:
    if options.planted * _APART > options.segments:
        most = options.segments // _APART
        raise InputError(f"--planted {options.planted}: at most {most} in {options.segments} segments")
    FOLDER.mkdir(parents=True, exist_ok=True)
    with progress_bar("segments", options.segments + options.planted) as progress:
        ours = supervised(FOLDER, options.segments, options.planted, progress)
    return findings(ours)


def findings(ours: Supervised) -> Findings:
    """Return what is shown and written: no stop without need, no collision missed, none too late."""
    problems = [f"{ours.segments} segments, not {ours.wanted}"] * (ours.segments < ours.wanted)
    problems += [f"{ours.false_stops} false stops"] * (ours.false_stops > 0)
    problems += [f"{ours.missed} of {ours.planted} planted collisions were missed"] * (ours.missed > 0)
    problems += [f"{ours.late} stops came later than stated"] * (ours.late > 0)
    headings = ("segments", "facets", "asked", "false stops", "planted", "missed", "worst reaction, clocks")
    rows = table(None, headings, text=0)
    rows.add_row(
        f"{ours.segments:,}", f"{ours.facets:,}", f"{ours.asked:,}", str(ours.false_stops),
        f"{ours.planted:,}", str(ours.missed),
        f"{ours.reaction_clocks:,} ({ours.run_clocks:,} of the run), at most {ours.bound_clocks:,}",
    )  # fmt: skip
    summary = (
        f"{ours.segments:,} segments, {ours.false_stops} false stops, "
        f"{ours.missed} of {ours.planted:,} planted collisions missed, each stopped within "
        f"{ours.reaction_clocks:,} clocks, {ours.late} later than its scene allows"
    )
    return Findings("triaxis bench follow", summary, problems, asdict(ours), [rows])
