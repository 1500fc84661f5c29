"""``triaxis board``: two STL meshes on the board, the board's status, a simulated board to try it on."""

import argparse
from fractions import Fraction

from triaxis.host.cli import DONE, check
from triaxis.host.cli.check import add_meshes
from triaxis.host.cli.engine import BOARD, about, add_port, add_trust, checkout_id, other_build
from triaxis.host.link.board import Board
from triaxis.host.link.exchange import SerialLine
from triaxis.host.link.messages import Mode
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.pseudo_terminal import PseudoTerminal, Wire, serve
from triaxis.sim.simulated_board import SimulatedTop

# Of the simulated board, some 0.2 s: it runs about 480,000 clocks a second.
_WATCHDOG_CLOCKS = 100_000


def add_status(parser: argparse.ArgumentParser) -> None:
    """Print what the board is, and its status. This takes the board: its output says stop, and its meshes
    are emptied. A board in use by another program is not taken.
    """
    add_port(parser)
    parser.set_defaults(run=_status)


def add_check(parser: argparse.ArgumentParser) -> None:
    """Decide on the board what `triaxis check` decides. The verdict is unknown, with exit code 2, where
    anything about the board's answer is not as it must be. Where one mesh is inside the other, or may be,
    the board is not asked, so it never says go.
    """
    add_meshes(parser, Fraction(1, 100))
    add_port(parser)
    modes = parser.add_mutually_exclusive_group()
    for mode, what in (
        (Mode.ALL, "find all near pairs (the default)"),
        (Mode.COUNT, "count the near pairs only"),
        (Mode.FIRST, "stop at the first near pair"),
    ):
        modes.add_argument(f"--{mode.name.lower()}", dest="mode", action="store_const", const=mode, help=what)
    parser.add_argument(
        "--hold",
        action="store_true",
        help="when clear, keep the board's output at go until interrupted; otherwise it says stop at the end",
    )
    add_trust(parser)
    parser.set_defaults(
        run=check.run, engine=BOARD, mode=Mode.ALL, width=None, rotate=[], distance=check.CHEBYSHEV
    )


def add_simulate(parser: argparse.ArgumentParser) -> None:
    """Simulate the board's whole design, print the path of its serial port, and serve it until
    interrupted.
    """
    parser.add_argument("--width", type=int, default=16, metavar="W", help="coordinate bits (16)")
    parser.add_argument(
        "--depth", type=int, default=4096, metavar="N", help="triangles a mesh, a power of two (4096)"
    )
    parser.add_argument("--once", action="store_true", help="end when the first program closes the port")
    parser.set_defaults(run=_simulate)


def simulated_parameters(width: int, depth: int) -> BoardParameters:
    """Return the parameters of a simulated board that is served in real time."""
    return BoardParameters(width, width, depth, watchdog_clocks=_WATCHDOG_CLOCKS, build_id=checkout_id())


def _simulate(options: argparse.Namespace) -> int:
    top = SimulatedTop(simulated_parameters(options.width, options.depth))
    terminal = PseudoTerminal()
    try:
        print(terminal.path, flush=True)
        serve(top, terminal, Wire(), lambda: False, options.once)
    finally:
        terminal.close()
    return DONE


def _status(options: argparse.Namespace) -> int:
    with Board(SerialLine(options.port)) as board:
        description = board.hello()
        status = board.status()
    print(f"board: {about(description)}")
    print(
        f"output: stop, as asking has taken the board; {status.errors} errors on the line since its power-up"
    )
    if other := other_build(description):
        print(f"warning: {other}: `board check` refuses it without --any-bitstream")
    return DONE
