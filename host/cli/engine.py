"""Who decides a scene: ``--engine`` of the commands that ask one, and the board that it may name."""

import argparse
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from triaxis.fpga.bitstream import board_hash, build_id
from triaxis.golden.errors import InputError
from triaxis.host.engines import ENGINES, RTL, Counts
from triaxis.host.link.board import Board
from triaxis.host.link.exchange import LinkError, SerialLine
from triaxis.host.link.messages import Description, Flag, Status
from triaxis.host.link.self_test import self_test
from triaxis.sim.build import rtl_hash

BOARD = "board"

# Between two signs of life: the board's watchdog waits 100 ms.
_HOLD_SECONDS = 0.03


def add_engine(parser: argparse.ArgumentParser) -> None:
    """Add ``--engine``, and what the board needs to be one."""
    parser.add_argument(
        "--engine", choices=(*ENGINES, BOARD), default=RTL,
        help="who decides: the simulated mesh engine, the bulk checker, the golden model, the board at "
        "--port (rtl)",
    )  # fmt: skip
    add_port(parser, required=False)
    add_trust(parser)


def add_port(parser: argparse.ArgumentParser, required: bool = True) -> None:
    """Add ``--port``."""
    port = "the board's serial port, as /dev/ttyUSB1"
    parser.add_argument("--port", required=required, metavar="DEV", help=port)


def add_trust(parser: argparse.ArgumentParser) -> None:
    """Add ``--any-bitstream`` and ``--skip-self-test``."""
    about_it = "take a board whose bitstream was not built of this checkout, which is refused otherwise"
    parser.add_argument("--any-bitstream", action="store_true", help=about_it)
    tried = "do not try the board's checks before it is used, which takes part of a second"
    parser.add_argument("--skip-self-test", action="store_true", help=tried)


def checkout_id() -> int:
    """Return what a board built of this checkout says: of its RTL, constraints and build script."""
    return build_id(rtl_hash(), board_hash())


def about(board: Description) -> str:
    """Return what the board is, in a line."""
    return (
        f"{board.width} bits, margin {board.margin_bits} bits, {board.depth} facets a mesh, groups of "
        f"{board.group}, {board.lanes} lanes, watchdog {board.watchdog_ms} ms, "
        f"{'each clear certified' if board.certifies else 'no clear certified'}, build {board.build:08x}"
    )


def certificates(counts: Counts) -> str:
    """Return in words how many clears of tested pairs were certified; "" where the engine certifies none."""
    return "" if counts.certified is None else f"; clears certified: {counts.certified}"


def trust_entry(options: argparse.Namespace, board: Description) -> dict[str, Any]:
    """Return the part of a report on what a board was built of, and how it checked itself."""
    return {
        "self_test": "skipped" if options.skip_self_test else "passed",
        "bitstream": {"known": not other_build(board), "any_allowed": options.any_bitstream},
    }


def other_build(board: Description) -> str:
    """Return in words that the board was not built of this checkout; empty where it was."""
    ours = checkout_id()
    both = f"the board was built of {board.build:08x}, this checkout is {ours:08x}"
    return "" if board.build == ours else both


@contextmanager
def board_of(options: argparse.Namespace) -> Iterator[Board | None]:
    """Take the board, if it is to decide; at the end it says stop at once, and not only by its watchdog.

    Raises LinkError where its bitstream is unknown and not allowed, or its checks do not work.
    """
    if options.engine != BOARD:
        if options.port is not None or options.any_bitstream or options.skip_self_test:
            raise InputError(
                "--port, --any-bitstream and --skip-self-test go with --engine board, and only with it"
            )
        yield None
        return
    if options.port is None:
        raise InputError("--engine board: name its serial port with --port")
    with Board(SerialLine(options.port)) as board:
        broken = False
        description = board.hello()
        try:
            _check_build(description, options.any_bitstream)
            if not options.skip_self_test:
                self_test(board)
            yield board
        except LinkError:
            # Nobody may hear, or another master have the board: no answer is waited for.
            broken = True
            raise
        finally:
            if broken:
                board.stop()
            else:
                with suppress(LinkError):
                    board.abort()


def _check_build(board: Description, any_bitstream: bool) -> None:
    other = other_build(board)
    if other and not any_bitstream:
        raise LinkError(
            f"{other}: load the bitstream of this checkout, or allow others with --any-bitstream; "
            "verdict unknown"
        )
    if other:
        print(f"warning: {other}; allowed by --any-bitstream")


def width_of(options: argparse.Namespace, board: Board | None) -> int | None:
    """Return the width that is asked for, which the board has, or must have; None: whatever suits."""
    if board is None:
        return options.width
    width = board.description.width
    if options.width not in (None, width):
        raise InputError(f"width {options.width}: the board has {width} bits: leave --width out")
    return width


def output_of(board: Board, run: Status, hold: bool) -> str:
    """Return what the board's output says after a run; where it says stop although all is clear, why."""
    flags, watchdog = board.still(run).flags, board.description.watchdog_ms
    if flags & Flag.GO:
        return "go until interrupted" if hold else "go; stop when this command ends (see board check --hold)"
    if run.near:
        return "stop"
    if flags & Flag.WATCHDOG_EXPIRED:
        return f"stop: this program was silent for {watchdog} ms after the run: check again"
    return f"stop: the line was disturbed, or silent for {watchdog} ms before the run: check again"


def hold(board: Board, run: Status, broken: Callable[[], object]) -> None:
    """Keep the link alive until interrupted; raises LinkError when the output says stop, after ``broken``."""
    try:
        while board.still(run).flags & Flag.GO:
            time.sleep(_HOLD_SECONDS)
        raise LinkError("the board's output says stop: the link was disturbed; check again")
    except KeyboardInterrupt:
        board.stop()
        broken()
        raise
    except LinkError as error:
        try:
            broken()
        except InputError as other:
            raise LinkError(f"{error}; {other}") from other
        raise
