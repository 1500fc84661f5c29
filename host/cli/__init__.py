"""The command line ``triaxis``.

Exit codes: 0 done (for `check`, `path` and `board check`: clear), 1 the answer is no (for these: near; for
`shrink`: nothing fails; for `advise`: no width fits; for the others: failed, or a bound missed), 2 bad input
or a missing tool, 130 interrupted.
"""

import argparse
import os
import re
import sys
from typing import Any, NoReturn

from triaxis.golden.errors import InputError
from triaxis.golden.judge import CertificateError
from triaxis.host.cli import (
    activity,
    advise,
    bench,
    bench_mesh,
    bench_sim,
    bench_skipping,
    bitstream,
    board,
    check,
    code_coverage,
    exhaustive,
    export,
    faults,
    formal,
    fpga_report,
    fpga_timing,
    gate,
    mutate,
    path,
    regress,
    scenes,
    shrink,
    signoff,
    sim,
    stress,
    testplan,
    verdict,
)
from triaxis.sim.core_engine import CoreError

DONE, NO, ERROR, INTERRUPTED = 0, 1, 2, 130

_COMMANDS = (
    verdict,
    check,
    path,
    advise,
    board,
    scenes,
    sim,
    testplan,
    regress,
    signoff,
    gate,
    exhaustive,
    code_coverage,
    faults,
    mutate,
    formal,
    export,
    shrink,
    bench,
    bench_sim,
    bench_mesh,
    bench_skipping,
    stress,
    fpga_report,
    fpga_timing,
    activity,
    bitstream,
)


class _Parser(argparse.ArgumentParser):
    """Says what is wrong with the arguments in one line."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        # Older versions of argparse take -1e-3 for an option, and complain of a missing value.
        self._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")

    def error(self, message: str) -> NoReturn:
        self.exit(ERROR, f"{self.prog}: error: {message} (see {self.prog} --help)\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="triaxis",
        description="Exact triangle-collision core: verdicts, mesh checks, simulation, sign-off.",
        epilog="Exit codes: 0 done (check, path: clear); 1 no (check, path: near; shrink: none fails; "
        "others: failed); 2 bad input or missing tool; 130 interrupted.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=_Parser)
    for command in _COMMANDS:
        command.add_parser(commands)
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    options = _parser().parse_args(arguments)
    try:
        code = options.run(options)
        sys.stdout.flush()
        return code
    except (InputError, CoreError, CertificateError) as error:
        message = str(error)
    except KeyboardInterrupt:
        print("triaxis: interrupted", file=sys.stderr)
        return INTERRUPTED
    except MemoryError:
        message = "out of memory: use a smaller input"
    except OSError as error:
        # Whoever read our output is gone, or the disk is full: say no more on stdout.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        message = f"{error.filename or 'output'}: {error.strerror or error}"
    # No failure of our own may look like an answer: `check` says "near" with exit code 1.
    except Exception as error:
        if os.environ.get("TRIAXIS_DEBUG"):
            raise
        message = f"internal: {type(error).__name__}: {error} (TRIAXIS_DEBUG=1 shows where)"
    print(f"triaxis: error: {' '.join(message.split())}", file=sys.stderr)
    return ERROR
