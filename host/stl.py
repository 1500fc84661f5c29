"""STL files: binary ones read by numpy-stl, ASCII ones by a strict reader of our own.

numpy-stl reads ASCII files up to their first ``endsolid`` only, and rounds their decimals to float32;
either would let a collision be missed.
"""

import io
import re
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import numpy.typing as npt
import stl

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import Place, read_input

_HEADER_BYTES = 84
_FACET_BYTES = 50
# More than any length, and its quotients by any resolution are far from overflow.
_LARGEST = 1e30

Facets = npt.NDArray[np.floating]

# One facet of an ASCII file in lower case, word by word; None is a number.
_FACET_WORDS: tuple[bytes | None, ...] = (
    *(b"facet", b"normal", None, None, None, b"outer", b"loop"),
    *(b"vertex", None, None, None) * 3,
    *(b"endloop", b"endfacet"),
)
_FIRST_COORDINATE = 8
# A number written in full, as %f does, has 39 digits before its point at most, if it is a float32.
_LONGEST_WORD = 100
# Of these letters `float` takes what is a number in an STL file, and nothing else.
_IN_NUMBERS = b"0123456789.e+-"
# Exporters write normals of facets without area as nan, -nan(ind), 1.#QNAN, inf .. Possessive where one class
# repeats, and nowhere else: before Python 3.11.5 a possessive group may be matched wrongly.
_NORMALS = re.compile(
    rb"(?:[+-]?+(?:(?:\d++\.?\d*+|\.\d++)(?:e[+-]?+\d++)?(?:#\w++)?|(?:nan|inf|infinity)(?:\(\w++\))?) )*"
)

_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_ASCII = re.compile(rb"(?:" + _BYTE_ORDER_MARK + rb")?\s*solid", re.IGNORECASE)
_WORD = re.compile(rb"\S+")
_FACET_END = re.compile(rb"endfacet\s")
_LINE_END = re.compile(rb"[\r\n]")
# Set apart by anything but visible ASCII: some readers take more for blanks than others.
_IN_NAME = re.compile(rb"(?<![!-~])(?:facet|normal|outer|loop|vertex|endloop|endfacet)(?![!-~])")
# Bytes split into words at a time: bounds the memory.
_BLOCK = 1 << 22


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
    data = read_input(path)
    if not data:
        raise InputError(f"{path}: empty file: an STL with at least one facet is needed")
    # Binary files whose header begins with "solid" exist: the size has the last word, and text has no zeros.
    is_ascii = bool(_ASCII.match(data)) and len(data) != _binary_size(data) and b"\0" not in data
    facets = _read_ascii(path, data) if is_ascii else _read_binary(path, data)
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
    """Read the facets of all solids of an ASCII STL, word by word. Lines matter to names alone."""
    text = data.removeprefix(_BYTE_ORDER_MARK).lower()
    tables = [np.empty((0, 9))]
    start = count = 0
    while word := _WORD.search(text, start):
        start = _end_of_name(path, word, b"solid")
        end = text.find(b"endsolid", start)
        for block in _blocks(text, start, end if end >= 0 else len(text)):
            tables.append(_facets(path, text, *block, count))
            count += len(tables[-1])
        last = _WORD.search(text, end) if end >= 0 else None
        if last is None:
            raise InputError(
                f"{path}: {count} facets, then the end, without 'endsolid': truncated, export it again"
            )
        start = _end_of_name(path, last, b"endsolid")
    return np.concatenate(tables).reshape(-1, 3, 3)


def _end_of_name(path: Path, word: re.Match[bytes], wanted: bytes) -> int:
    """Return where the line ends that a word begins; raise InputError where it is not the one wanted.

    A name may hold any words, but not those of a facet, which would be lost with it.
    """
    if word[0] != wanted:
        raise _error(path, word, f"'{wanted.decode()}' must stand here: export it again")
    line_end = _LINE_END.search(word.string, word.end())
    end = line_end.start() if line_end else len(word.string)
    if found := _IN_NAME.search(word.string, word.end(), end):
        raise _error(
            path, found, "in the name of a solid, where a facet may get lost: end the line before it"
        )
    return end


def _blocks(text: bytes, start: int, end: int) -> Iterator[tuple[int, int]]:
    while start < end:
        cut = _FACET_END.search(text, min(start + _BLOCK, end), end)
        stop = cut.end() if cut else end
        yield start, stop
        start = stop


def _facets(path: Path, text: bytes, start: int, stop: int, before: int) -> npt.NDArray[np.float64]:
    """Return the coordinates (N, 9) of the facets in a block, which come after ``before`` others."""
    words = text[start:stop].split()
    size = len(_FACET_WORDS)
    count, rest = divmod(len(words), size)
    columns = [words[index::size] for index in range(size)]
    # The last word may go on beyond the block.
    if (
        rest
        or not (stop == len(text) or text[stop - 1 : stop].isspace())
        or not all(_is_right(index, column) for index, column in enumerate(columns))
    ):
        raise _wrong_word(path, text, start, before)
    coordinates = [c for i, c in enumerate(columns) if i >= _FIRST_COORDINATE and _FACET_WORDS[i] is None]
    return np.stack([np.fromiter(map(float, column), np.float64, count) for column in coordinates], axis=1)


def _is_right(index: int, words: list[bytes]) -> bool:
    """Return whether all these words may stand at a place in a facet."""
    wanted = _FACET_WORDS[index]
    if wanted is not None:
        return words == [wanted] * len(words)
    if max(map(len, words), default=0) > _LONGEST_WORD:
        return False
    if index < _FIRST_COORDINATE:
        return _NORMALS.fullmatch(b" ".join([*words, b""])) is not None
    return _are_numbers(words)


def _are_numbers(words: list[bytes]) -> bool:
    if b"".join(words).translate(None, _IN_NUMBERS):
        return False
    try:
        deque(map(float, words), maxlen=0)
    except ValueError:
        return False
    return True


def _wrong_word(path: Path, text: bytes, start: int, facet: int) -> InputError:
    """Return the error that names the first word after ``start``, where a facet begins, that is wrong."""
    for number, word in enumerate(_WORD.finditer(text, start)):
        index = number % len(_FACET_WORDS)
        if _is_right(index, [word[0]]):
            facet += index == len(_FACET_WORDS) - 1
            continue
        wanted = _FACET_WORDS[index]
        if wanted is not None:
            why = f"'{wanted.decode()}' must stand here"
        elif len(word[0]) > _LONGEST_WORD:
            why = f"longer than {_LONGEST_WORD} characters"
        else:
            why = "not a finite decimal number"
        return _error(path, word, f"facet {facet}: {why}: export it again")
    return InputError(f"{path}: facet {facet}: the file ends within it; truncated, export it again")


def _error(path: Path, word: re.Match[bytes], why: str) -> InputError:
    before = word.string[: word.start()]
    line = 1 + before.count(b"\n") + before.count(b"\r") - before.count(b"\r\n")
    return Place(path, line).error(word[0].decode(errors="replace"), why)
