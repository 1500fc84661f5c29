import struct
from fractions import Fraction

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.host.stl import read_stl

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
        assert (read_stl(path).facets.astype(np.float32) == FACETS).all()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty file"),
        (binary(FACETS)[:-1], "183 bytes, but its header announces 2 facets, 184"),
        (binary(FACETS)[:60], "60 bytes"),
        (binary(FACETS) + b"x", "185 bytes"),
        (binary(FACETS[:0]), "no facets"),
        (binary(FACETS, b"solid cube")[:-1], "183 bytes, but its header announces 2 facets, 184"),
        (b"solid\nendsolid\n", "no facets"),
        (b"solid x", "0 facets, then the end: 1 solids begin, 0 end"),
        (ascii_text(FACETS).split("endloop")[0].encode(), "the file ends within it"),
        (ascii_text(FACETS).replace("endsolid made by a test", "").encode(), "1 solids begin, 0 end"),
        (
            ascii_text(FACETS).replace("      vertex 0 1 0\n", "").encode(),
            "'endloop' where 'vertex' was expected",
        ),
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


@pytest.mark.parametrize("number", ["one", "1,5", "1_0", "nan", "1e", "0x1"])
def test_malformed_numbers_name_the_facet(tmp_path, number):
    path = tmp_path / "words.stl"
    path.write_text(ascii_text(FACETS).replace("vertex 1 0 1", f"vertex {number} 0 1"))
    with pytest.raises(InputError, match=rf"words\.stl: facet 1: '{number}' is not a finite"):
        read_stl(path)


@pytest.mark.parametrize(("number", "read"), [("1e999", "inf"), ("1e308", r"1e\+308")])
def test_numbers_beyond_any_length(tmp_path, number, read):
    path = tmp_path / "huge.stl"
    path.write_text(ascii_text(FACETS).replace("vertex 1 0 1", f"vertex {number} 0 1"))
    with pytest.raises(
        InputError, match=f"facet 1, vertex 1, coordinate x: {read}: must be a number of at most"
    ):
        read_stl(path)


VARIANTS = {
    "several solids": lambda text: text + text.replace("made by a test", "facet vertex endsolid"),
    "upper case": str.upper,
    "tabs": lambda text: text.replace("  ", "\t"),
    "double spaces": lambda text: text.replace("facet normal", "facet  normal").replace("outer ", "outer   "),
    "DOS line ends": lambda text: text.replace("\n", "\r\n"),
    "old Mac line ends": lambda text: text.replace("\n", "\r"),
    "byte order mark": lambda text: "\ufeff" + text,
    "strange normals": lambda text: text.replace("normal 0 0 1", "normal -nan(ind) nan inf"),
    "no name": lambda text: text.replace(" made by a test", ""),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_ascii_variants(tmp_path, variant):
    path = tmp_path / "variant.stl"
    path.write_bytes(VARIANTS[variant](ascii_text(FACETS)).encode())
    facets = read_stl(path).facets
    expected = np.concatenate([FACETS, FACETS]) if variant == "several solids" else FACETS
    assert (facets.astype(np.float32) == expected).all()


def test_decimals_are_not_rounded_to_float32(tmp_path):
    path = tmp_path / "fine.stl"
    path.write_text(ascii_text(FACETS).replace("vertex 1 0 1", "vertex 40000.0019 0 1"))
    mesh = read_stl(path)
    error = abs(Fraction(float(mesh.facets[1, 1, 0])) - Fraction("40000.0019"))
    assert 0 < error <= mesh.rounding < Fraction(1, 10**10)
    path.write_bytes(binary(FACETS))
    assert read_stl(path).rounding == 0


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="cannot read"):
        read_stl(tmp_path / "missing.stl")
