"""STL files, binary and ASCII, read by numpy-stl and checked for being whole."""

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt
import stl

from triaxis.golden.errors import InputError

_HEADER_BYTES = 84
_FACET_BYTES = 50

Facets = npt.NDArray[np.float32]


def _check_ascii(path: Path, data: bytes) -> None:
    """Raise InputError unless the text holds whole facets up to its endsolid."""
    text = data.decode("ascii", errors="replace")
    words = re.findall(r"\b(endfacet|facet|vertex|endsolid)\b", text, re.IGNORECASE)
    count = dict.fromkeys(("facet", "endfacet", "vertex", "endsolid"), 0)
    for word in words:
        count[word.lower()] += 1
    facets = count["facet"]
    if count["endfacet"] != facets or count["vertex"] != 3 * facets or not count["endsolid"]:
        raise InputError(
            f"{path}: truncated or malformed ASCII STL after facet {max(count['endfacet'] - 1, 0)}: "
            f"{facets} facets begin, {count['endfacet']} end, {count['vertex']} vertices, "
            f"{'an' if count['endsolid'] else 'no'} endsolid; export it again"
        )


def _check_binary(path: Path, data: bytes) -> None:
    """Raise InputError unless the size is exactly what the header's facet count says."""
    if len(data) < _HEADER_BYTES:
        raise InputError(
            f"{path}: {len(data)} bytes: a binary STL has at least {_HEADER_BYTES}; not an STL file, "
            "or truncated"
        )
    facets = int.from_bytes(data[80:84], "little")
    expected = _HEADER_BYTES + _FACET_BYTES * facets
    if len(data) != expected:
        raise InputError(
            f"{path}: {len(data)} bytes, but its header announces {facets} facets, {expected} bytes; "
            "truncated or not an STL file, export it again"
        )


def read_stl(path: Path) -> Facets:
    """Read the facets of an STL file: float32 of shape (N, 3, 3): facet, vertex, coordinate.

    Raises InputError where the file is missing, empty, truncated, holds no facet, or a coordinate
    is not finite. Normals in the file are ignored.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot read: {error.strerror}") from error
    if not data:
        raise InputError(f"{path}: empty file: an STL with at least one facet is needed")
    # Binary files whose header begins with "solid" exist, so the size has the last word.
    whole_binary = len(data) >= _HEADER_BYTES and len(data) == _HEADER_BYTES + _FACET_BYTES * int.from_bytes(
        data[80:84], "little"
    )
    is_ascii = not whole_binary and data.lstrip()[:5].lower() == b"solid"
    if is_ascii:
        _check_ascii(path, data)
        if not re.search(rb"\bfacet\b", data, re.IGNORECASE):
            raise InputError(f"{path}: no facets: an STL with at least one is needed")
    else:
        _check_binary(path, data)
    mode = stl.Mode.ASCII if is_ascii else stl.Mode.BINARY
    try:
        mesh = stl.mesh.Mesh.from_file(str(path), calculate_normals=False, mode=mode)
    except (AssertionError, RuntimeError, ValueError, OverflowError) as error:
        raise InputError(f"{path}: not a readable STL: {str(error).splitlines()[0]}") from error
    facets = np.asarray(mesh.vectors, np.float32)
    if len(facets) == 0:
        raise InputError(f"{path}: no facets: an STL with at least one is needed")
    wrong = ~np.isfinite(facets)
    if wrong.any():
        facet, vertex, coordinate = (int(i) for i in np.argwhere(wrong)[0])
        raise InputError(
            f"{path}: facet {facet}, vertex {vertex}, coordinate {'xyz'[coordinate]}: "
            f"{facets[facet, vertex, coordinate]} is not a finite number"
        )
    return facets
