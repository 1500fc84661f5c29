"""C++ of ours as shared libraries, compiled on first use and kept in native/ of the build folder.

The name of a library ends in a hash of its sources, the flags, the compiler and the processor that it
was compiled for, so it is compiled again exactly when one of them changes.
"""

import ctypes
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import build_folder

BUILD = build_folder() / "native"

# Not -ffast-math, ever: the arithmetic rests on correctly rounded operations in the order written. The
# compiler may fuse a product with a sum: sources here show that their products are exact, or that it does
# not matter.
_FLAGS = ("-O3", "-march=native", "-std=c++20", "-fPIC", "-shared")


def cxx() -> str:
    """Return the name of the C++ compiler: $CXX, or c++."""
    return os.environ.get("CXX") or "c++"


@cache
def target(compiler: str) -> str:
    """Return what the compiler says of itself and of this processor: its predefined macros.

    Raises InputError where there is no such compiler, or it is too old.
    """
    if shutil.which(compiler) is None:
        raise InputError(
            f"{compiler}: not found: install it (Debian: apt-get install g++), or set CXX to one program"
        )
    command = [compiler, *_FLAGS[:3], "-dM", "-E", "-x", "c++", os.devnull]
    answer = subprocess.run(command, capture_output=True, text=True, check=False, env=_english())
    if answer.returncode:
        first = _first_error(answer.stderr)
        raise InputError(f"{compiler}: {first}: a compiler for C++20 is needed: install one, or set CXX")
    return answer.stdout


def _english() -> dict[str, str]:
    return {**os.environ, "LC_ALL": "C"}


def _first_error(messages: str) -> str:
    lines = messages.strip().splitlines()
    return next((line for line in lines if "error:" in line), lines[0] if lines else "no message").strip()


def written(files: Sequence[Path]) -> list[tuple[int, int] | None]:
    """Return what is another once one of the files was written to, though it may say the same again."""
    found: list[tuple[int, int] | None] = []
    for file in files:
        try:
            status = file.stat()
        except OSError:
            found.append(None)
        else:
            found.append((status.st_ino, status.st_ctime_ns))
    return found


def _file(name: str, files: Sequence[Path]) -> str:
    """Return the name of a library's file."""
    digest = hashlib.sha256()
    for text in (target(cxx()), *_FLAGS):
        digest.update(text.encode() + b"\0")
    for file in files:
        digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return f"{name}-{digest.hexdigest()[:12]}.so"


def _compile(name: str, sources: Sequence[Path], output: Path) -> None:
    """Compile to a temporary name and rename: whoever compiles the same meanwhile does no harm."""
    output.parent.mkdir(parents=True, exist_ok=True)
    print(f"compiling {name} (once) ..", file=sys.stderr, flush=True)
    with tempfile.TemporaryDirectory(prefix=f".{name}-", dir=output.parent) as folder:
        partial = Path(folder, output.name)
        command = [cxx(), *_FLAGS, *map(str, sources), "-o", str(partial)]
        answer = subprocess.run(command, capture_output=True, text=True, check=False, env=_english())
        if answer.returncode:
            log = output.with_suffix(".log")
            log.write_text(f"{' '.join(command)}\n{answer.stderr}")
            first = _first_error(answer.stderr)
            raise InputError(f"{name}: {cxx()} fails: {first} (log: {log})")
        partial.replace(output)


def native_library(name: str, sources: Sequence[Path], headers: Sequence[Path] = ()) -> ctypes.CDLL:
    """Return the shared library of C++ ``sources``, compiled where needed.

    ``headers`` are those of ours that the sources include. Raises InputError where there is no compiler
    or it fails.
    """
    files = [*sources, *headers]
    before = written(files)
    output = BUILD / _file(name, files)
    if not output.is_file():
        _compile(name, sources, output)
        if written(files) != before:
            output.unlink()
            raise InputError(f"{name}: its sources changed while it was compiled: run again")
    return ctypes.CDLL(str(output))


def native_function(
    library: str, function: str, arguments: str, folder: Path, headers: Sequence[Path] = ()
) -> Callable[..., None]:
    """Return a function without a result of the library of one source, ``library``.cpp in a folder.

    ``arguments``: the type of each, "p" an address, "i" an integer of 64 bits.
    """
    found = getattr(native_library(library, [folder / f"{library}.cpp"], headers), function)
    found.argtypes = [ctypes.c_void_p if kind == "p" else ctypes.c_int64 for kind in arguments]
    found.restype = None
    return found
