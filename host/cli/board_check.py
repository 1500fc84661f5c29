"""A check on the board: what goes there, and what is printed of what comes back."""

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.fpga.bitstream import board_hash, build_id
from triaxis.golden.errors import InputError
from triaxis.golden.pairs import coordinate_range
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.check import print_without_near_facets
from triaxis.host.cli.terminal import progress_bar
from triaxis.host.enclosure import NOT_ASKED, Enclosure, State, enclosure
from triaxis.host.link.audit import Verdict
from triaxis.host.link.board import Board
from triaxis.host.link.check import BoardCheck, check_on_board
from triaxis.host.link.codes import Flag, Mode, RunEnd
from triaxis.host.link.errors import LinkError
from triaxis.host.link.line import SerialLine
from triaxis.host.link.messages import Description, Pose, Status
from triaxis.host.meshcheck import MeshPair, exact_distance, prepare
from triaxis.host.pose import Pose as RealPose
from triaxis.host.scene_engines import BULK, SceneRun, scene_engine
from triaxis.host.scene_report import (
    enclosure_entry,
    grid_entry,
    milliseconds,
    run_entry,
    write_report,
)
from triaxis.host.stl import read_stl
from triaxis.sim.build import rtl_hash

_LISTED = 10
# Between two signs of life: the board's watchdog waits 100 ms.
_HOLD_SECONDS = 0.03


def checkout_id() -> int:
    """Return what a board built of this checkout says: of its RTL, constraints and build script."""
    return build_id(rtl_hash(), board_hash())


def about(board: Description) -> str:
    """Return what the board is, in a line."""
    return (
        f"{board.width} bits, margin {board.margin_bits} bits, {board.depth} facets a mesh, groups of "
        f"{board.group}, {board.lanes} lanes, watchdog {board.watchdog_ms} ms, build {board.build:08x}"
    )


def other_build(board: Description) -> str:
    """Return in words that the board was not built of this checkout; empty where it was."""
    ours = checkout_id()
    return (
        ""
        if board.build == ours
        else f"the board was built of {board.build:08x}, this checkout is {ours:08x}"
    )


def _check_build(board: Description, any_bitstream: bool) -> str:
    """Return what to warn of, if anything; raise LinkError where a bitstream is unknown and not allowed."""
    other = other_build(board)
    if other and not any_bitstream:
        raise LinkError(
            f"{other}: load the bitstream of this checkout, or allow others with --any-bitstream; "
            "verdict unknown"
        )
    return other and f"{other}; allowed by --any-bitstream"


def steps_of(meshes: MeshPair) -> npt.NDArray[np.int64]:
    """Return the move in whole steps (3,), less where A would be loaded out of range.

    A is loaded where it stands less these steps, and the board moves it by them: together exact.
    """
    low, high = coordinate_range(meshes.grid.width)
    wanted = [round(x / meshes.grid.resolution) for x in meshes.move]
    least, most = meshes.a.max((0, 1)) - high, meshes.a.min((0, 1)) - low
    return np.array([min(max(w, int(lo)), int(hi)) for w, lo, hi in zip(wanted, least, most, strict=True)])


def check(options: argparse.Namespace) -> int:
    """Check the meshes on the board and print what was found."""
    if options.clearance < 0:
        raise InputError(f"clearance {float(options.clearance):g}: must not be negative")
    mesh_a, mesh_b = read_stl(options.a), read_stl(options.b)
    with Board(SerialLine(options.port)) as board, _taken(board) as description:
        if warning := _check_build(description, options.any_bitstream):
            print(f"warning: {warning}")
        meshes = prepare(
            mesh_a,
            mesh_b,
            (str(options.a), str(options.b)),
            options.resolution,
            options.clearance,
            description.width,
            RealPose(move=tuple(options.move)),
        )
        insides = _insides(options, meshes)
        if insides.state in (State.INSIDE, State.UNDECIDED):
            # A clear run would make the board say go, of itself and at once.
            _print_scene(options, meshes, description)
            if options.json:
                write_report(options.json, _report(options, meshes, None, insides, description))
            print_without_near_facets(insides, _surfaces(options), ("A", "B"))
            print("output: stop; the board was not asked to run")
            insides.refuse_undecided((options.a, options.b))
            return NO
        steps = steps_of(meshes)
        loaded = meshes.a - steps
        with progress_bar("facets loaded", len(meshes.a) + len(meshes.b)) as progress:
            pose = Pose(*map(int, steps))
            found = check_on_board(board, loaded, meshes.b, meshes.margin, pose, options.mode, progress)
        near = found.verdict == Verdict.NEAR
        if not near and insides.state != State.OUTSIDE and not options.surfaces_only:
            raise InputError("the board finds no near facets where this program does: verdict unknown")
        output = _output(options, found, board.still(found.status), description)
        _print_scene(options, meshes, description)
        _print(options, meshes, found)
        if not near:
            print_without_near_facets(insides, _surfaces(options), ("A", "B"))
        print(f"output: {output}")
        if options.json:
            write_report(options.json, _report(options, meshes, found, insides, description))
        if options.hold and not near:
            try:
                _hold(board, found.status)
            except LinkError:
                if options.json:
                    # What it said is no longer so.
                    write_report(options.json, {"verdict": "unknown"})
                raise
    return NO if near else DONE


def _insides(options: argparse.Namespace, meshes: MeshPair) -> Enclosure:
    """Return what is known of insides before the board runs; near facets leave nothing to ask."""
    if options.surfaces_only:
        return NOT_ASKED
    found = enclosure(meshes.a, meshes.b)
    if found.state == State.OUTSIDE:
        return found
    engine = scene_engine(BULK, meshes.a, meshes.b, meshes.grid.width)
    return NOT_ASKED if engine.run((0, 0, 0), meshes.margin, stop_at_first=True).near_count else found


def _surfaces(options: argparse.Namespace) -> str:
    return f"no facets come within {float(options.clearance):g}"


@contextmanager
def _taken(board: Board) -> Iterator[Description]:
    """Take the board; at the end it says stop at once, and not only when its watchdog has run out."""
    broken = False
    description = board.hello()
    try:
        yield description
    except LinkError:
        # Nobody may hear, or another master have the board: its watchdog, or that one, says stop.
        broken = True
        raise
    finally:
        if not broken:
            with suppress(LinkError):
                board.abort()


def _output(options: argparse.Namespace, found: BoardCheck, status: Status, board: Description) -> str:
    """Return what the board's output says; where it says stop although all is clear, why."""
    if status.flags & Flag.GO:
        return "go until interrupted" if options.hold else "go; stop when this command ends (see --hold)"
    if found.verdict == Verdict.NEAR:
        return "stop"
    if status.flags & Flag.WATCHDOG_EXPIRED:
        return f"stop: this program was silent for {board.watchdog_ms} ms after the run: check again"
    return f"stop: the line was disturbed, or silent for {board.watchdog_ms} ms before the run: check again"


def _hold(board: Board, run: Status) -> None:
    """Keep the link alive until interrupted; raises LinkError when the output says stop."""
    while board.still(run).flags & Flag.GO:
        time.sleep(_HOLD_SECONDS)
    raise LinkError("the board's output says stop: the link was disturbed; check again")


def _print_scene(options: argparse.Namespace, meshes: MeshPair, board: Description) -> None:
    grid = meshes.grid
    offset = ", ".join(f"{float(x):g}" for x in grid.offset)
    print(f"A: {options.a}, {len(meshes.a)} facets; B: {options.b}, {len(meshes.b)} facets")
    print(
        f"grid: {grid.width} bits, resolution {float(grid.resolution):g}, offset ({offset}), rounding at "
        f"most {float(grid.rounding_bound):g}; margin {meshes.margin} steps"
    )
    print(f"board: {about(board)}")


def _print(options: argparse.Namespace, meshes: MeshPair, found: BoardCheck) -> None:
    status = found.status
    print(
        f"facet pairs: {len(meshes.a) * len(meshes.b)}; skipped by their own boxes: {status.pairs_skipped}; "
        f"tested: {status.tested}"
    )
    print(
        f"group pairs skipped: {status.groups_skipped}; opened: {status.groups_opened}; {status.cycles} "
        f"cycles, {milliseconds(status.cycles):.3g} ms at 100 MHz"
    )
    if found.verdict == Verdict.CLEAR:
        return
    clearance = f"{float(options.clearance):g}"
    count = "at least 1" if options.mode == Mode.FIRST else status.near
    print(f"NEAR: {count} facet pairs come within {clearance} (or within the rounding of it)")
    for i, j in found.near[:_LISTED]:
        distance = float(exact_distance(meshes, int(i), int(j)))
        print(f"  facet {i} of A, facet {j} of B: exact distance {distance:g}")
    if len(found.near) > _LISTED:
        print(f"  .. and {len(found.near) - _LISTED} more")


def _report(
    options: argparse.Namespace,
    meshes: MeshPair,
    found: BoardCheck | None,
    insides: Enclosure,
    board: Description,
) -> dict[str, Any]:
    """Return what `triaxis check` reports, and the board itself; without a run where ``found`` is None."""
    near = found is not None and found.verdict == Verdict.NEAR
    return {
        "verdict": insides.verdict(near),
        "a": {"file": options.a, "facets": len(meshes.a)},
        "b": {"file": options.b, "facets": len(meshes.b)},
        "pose": {"rotate": [], "move": meshes.move},
        "clearance": options.clearance,
        "grid": grid_entry(meshes.grid),
        "margin": meshes.margin,
        "engine": "board",
        "mode": options.mode.name.lower(),
        "board": board,
        "bitstream": {"known": not other_build(board), "any_allowed": options.any_bitstream},
        **enclosure_entry(insides, options.surfaces_only),
        **({} if found is None else _run_report(found, len(meshes.a) * len(meshes.b))),
    }


def _run_report(found: BoardCheck, pairs: int) -> dict[str, Any]:
    status = found.status
    complete = status.end == RunEnd.COMPLETE
    run = SceneRun(
        # What a run that stopped early has left out was not skipped.
        pairs - status.pairs_skipped - status.tested if complete else 0,
        status.pairs_skipped,
        status.tested,
        status.near,
        found.near,
        status.groups_skipped,
        status.groups_opened,
        status.cycles,
    )
    return {"status": status, **run_entry(run, pairs)}
