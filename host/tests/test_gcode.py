"""Programs of G-code: read exactly, or refused with line and word."""

import re
import string
from fractions import Fraction

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from triaxis.golden.errors import InputError
from triaxis.host.motion.gcode import WHY_REFUSED
from triaxis.host.motion.program import read_program

ORIGIN = (Fraction(0), Fraction(0), Fraction(0))


@pytest.fixture
def read(tmp_path):
    path = tmp_path / "moves.nc"

    def read_text(text, start=ORIGIN, **options):
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_program(path, start, **options)

    return read_text


def ends(program):
    return [tuple(move.end) for move in program.moves]


ACCEPTED = [
    ("G0X10", [(10, 0, 0)]),
    ("g00 x+1.50 y-.5 z3.", [(Fraction(3, 2), Fraction(-1, 2), 3)]),
    ("G1 X1 F100\nY2\nZ3", [(1, 0, 0), (1, 2, 0), (1, 2, 3)]),
    ("G0 X1 Y1\nG91\nX1\nX0.1 Y-2", [(1, 1, 0), (2, 1, 0), (Fraction(21, 10), -1, 0)]),
    ("G20 G0 X1\nG21 X1", [(Fraction(254, 10), 0, 0), (1, 0, 0)]),
    ("X1 G0 G20", [(Fraction(254, 10), 0, 0)]),
    ("G20\nG91 G0 X.001\nX.001", [(Fraction(254, 10**4), 0, 0), (Fraction(508, 10**4), 0, 0)]),
    ("%\nO1001\n(NAME; G0 X9)\nN10 G0 X1 (G0 X8) Y2 ; X7\n%\n(end)\n \n%\n", [(1, 2, 0)]),
    ("/G0 X3\nG0 X1", [(3, 0, 0), (1, 0, 0)]),
    ("N5 G17 G40 G49 G54 G80 G90 G94 G61 G21\nT1 M6\nS1000 M3 M8\nG0 X1\nG4 P0.5\nM9 M5", [(1, 0, 0)]),
    ("%\nG0 X1 M30\n(end)\n%\n", [(1, 0, 0)]),
    ("G0 X1\r\nX2\rX3\n", [(1, 0, 0), (2, 0, 0), (3, 0, 0)]),
    ("G0 X1\nG80 G1 F5\nX2", [(1, 0, 0), (2, 0, 0)]),
    ("\ufeffG0\tX 1", [(1, 0, 0)]),
]


@pytest.mark.parametrize(("text", "wanted"), ACCEPTED)
def test_moves(read, text, wanted):
    assert ends(read(text)) == wanted


def test_moves_know_line_start_and_feed(read):
    moves = read(
        "(first)\nG20 G0 X1\n\nG1 Y2 F10\nG21 F50 Z1\n", (Fraction(1), Fraction(2), Fraction(3))
    ).moves
    assert [(move.line, move.feed) for move in moves] == [(2, None), (4, 254), (5, 50)]
    assert [move.start for move in moves] == [(1, 2, 3), *(move.end for move in moves[:-1])]


def test_what_was_assumed_is_said(read):
    assert read("G21 G0 X1").notes == ()
    assert read("G21\nG0 X1 Y2 Z3", None).notes == (
        "line 2: the first move starts at X0 Y0 Z0, which is assumed: give --start",
    )
    assert read("G21 G0 X1", None).moves[0].start == ORIGIN
    assert read("G0 X1").notes == ("line 1: no G20 or G21 before it: millimetres assumed",)
    assert "taken to be the one given" in read("G21\nT3 M6\nG0 X1").notes[0]
    assert ends(read("/G0 X3\nG0 X1", skip_optional=True)) == [(1, 0, 0)]
    assert "lines that begin with / are left out" in read("/G0 X3\nG0 X1", skip_optional=True).notes
    assert "lines that begin with / are run" in read("/G0 X3\nG0 X1").notes


REFUSED = [
    ("G0 X1\nG2 X5 I2", 2, "G2", "arcs are not supported"),
    ("G0 X1 R2", 1, "R2", "not supported"),
    ("G28 Z0", 1, "G28", "only the machine knows"),
    ("M250", 1, "M250", "not supported"),
    ("G0 X1e3", 1, "e3", "no exponent"),
    ("G0 X1,5", 1, ",5", "not a letter followed by a decimal number"),
    ("G0 X", 1, "X", "no decimal number after the letter"),
    ("G0 X#1", 1, "X#1", "parameters and expressions"),
    ("G0 X[1+2]", 1, "X[1+2]", "parameters and expressions"),
    ("G0 X1 X2", 1, "X2", "stands twice"),
    ("G0 G1 X1 F5", 1, "G1", "exclude each other"),
    ("G90 G91 G0 X1", 1, "G91", "exclude each other"),
    ("X1", 1, "X1", "no G0 or G1"),
    ("G0 X1\nG80\nX2", 3, "X2", "no G0 or G1"),
    ("G21\nG1 X1", 2, "G1", "without a feed"),
    ("G1 X1 F-5", 1, "F-5", "must not be negative"),
    ("G0 X1\nT2 M6", 2, "M6", "changes the tool"),
    ("G4 X1", 1, "X1", "may take it for a time"),
    ("G0 X1 N5", 1, "N5", "must be the first word"),
    ("O100 G0 X1", 1, "O100", "subprograms"),
    ("G0 (X1", 1, "(X1", "does not end on its line"),
    ("G0 X1) Y2", 1, ") Y2", "')' without '('"),
    ("G0 (a (b) X1", 1, "(a (b) X1", "comment within a comment"),
    ("G0 X1 /Y2", 1, "/Y2", "beginning of a line"),
    ("G0 X1234567890123456", 1, "X1234567890123456", "more than 15 digits"),
    ("G0 X0.1234567890123456", 1, "X0.1234567890123456"[:20], "more than 15 digits"),
    ("%\nG0 Z1\n%\nG1 Z-50 F9", 4, "G1", "after the end of the program"),
    ("%\nG0 Z1\nM30\n%\n%\nO2\nG0 Z-50\n%", 6, "O2", "after the end of the program"),
    ("G0 X1 M30\nG0 X2\n%", 2, "G0", "after the end of the program"),
    ("G0 Z1\nM2\n/G0 Z-50", 3, "G0", "after the end of the program"),
    ("G0 X- 1", 1, "X-", "no decimal number"),
    ("G0 X\u0661", 1, "X\u0661", "no decimal number"),
]


@pytest.mark.parametrize(("text", "line", "word", "why"), REFUSED)
def test_bad_words_are_named(read, text, line, word, why):
    with pytest.raises(InputError) as refused:
        read(text)
    message = str(refused.value)
    assert f"moves.nc: line {line}: word '{word}': " in message
    assert why in message
    assert "\n" not in message
    # What to do stands last.
    assert re.search(r"[:;] [a-z][^:;]*$", message), message


def test_words_with_a_reason_and_stray_signs_are_refused(read):
    for code, why in WHY_REFUSED.items():
        with pytest.raises(InputError, match=re.escape(why)):
            read(f"G0 X1 {code}" + ("1" if len(code) == 1 else ""))
    for sign in set(string.printable) - set(string.whitespace + string.digits + ";."):
        with pytest.raises(InputError, match="line 2: word"):
            read(f"G0 X1\nG0 {sign} X2")


def test_files_without_moves(read, tmp_path):
    for text in ("", "\n\n", "G21 G90\nM30", "(only a comment)", b"\x00"):
        with pytest.raises(InputError, match=r"no moves|line 1: word"):
            read(text)
    with pytest.raises(InputError, match="cannot read"):
        read_program(tmp_path / "no.nc", ORIGIN)


DECIMALS = st.decimals(-9999, 9999, places=4)


# A slow machine is no failure.
@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.lists(st.tuples(DECIMALS, DECIMALS, DECIMALS), min_size=1, max_size=8), st.booleans(), st.booleans()
)
def test_positions_are_exact(tmp_path_factory, steps, relative, inch):
    path = tmp_path_factory.getbasetemp() / "exact.nc"
    lines = [f"{'G20' if inch else 'G21'} {'G91' if relative else 'G90'} G0"]
    lines += [f"X{x:f} Y{y:f} Z{z:f}" for x, y, z in steps]
    path.write_text("\n".join(lines))
    scale = Fraction(254, 10) if inch else Fraction(1)
    position = [Fraction(0)] * 3
    for move, step in zip(read_program(path, ORIGIN).moves, steps, strict=True):
        position = [Fraction(c) * scale + (p if relative else 0) for c, p in zip(step, position, strict=True)]
        assert list(move.end) == position
