"""Becomes another program that is told to end when the process that started it ends, however it ends.

So no simulation goes on after a regression was killed. Call: python -m ..die_with_parent PARENT PROGRAM ..
"""

import ctypes
import os
import signal
import sys

_PR_SET_PDEATHSIG = 1


def main() -> None:
    """Ask the kernel for a SIGTERM at the death of the parent, and become the program."""
    parent, program = int(sys.argv[1]), sys.argv[2:]
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    # The parent may have died before it was asked for.
    if os.getppid() == parent:
        os.execv(program[0], program)


if __name__ == "__main__":
    main()
