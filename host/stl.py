"""STL files: binary ones read by numpy-stl, ASCII ones by a strict reader of our own.

numpy-stl reads ASCII files up to their first ``endsolid`` only, and rounds their decimals to float32;
either would let a collision be missed.
"""

import io
import re
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import numpy.typing as npt
import stl

from triaxis.golden.errors import InputError

_HEADER_BYTES = 84
_FACET_BYTES = 50
# More than any length, and its quotients by any resolution are far from overflow.
_LARGEST = 1e30

Facets = npt.NDArray[np.floating]

# One facet of an ASCII file, word by word; None is a number.
_FACET_WORDS: tuple[str | None, ...] = (
    *("facet", "normal", None, None, None, "outer", "loop"),
    *("vertex", None, None, None) * 3,
    *("endloop", "endfacet"),
)
_COORDINATES = np.array([8, 9, 10, 12, 13, 14, 16, 17, 18])
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


@dataclass(frozen=True)
class StlMesh:
    """Facets (N, 3, 3): facet, vertex, coordinate; and the most that reading moved a coordinate.

    ``rounding`` is 0 for binary files, whose float32 numbers are taken as they are. Decimals of ASCII
    files become the nearest float64.
    """

    facets: Facets
    rounding: Fraction


def read_stl(path: Path) -> StlMesh:
    """Read an STL file. Normals in it are ignored.

    Raises InputError where the file is missing, empty, truncated, malformed, holds no facet, or a
    coordinate is not finite.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot read: {error.strerror}") from error
    if not data:
        raise InputError(f"{path}: empty file: an STL with at least one facet is needed")
    text = data.removeprefix(b"\xef\xbb\xbf").lstrip()
    # Binary files whose header begins with "solid" exist: the size has the last word, and text has no zeros.
    is_ascii = text[:5].lower() == b"solid" and len(data) != _binary_size(data) and b"\0" not in data
    facets = _read_ascii(path, text) if is_ascii else _read_binary(path, data)
    if len(facets) == 0:
        raise InputError(f"{path}: no facets: an STL with at least one is needed")
    wrong = ~(np.abs(facets) <= _LARGEST)
    if wrong.any():
        facet, vertex, coordinate = (int(i) for i in np.argwhere(wrong)[0])
        raise InputError(
            f"{path}: facet {facet}, vertex {vertex}, coordinate {'xyz'[coordinate]}: "
            f"{facets[facet, vertex, coordinate]}: must be a number of at most {_LARGEST:g}; export it again"
        )
    # Rounding to nearest is off by at most 2^-53 of the number, or 2^-1075 for the tiniest.
    largest = Fraction(float(np.abs(facets).max()))
    rounding = largest / 2**53 + Fraction(1, 2**1075) if is_ascii else Fraction(0)
    return StlMesh(facets, rounding)


def _binary_size(data: bytes) -> int:
    """Return the size that a binary STL with this header has; 0 where there is no whole header."""
    if len(data) < _HEADER_BYTES:
        return 0
    return _HEADER_BYTES + _FACET_BYTES * int.from_bytes(data[80:84], "little")


def _read_binary(path: Path, data: bytes) -> Facets:
    """Read a binary STL whose size is exactly what its header says."""
    if len(data) < _HEADER_BYTES:
        raise InputError(
            f"{path}: {len(data)} bytes: a binary STL has at least {_HEADER_BYTES}; not an STL file, "
            "or truncated"
        )
    if len(data) != _binary_size(data):
        announced = int.from_bytes(data[80:84], "little")
        raise InputError(
            f"{path}: {len(data)} bytes, but its header announces {announced} facets, "
            f"{_binary_size(data)} bytes; truncated or not an STL file, export it again"
        )
    mesh = stl.mesh.Mesh.from_file(
        str(path), calculate_normals=False, fh=io.BytesIO(data), mode=stl.Mode.BINARY
    )
    return np.array(mesh.vectors, np.float32)


def _read_ascii(path: Path, data: bytes) -> Facets:
    """Read an ASCII STL of any number of solids, word by word."""
    text = data.decode("ascii", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    # A solid's name runs to the end of its line, and may hold any word.
    body, ends = re.subn(r"^[ \t]*endsolid\b.*$", "", text, flags=re.MULTILINE | re.IGNORECASE)
    body, begins = re.subn(r"^[ \t]*solid\b.*$", "", body, flags=re.MULTILINE | re.IGNORECASE)
    words = body.split()
    size = len(_FACET_WORDS)
    for position in range(0, len(words), size):
        _check_facet(path, position // size, words[position : position + size])
    if begins != ends:
        raise InputError(
            f"{path}: {len(words) // size} facets, then the end: {begins} solids begin, {ends} end; "
            "truncated, export it again"
        )
    table = np.array(words, np.str_).reshape(-1, size)
    return table[:, _COORDINATES].astype(np.float64).reshape(-1, 3, 3)


def _check_facet(path: Path, facet: int, words: list[str]) -> None:
    """Raise InputError where the words are not one whole facet."""
    for index, wanted in enumerate(_FACET_WORDS):
        if index >= len(words):
            raise InputError(f"{path}: facet {facet}: the file ends within it; truncated, export it again")
        word = words[index]
        if wanted is not None and word.lower() != wanted:
            raise InputError(f"{path}: facet {facet}: {word[:20]!r} where {wanted!r} was expected")
        # Normals are ignored, whatever they are.
        is_coordinate = wanted is None and index > _FACET_WORDS.index("vertex")
        if is_coordinate and not _NUMBER.fullmatch(word):
            raise InputError(f"{path}: facet {facet}: {word[:20]!r} is not a finite decimal number")
