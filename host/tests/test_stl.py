import re
import struct
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.host import stl
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


FACET = "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet"
TEXT = ascii_text(FACETS)
BAD_NUMBER, BEYOND = r"line 12: word '{}': facet 1: .* number", "facet 1, vertex 1, coordinate x: {}: "


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty file"),
        (bytes(83), "83 bytes: a binary STL has at least 84; not an STL file, or truncated"),
        (binary(FACETS)[:-1], "183 bytes, but its header announces 2 facets, 184"),
        (binary(FACETS) + b"x", "185 bytes"),
        (binary(FACETS[:0]), "no facets"),
        (binary(FACETS, b"solid cube")[:-1], "183 bytes, but its header announces 2 facets, 184"),
        (binary(FACETS + np.array([[[0]], [[np.nan]]])), "facet 1, vertex 0, coordinate x"),
        ("solid\nendsolid\n", "no facets"),
        (TEXT.split("endloop")[0], "the file ends within it"),
        (TEXT.replace("endsolid made by a test", ""), "2 facets, then the end, without"),
        (TEXT.replace("vertex 0 1 0\n", ""), "line 6: word 'endloop': facet 0: 'vertex' must stand here"),
        (b"\x89PNG not a mesh at all, but long enough to be one, as files go." * 3, "not an STL"),
        # Numbers that are none, or too large.
        *((TEXT.replace("vertex 1 0 1", f"vertex {number} 0 1"), BAD_NUMBER.format(number))
          for number in ("one", "1,5", "1_0", "nan", "1e", "0x1")),
        (TEXT.replace("vertex 1 0 1", "vertex 1e999 0 1"), BEYOND.format("inf")),
        (TEXT.replace("vertex 1 0 1", "vertex 1e308 0 1"), BEYOND.format(r"1e\+308")),
        # Words where they must not stand.
        (f"solid\n{FACET}\nendsolid\n{FACET}\n", "line 4: word 'facet': 'solid' must"),
        (f"solid\n{FACET}\nsolid\nendsolid\nendsolid\n", "line 3: word 'solid': facet 1: 'facet' must"),
        (f"solid\r\n{FACET}\r\nendsolidx\r\n", "line 3: word 'endsolidx': 'endsolid' must"),
        (f"solid\n{FACET}endsolid\n", "line 2: word 'endfacetendsolid': facet 0: 'endfacet' must"),
        (f"solidity\n{FACET}\nendsolid\n", "line 1: word 'solidity': 'solid' must"),
        (f"solid\n{FACET.replace('0 0 1', '0 0 facet')}\nendsolid\n", "word 'facet': facet 0: .* number"),
        (f"solid\n{FACET.replace('0 0 1', '0 0 ' + '1' * 101)}\nendsolid\n", "longer than 100 characters"),
        (f"solid\n{FACET.replace('1 0 0', '1 0 ' + '0' * 101)}\nendsolid\n", "longer than 100 characters"),
    ],
)  # fmt: skip
def test_broken_files_are_refused_in_a_line(tmp_path, content, message):
    path = tmp_path / "broken.stl"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError, match=message) as caught:
        read_stl(path)
    assert str(caught.value).startswith(f"{path}: ") and "\n" not in str(caught.value)
    with pytest.raises(InputError, match="cannot read"):
        read_stl(tmp_path / "none.stl")


VARIANTS = {
    "several solids": lambda text: text + text.replace("made by a test", "solid endsolid facets"),
    "upper case": str.upper,
    "DOS line ends": lambda text: text.replace("\n", "\r\n"),
    "byte order mark": lambda text: "\ufeff" + text,
    "strange normals": lambda text: text.replace("normal 0 0 1", "normal -nan(ind) 1.#QNAN INF"),
    "one line a solid": lambda text: "solid\n" + " ".join(text.split("\n")[1:]),
    "names of any letters": lambda text: text.replace("made by", "\u00e9t\u00e9\t"),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_ascii_variants(tmp_path, variant):
    path = tmp_path / "variant.stl"
    path.write_bytes(VARIANTS[variant](ascii_text(FACETS)).encode())
    facets = read_stl(path).facets
    expected = np.concatenate([FACETS, FACETS]) if variant == "several solids" else FACETS
    assert (facets.astype(np.float32) == expected).all()


@pytest.mark.parametrize("name", ["", " named"])
@pytest.mark.parametrize("glue", [" ", "\t", "\f", "\v", "\x1c", "\x85", "\u2028", " name "])
def test_no_facet_hides_in_a_name(tmp_path, name, glue):
    path, hidden = tmp_path / "hidden.stl", f"{name}{glue}{FACET}"
    for line, begins, ends in ((1, f"solid{hidden}", "endsolid"), (3, "solid", f"endsolid{hidden}")):
        path.write_bytes(f"{begins}\n{FACET}\n{ends}\n".encode())
        with pytest.raises(InputError, match=rf"line {line}: word '"):
            read_stl(path)


@pytest.mark.parametrize("block", [1, 200, 1 << 22])
def test_blocks_neither_lose_nor_join_facets(tmp_path, monkeypatch, block, rng):
    monkeypatch.setattr("triaxis.host.stl._BLOCK", block)
    facets = rng.integers(-999, 999, (40, 3, 3)).astype(np.float32)
    path = tmp_path / "blocks.stl"
    text = ascii_text(facets)
    path.write_text(text)
    assert (read_stl(path).facets == facets).all()
    for place in (match.end() for match in re.finditer("endfacet", text)):
        path.write_text(text[:place] + text[place:].lstrip())
        with pytest.raises(InputError, match=r"word 'endfacet(end|facet)"):
            read_stl(path)


def slowly_read(text):
    """Return the coordinates of a text, word for word; None where it is not an STL."""
    lines = enumerate(re.split(r"\r\n|\r|\n", text.lower()))
    words = [(number, word) for number, line in lines for word in re.findall(r"[^\x00-\x20\x7f]+", line)]
    found = []

    def follows(wanted):
        return bool(words) and words[0][1] == wanted

    def name_line(keyword):
        if not follows(keyword):
            raise ValueError(keyword)
        line = words.pop(0)[0]
        while words and words[0][0] == line:
            if words.pop(0)[1] in set(filter(str.isalpha, FACET.split())):
                raise ValueError("facet in a name")

    try:
        while words:
            name_line("solid")
            while follows("facet"):
                numbers = []
                for (_, word), model in zip(words[:21], FACET.split(), strict=True):
                    if not model.isalpha():
                        numbers.append(float(word))
                    elif word != model:
                        raise ValueError(word)
                words = words[21:]
                found.append(numbers[3:])
            name_line("endsolid")
    except ValueError:
        return None
    return np.array(found).reshape(-1, 3, 3)


OTHERS = [
    *(" ", "\n", "\r", "\r\n", "\t", "\f", "\v", "\x1c", "\x85", "\x7f", "", " \n "), *FACET.split(),
    "solid", "endsolid", "endsolid x\nsolid y\n", "name", f"\n{FACET}\n", FACET,
]  # fmt: skip


def mutated(text, rng):
    """Return a text with a word or blank dropped, doubled, moved, replaced, or a character put in."""
    pieces = re.findall(r"\s+|\S+", text)
    place, other = rng.integers(0, len(pieces), 2)
    new = OTHERS[rng.integers(0, len(OTHERS))]
    match rng.integers(0, 6):
        case 0:
            pieces[place : place + rng.integers(1, 4)] = []
        case 1:
            pieces[place:place] = pieces[place : place + rng.integers(1, 50)]
        case 2:
            pieces[place] = pieces[other]
        case 3:
            pieces[place] = new
        case 4:
            pieces.insert(place, new)
        case _:
            # Within a line that holds a name, where most of the harm is done.
            lines = [n for n, piece in enumerate(pieces) if piece.endswith("solid")]
            near = lines[rng.integers(0, len(lines))] + rng.integers(0, 9) if lines else place
            pieces[near : near + rng.integers(0, 2)] = [new]
    return "".join(pieces)


def test_mutated_files_are_read_whole_or_refused(tmp_path, rng):
    path = tmp_path / "mutated.stl"
    text = ascii_text(FACETS)
    outcomes = {"read": 0, "refused": 0}
    for _ in range(400):
        changed = mutated(text + text, rng)
        for _ in range(rng.integers(0, 2)):
            changed = mutated(changed, rng)
        path.write_bytes(changed.encode())
        wanted = slowly_read(changed)
        try:
            facets = read_stl(path).facets
        except InputError:
            outcomes["refused"] += 1
            continue
        outcomes["read"] += 1
        assert wanted is not None, repr(changed)
        assert np.array_equal(facets, wanted), repr(changed)
    assert min(outcomes.values()) > 40, outcomes


def test_decimals_are_not_rounded_to_float32(tmp_path):
    path = tmp_path / "fine.stl"
    path.write_text(ascii_text(FACETS).replace("vertex 1 0 1", "vertex 40000.0019 0 1"))
    mesh = read_stl(path)
    error = abs(Fraction(float(mesh.facets[1, 1, 0])) - Fraction("40000.0019"))
    assert 0 < error <= mesh.rounding < Fraction(1, 10**10)
    path.write_bytes(binary(FACETS))
    assert read_stl(path).rounding == 0


def test_numbers_are_what_a_grammar_says():
    """For all short texts: in some versions of Python a pattern that is quick to match is matched wrongly."""
    number = r"(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?"
    coordinate, normal = (
        re.compile(f"[+-]?(?:{one})".encode()) for one in (number, f"{number}(?:#\\w+)?|inf")
    )
    for length in range(1, 5):
        for letters in product(b"1.e+-#", repeat=length):
            word = bytes(letters)
            assert stl._is_right(8, [b"1", word]) == bool(coordinate.fullmatch(word)), word
            assert stl._is_right(2, [word, b"inf"]) == bool(normal.fullmatch(word)), word
