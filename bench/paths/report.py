"""How long programs of moves take to check, what is missed, and how others fare with continuous motion.

A ball-nosed tool goes line by line over a relief of hills, a fixed height above what is under its tip.
Collisions are planted as straight moves from one valley to the next, clear at both ends: through the hill
between, or over it by a little less than the clearance. Others are asked about single moves, at touching: no
margin for rounding, no arcs, no rapids.
"""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from triaxis.bench.harness import FOLDER, Findings, Progress, clocked, report
from triaxis.bench.paths.continuous import peers
from triaxis.bench.peers.peer import Peer, Presence, Reals, present
from triaxis.host.cli.terminal import progress_bar, table
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_check import bulk_engine, check_path
from triaxis.host.motion.path_scene import Wanted, prepare_path
from triaxis.host.motion.program import read_program
from triaxis.host.quantise import vector
from triaxis.host.scenes import revolved
from triaxis.host.stl import Facets, StlMesh

RESULT = FOLDER / "path.json"
# Moves, and squares of the relief a side, of two facets each; rows of moves.
MOVES, SQUARES, ROWS = 100_000, 224, 40
PLANTED, ASKED = 100, 50
_SIZE, _RADIUS = 100.0, 5.0
# Millimetres of the tip above the relief under it; wanted clearance.
_ABOVE, _CLEARANCE, _LENGTH = 1.5, Fraction(1, 2), Fraction(4, 1000)
# Of the relief, below all hills and what is lowered into them; of a planted move that grazes, above the hill.
_BOTTOM, _GRAZED = -12.0, 0.45
# Of the planted move, in a program.
_PLANTED_LINE = 5
# Between valleys, along X: the length of a wave.
_WAVE = 14 * np.pi


@dataclass(frozen=True)
class Figures:
    """What a program took, in seconds of processor time; how many planted collisions were not found."""

    moves: int
    facets: int
    tool_facets: int
    read_seconds: float
    prepare_seconds: float
    check_seconds: float
    poses: int
    clear: bool
    planted: int
    missed: int


@dataclass(frozen=True)
class PeerFigures:
    """Of moves that collide, and of those that do not: asked, wrong, seconds a move."""

    name: str
    moves: int
    missed: int
    false: int
    seconds_per_move: float


def add_path(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.description = (
        f"Check a program of {MOVES:,} moves against {2 * SQUARES**2 + 12 * SQUARES:,} facets, plant "
        f"{PLANTED} collisions in it, and ask packages for continuous motion about the same. Writes "
        "build/bench/path.json."
    )
    parser.set_defaults(run=lambda _: report(RESULT, _measured))


def height(x: Reals, y: Reals) -> Reals:
    """Return the relief's height."""
    return -2 + 2 * np.sin(x / 7) * np.cos(y / 9)


def relief(squares: int) -> Facets:
    """Return the relief as facets (2 squares^2 + 12 squares, 3, 3), closed by walls and a bottom."""
    along = np.linspace(-_SIZE / 2, _SIZE / 2, squares + 1)
    x, y = np.meshgrid(along, along, indexing="ij")
    p = np.stack([x, y, height(x, y)], -1).astype(np.float32)
    lower, upper = [p[:-1, :-1], p[1:, :-1], p[1:, 1:]], [p[:-1, :-1], p[1:, 1:], p[:-1, 1:]]
    top = [np.stack(half, 2).reshape(-1, 3, 3) for half in (lower, upper)]
    # Round the border, with what is inside on the left.
    border = np.concatenate([p[:-1, 0], p[-1, :-1], p[:0:-1, -1], p[0, :0:-1]])
    following = np.roll(border, -1, 0)
    low, low_following, middle = (end.copy() for end in (border, following, np.zeros_like(border)))
    for end in (low, low_following, middle):
        end[:, 2] = _BOTTOM
    rest = [(following, border, low), (following, low, low_following), (low_following, low, middle)]
    return np.concatenate([*top, *(np.stack(corners, 1) for corners in rest)])


def ball_nosed(sides: int) -> Facets:
    """Return the tool, its tip at the origin."""
    turns = np.linspace(0, np.pi / 2, sides // 4 + 1)
    nose = [(float(_RADIUS * np.sin(t)), float(_RADIUS * (1 - np.cos(t)))) for t in turns]
    return revolved([*nose, (_RADIUS, 60.0), (0.0, 60.0)], sides)


def program_text(moves: int, rows: int = ROWS) -> str:
    """Return a program that goes over the relief in rows, there and back."""
    lines = ["G21 G90 G61 F1000", f"G0 X{-_SIZE / 2} Y{-_SIZE / 2} Z20", "G1 Z2"]
    for row, y in enumerate(np.linspace(-_SIZE / 2, _SIZE / 2, rows, endpoint=False)):
        x = np.linspace(-_SIZE / 2, _SIZE / 2, moves // rows + 1)[1:] * (1 if row % 2 == 0 else -1)
        z = height(x, np.full_like(x, y)) + _ABOVE
        lines += [f"G1 X{a:.3f} Y{y:.3f} Z{c:.3f}" for a, c in zip(x, z, strict=True)]
    return "\n".join(lines)


def planted(count: int, rng: np.random.Generator, grazing: bool = False) -> Reals:
    """Return moves from valley to valley through a hill, or just over it, (count, 2, 3): start and end."""
    ends = np.empty((count, 2, 3))
    # Where cos(y / 9) is 1 the valleys along x are deepest.
    ends[..., 1] = rng.uniform(-3, 3, (count, 1))
    ends[:, 0, 0] = -_WAVE / 4 + rng.uniform(-1, 1, count)
    ends[:, 1, 0] = ends[:, 0, 0] + _WAVE
    hill = height(np.full_like(ends[..., 1], _WAVE / 4), ends[..., 1])
    ends[..., 2] = hill + _GRAZED if grazing else height(ends[..., 0], ends[..., 1]) + _ABOVE
    return ends.round(3)


def measured(folder: Path, moves: int, squares: int, count: int, progress: Progress) -> Figures:
    """Check the program, then parts of it with a collision each."""
    tool, work = StlMesh(ball_nosed(squares), Fraction(0)), StlMesh(relief(squares), Fraction(0))
    wanted = Wanted(_CLEARANCE, Fraction(1, 1000), _LENGTH, Fraction(1), None)
    start = vector((Fraction(-50), Fraction(-50), Fraction(30)))
    path = folder / "program.nc"

    def scene_of(program: Program) -> Any:
        return prepare_path(tool, work, ("tool", "relief"), program, wanted)

    path.write_text(program_text(moves))
    program, read = clocked(lambda: read_program(path, start))
    scene, prepare = clocked(lambda: scene_of(program))
    result, check = clocked(lambda: check_path(scene, bulk_engine(scene)))
    progress(1)
    missed, rng = 0, np.random.default_rng(1)
    collisions = [*planted(count - count // 2, rng), *planted(count // 2, rng, grazing=True)]
    for number, (first, last) in enumerate(collisions):
        part = program.moves[(number * 997) % len(program.moves) :][:50]
        up = f"G0 X{first[0]} Y{first[1]} Z20\nG1 Z{first[2]}\nX{last[0]} Y{last[1]} Z{last[2]}"
        ends = "\n".join(f"G1 X{float(m.end[0])} Y{float(m.end[1])} Z{float(m.end[2])}" for m in part)
        path.write_text(f"G21 G90 G61 F1000\nG0 Z20\n{up}\nG0 Z20\n{ends}")
        hit = scene_of(read_program(path, start))
        near = check_path(hit, bulk_engine(hit)).near
        # What is said to come near there must do so, in the files.
        apart = near.facets[0].distance if near and near.line == _PLANTED_LINE else None
        missed += apart is None or apart > _CLEARANCE + _LENGTH
        progress(1)
    facets, tools = len(work.facets), len(tool.facets)
    poses, clear = result.effort.poses, result.verdict == "clear"
    return Figures(len(program.moves), facets, tools, read, prepare, check, poses, clear, count, missed)


def asked_moves(count: int) -> tuple[Reals, list[bool]]:
    """Return moves (2 count, 2, 3) and whether each collides: planted ones, short ones above the relief."""
    rng = np.random.default_rng(2)
    ends = np.empty((count, 2, 3))
    ends[:, 0, :2] = rng.uniform(-40, 40, (count, 2))
    ends[:, 1, :2] = ends[:, 0, :2] + rng.uniform(-0.1, 0.1, (count, 2))
    ends[..., 2] = height(ends[..., 0], ends[..., 1]) + _ABOVE
    return np.concatenate([planted(count, rng), ends]), [True] * count + [False] * count


def asked(peer: Peer, truth: Sequence[bool], squares: int) -> PeerFigures:
    """Ask a package about moves of which it is known whether they collide."""
    question = peer.load(ball_nosed(squares).astype(np.float64), relief(squares).astype(np.float64))
    (found, seconds), wanted = clocked(question.ask), np.array(truth)
    missed, alarms = int((wanted & ~found).sum()), int((~wanted & found).sum())
    return PeerFigures(peer.name, len(wanted), missed, alarms, seconds / len(wanted))


def findings(ours: Figures, theirs: Sequence[PeerFigures], presence: Sequence[Presence]) -> Findings:
    """Return what is shown and written: nothing may be missed, and what is clear must be said to be."""
    problems = [f"{ours.missed} of {ours.planted} planted collisions were missed"] * (ours.missed > 0)
    problems += ["the program, which is clear, is not said to be"] * (not ours.clear)
    total = ours.read_seconds + ours.prepare_seconds + ours.check_seconds
    rows = table(None, ("who", "moves", "facets", "missed", "false alarms", "ms a move"))
    rows.add_row(
        "triaxis path", f"{ours.moves:,}", f"{ours.facets:,}", f"{ours.missed} of {ours.planted}",
        str(int(not ours.clear)), f"{1000 * total / ours.moves:.3g}",
    )  # fmt: skip
    for one in theirs:
        rows.add_row(
            one.name, str(one.moves), "the same", f"{one.missed} of {one.moves // 2}", str(one.false),
            f"{1000 * one.seconds_per_move:.3g}",
        )  # fmt: skip
    notes = [f"{one.name}: {one.why_absent}" for one in presence if one.version is None]
    content = {
        **asdict(ours),
        "peers": [asdict(one) for one in theirs],
        "packages": [asdict(one) for one in presence],
    }
    summary = (
        f"{ours.moves:,} moves against {ours.facets:,} facets in {total:.1f} s of processor time "
        f"({ours.poses:,} poses), {ours.missed} of {ours.planted} planted collisions missed"
    )
    return Findings("triaxis bench path", summary, problems, content, [rows], notes=notes)


def _measured() -> Findings:
    moves, truth = asked_moves(ASKED)
    there, presence = present(peers(moves))
    FOLDER.mkdir(parents=True, exist_ok=True)
    with progress_bar("paths followed", 1 + PLANTED + len(there)) as progress:
        ours = measured(FOLDER, MOVES, SQUARES, PLANTED, progress)
        theirs: list[PeerFigures] = []
        for peer, _ in there:
            theirs.append(asked(peer, truth, SQUARES))
            progress(1)
    return findings(ours, theirs, presence)
