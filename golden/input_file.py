"""Files that a user names: ordinary ones only, read whole; and the NumPy arrays in them."""

import io
import math
import stat
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.lib.format
import numpy.typing as npt

from triaxis.golden.errors import InputError

_END_OF_ARCHIVE = b"PK\5\6"
_END_BYTES = 22

Array = npt.NDArray[Any]

# Readers of headers by version of the format. There is a third, for records with names beyond Latin-1.
_HEADERS = {
    (1, 0): numpy.lib.format.read_array_header_1_0,
    (2, 0): numpy.lib.format.read_array_header_2_0,
}


@dataclass(frozen=True)
class Place:
    """A line of a file, counted from 1."""

    path: Path
    line: int

    def error(self, word: str, why: str) -> InputError:
        """Return the error that names file, line and word. ``why`` ends with what to do."""
        shown = "".join(c if c.isprintable() else "?" for c in word[:20])
        return InputError(f"{self.path}: line {self.line}: word '{shown}': {why}")


def read_input(path: Path) -> bytes:
    """Return what is in a file; raise InputError unless it is an ordinary file that can be read.

    A pipe may keep its reader waiting for ever, and a device may have no end.
    """
    try:
        mode = path.stat().st_mode
        if not stat.S_ISREG(mode):
            kind = "folder" if stat.S_ISDIR(mode) else "pipe, socket or device"
            raise InputError(f"{path}: is a {kind}: name an ordinary file")
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot read: {error.strerror or error}") from error


def read_array(path: Path) -> Array:
    """Read a ``.npy`` file; raise InputError where it is none, or not as long as its header says."""
    return _array(read_input(path), str(path))


def read_archive(path: Path) -> dict[str, Array]:
    """Read the arrays of a ``.npz`` file, by name; raise InputError where it is not one, and one alone."""
    data = read_input(path)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as file:
            # Of archives one after the other, zipfile reads the last.
            first = min((member.header_offset for member in file.infolist()), default=0)
            alone = first == 0 and data[-_END_BYTES - len(file.comment) :].startswith(_END_OF_ARCHIVE)
            members = {name.removesuffix(".npy"): file.read(name) for name in file.namelist()}
            alone &= len(members) == len(file.namelist())
    except MemoryError:
        raise
    # A damaged archive makes zipfile raise almost anything.
    except Exception as error:
        raise InputError(f"{path}: not a NumPy .npz archive") from error
    if not alone:
        raise InputError(
            f"{path}: holds more than one archive of arrays, or something beside it: write it again"
        )
    return {name: _array(member, f"{path}: {name}") for name, member in members.items()}


def _array(data: bytes, name: str) -> Array:
    """Return the array that a ``.npy`` file holds, not to be written to."""
    stream = io.BytesIO(data)
    try:
        shape, by_columns, dtype = _HEADERS[numpy.lib.format.read_magic(stream)](stream)
        start, wanted = stream.tell(), math.prod(shape) * dtype.itemsize
        if dtype.hasobject or not dtype.itemsize or min(shape, default=0) < 0:
            raise ValueError("no numbers")
        if wanted == len(data) - start:
            return np.frombuffer(data, dtype, offset=start).reshape(shape, order="F" if by_columns else "C")
    except MemoryError:
        raise
    # A damaged header makes NumPy raise almost anything.
    except Exception as error:
        raise InputError(f"{name}: not a NumPy .npy file of numbers") from error
    raise InputError(
        f"{name}: {wanted} bytes of numbers by its header, but holds {len(data) - start}: write it again"
    )
