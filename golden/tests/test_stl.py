import struct

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.stl import read_stl

FACETS = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 1.5], [1, 0, 1], [0, -1e-3, 1]]], np.float32)


def binary(facets, header=b"made by a test"):
    body = b"".join(
        struct.pack("<12fH", 0, 0, 0, *facet.reshape(9), 0) for facet in np.asarray(facets, np.float32)
    )
    return header.ljust(80, b"\0") + struct.pack("<I", len(facets)) + body


def ascii_text(facets):
    lines = ["solid made by a test"]
    for facet in facets:
        lines += ["  facet normal 0 0 1", "    outer loop"]
        lines += [f"      vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in facet]
        lines += ["    endloop", "  endfacet"]
    return "\n".join([*lines, "endsolid made by a test", ""])


def test_binary_and_ascii(tmp_path):
    path = tmp_path / "mesh.stl"
    for content in (binary(FACETS), binary(FACETS, b"solid cube"), ascii_text(FACETS).encode()):
        path.write_bytes(content)
        assert (read_stl(path) == FACETS).all()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty file"),
        (binary(FACETS)[:-1], "183 bytes, but its header announces 2 facets, 184"),
        (binary(FACETS)[:60], "60 bytes"),
        (binary(FACETS) + b"x", "185 bytes"),
        (binary(FACETS[:0]), "no facets"),
        (b"solid\nendsolid\n", "no facets"),
        (ascii_text(FACETS)[:150].encode(), "truncated or malformed"),
        (ascii_text(FACETS).replace("endsolid made by a test", "").encode(), "no endsolid"),
        (ascii_text(FACETS).replace("      vertex 0 1 0\n", "").encode(), "5 vertices"),
        (b"\x89PNG not a mesh at all, but long enough to be one, as files go." * 3, "not an STL"),
    ],
)
def test_broken_files_name_the_file(tmp_path, content, message):
    path = tmp_path / "broken.stl"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        read_stl(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_not_finite_names_the_facet(tmp_path, value):
    facets = FACETS.copy()
    facets[1, 2, 0] = value
    path = tmp_path / "nan.stl"
    path.write_bytes(binary(facets))
    with pytest.raises(InputError, match="facet 1, vertex 2, coordinate x"):
        read_stl(path)


def test_malformed_numbers(tmp_path):
    path = tmp_path / "words.stl"
    path.write_text(ascii_text(FACETS).replace("vertex 1 0 0", "vertex one 0 0"))
    with pytest.raises(InputError, match=r"words\.stl"):
        read_stl(path)


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="cannot read"):
        read_stl(tmp_path / "missing.stl")
