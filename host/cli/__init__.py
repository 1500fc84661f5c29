"""The command line ``triaxis``.

Exit codes, of all commands: 0 done, or the answer is yes; 1 the answer is no, something failed, or a bound is
missed; 2 bad input or a missing tool: there is no answer; 130 interrupted. What 0 and 1 mean for a command
stands in `triaxis.host.cli.commands`, and in its help.

This module is small, and imports little: what an earlier run answered is removed, and interrupts are
understood, before anything that takes time is imported.
"""

import errno
import os
import signal
import sys
import time
from io import TextIOWrapper
from types import FrameType
from typing import NoReturn, TextIO

DONE, NO, ERROR, INTERRUPTED = 0, 1, 2, 130

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_interrupted = False
# Seconds in which a second signal is taken for the first one.
_TOGETHER = 0.5
# What to do about what a file system refuses.
_TO_DO = {
    **dict.fromkeys((errno.EACCES, errno.EPERM), ": make it readable and writable for you"),
    errno.EROFS: ": work where you can write", errno.ENOSPC: ": make room there",
}  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    """Run a command line, or that of this process with its signals; return the exit code."""
    if arguments is not None:
        return _answer(arguments, of_this_process=False)
    # Until the older answers are gone an interrupt waits.
    signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    _handle_with(_end)
    os.register_at_fork(after_in_child=_as_in_other_programs)
    sys.unraisablehook = _swallowed
    # Names of files may hold what the terminal cannot show.
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        code = _answer(sys.argv[1:], of_this_process=True)
        # There is an answer now, and it stands.
        _handle_with(signal.SIG_IGN)
        return code
    except KeyboardInterrupt:
        # Python gives signals back at its end, where another one would end it without an exit code.
        _handle_with(signal.SIG_IGN)
        # It may have come just when there was an answer. None comes before these are imported.
        from triaxis.host.cli.commands import withdraw_yes

        withdraw_yes(sys.argv[1:])
        _say_interrupted()
        _drop_output()
        return INTERRUPTED


def tritest() -> int:
    """Run ``tritest ..``, which is ``triaxis tritest ..``."""
    sys.argv.insert(1, "tritest")
    return main()


def _answer(words: list[str], of_this_process: bool) -> int:
    from triaxis.golden.errors import ToldError
    from triaxis.host.cli.commands import find, remove_older_answers, runner, withdraw_yes

    try:
        name, rest = find(words)
        remove_older_answers(name, rest)
        if of_this_process:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)
        run = runner(name, rest)
        # While modules were imported there was nothing to clean up, and they may not be left halfway.
        if of_this_process:
            _handle_with(_interrupt)
        code = run()
        if _interrupted:
            # What failed for it may have been tried again.
            raise KeyboardInterrupt
        if sys.stdout is not None:
            sys.stdout.flush()
        return code
    except ToldError as error:
        message = str(error)
    except KeyboardInterrupt:
        withdraw_yes(words)
        raise
    except MemoryError:
        message = "out of memory: use a smaller input"
    except OSError as error:
        # Whoever read our output is gone, or the disk is full: say no more on stdout.
        _drop_output()
        to_do = _TO_DO.get(error.errno or 0, "")
        message = f"{error.filename or 'output'}: {error.strerror or error}{to_do}"
    # No failure of our own may look like an answer: `check` says "near" with exit code 1.
    except Exception as error:
        if os.environ.get("TRIAXIS_DEBUG"):
            from traceback import format_exc

            _say(format_exc())
        message = f"internal: {type(error).__name__}: {error} (TRIAXIS_DEBUG=1 shows where)"
        if isinstance(error, ModuleNotFoundError) and not f"{error.name}".startswith("triaxis"):
            message = f"{error.name} is not installed: pip install 'triaxis[signoff]'"
    withdraw_yes(words)
    if _interrupted:
        # What was interrupted may fail for it in ways of its own.
        raise KeyboardInterrupt
    _say(f"triaxis: error: {' '.join(message.split())}\n")
    return ERROR


def _handle_with(handler: "signal._HANDLER") -> None:
    for number in _SIGNALS:
        # Those that whoever started this process has set to be ignored stay so, as under nohup.
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _end(_number: int, _frame: FrameType | None) -> NoReturn:
    _say_interrupted()
    os._exit(INTERRUPTED)


def _interrupt(_number: int, _frame: FrameType | None) -> NoReturn:
    global _interrupted
    _interrupted = True
    # A second one does not wait for what the first one cleans up; but they often come in pairs.
    begun = time.monotonic()
    _handle_with(lambda *_: _end(*_) if time.monotonic() - begun > _TOGETHER else None)
    raise KeyboardInterrupt


def _swallowed(found: "sys.UnraisableHookArgs") -> None:
    """Send an interrupt again that fell into a callback of Python's own, as of a weak reference."""
    caught = [number for number in _SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    if not isinstance(found.exc_value, KeyboardInterrupt) or not caught:
        sys.__unraisablehook__(found)
        return
    from threading import Timer

    _handle_with(_interrupt)
    # Not at once: it would fall in here.
    Timer(0.05, os.kill, (os.getpid(), caught[0])).start()


def _say_interrupted() -> None:
    # In a handler: what was about to be written elsewhere may be half done.
    try:
        os.write(2, b"triaxis: interrupted\n")
    # Nobody hears.
    except OSError:
        return


def _say(text: str) -> None:
    if sys.stderr is None:
        return
    try:
        sys.stderr.write(text)
        sys.stderr.flush()
    # Nobody hears.
    except OSError:
        _drop(sys.stderr)


def _drop_output() -> None:
    """Leave nothing to be written when the process ends, where that can fail."""
    if sys.stdout is None:
        return
    try:
        sys.stdout.flush()
    except OSError:
        _drop(sys.stdout)


def _drop(stream: TextIO) -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _as_in_other_programs() -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
