"""Programs of G-code: read exactly, or refused with line and word."""

import math
import re
import shutil
import string
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.host.engines import unwatched
from triaxis.host.motion import gcode, rs274
from triaxis.host.motion.curves import SLACK
from triaxis.host.motion.machine import Machine
from triaxis.host.motion.machine_file import read_machine
from triaxis.host.motion.program import read_program
from triaxis.host.motion.rs274 import completes, read_by_rs274
from triaxis.host.motion.words import GROUPS, TAKERS, WHY_REFUSED

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
    ("G0 X1\r\nX2\r\r\nX3\n", [(1, 0, 0), (2, 0, 0), (3, 0, 0)]),
    ("G0 X1\nG80 G1 F5\nX2", [(1, 0, 0), (2, 0, 0)]),
    ("\ufeffG0\tX 1", [(1, 0, 0)]),
    ("G0 X1\nM2\nO1 sub\nG0 X2\nO1 endsub", [(1, 0, 0)]),
]


@pytest.mark.parametrize(("text", "wanted"), ACCEPTED)
def test_moves(read, text, wanted):
    assert ends(read(text)) == wanted


def test_moves_know_line_and_start(read):
    moves = read(
        "(first)\nG20 G0 X1\n\nG1 Y2 F10\nG21 F50 Z1\n", (Fraction(1), Fraction(2), Fraction(3))
    ).moves
    assert [(move.line, move.rapid) for move in moves] == [(2, True), (4, False), (5, False)]
    assert [move.start for move in moves] == [(1, 2, 3), *(move.end for move in moves[:-1])]


def test_what_was_assumed_is_said(read):
    # All that a control may have in force when a program begins, but for what no move asks for.
    said = "G21 G90 G54 G92.1 G49"
    assert read("G21 G0 X1").notes == (
        "line 1: assumed, as no line up to the first move says it: G90, G54, no G92, no length compensation",
    )
    assert (
        read("F9\n(G18) G2 X2 R1 ; G90").notes[-1].endswith("G90, G17, G54, no G92, no length compensation")
    )
    assert read(f"{said} G17\nG61\nF9 G2 X2 R1").notes == () == read(f"{said}\nG0 X1").notes
    assert read(f"{said}\nG0 X1 Y2 Z3", None).notes == (
        "line 2: the first move starts at X0 Y0 Z0, which is assumed: give --start",
    )
    assert read("G21 G0 X1", None).moves[0].start == ORIGIN
    assert read("G0 X1").notes[0] == "line 1: no G20 or G21 before it: millimetres assumed"
    assert "taken to be the one given" in read("G21\nT3 M6\nG0 X1").notes[0]
    assert ends(read("/G0 X3\nG0 X1", skip_optional=True)) == [(1, 0, 0)]
    assert "lines that begin with / are left out" in read("/G0 X3\nG0 X1", skip_optional=True).notes
    assert "lines that begin with / are run" in read("/G0 X3\nG0 X1").notes


def test_nothing_is_asked_of_what_a_refused_word_may_mean(read):
    """Of no line is said what would make it a move, or take it away; what comes after is read."""
    with pytest.raises(InputError) as error:
        read("G21 F9\nG38.2 Z-10\nX5\nG68 X0 Y0 R9\nM98 P1\nM30\nO1\nG0 X9\nM99")
    words = re.findall("word '([^']*)'", str(error.value))
    assert words == ["G38.2", "G68", "M98", "O1"] and "after the end" in str(error.value)
    assert not re.search("add one|remove", str(error.value))


def test_a_long_program_without_loops_ends(read, monkeypatch):
    monkeypatch.setattr(gcode, "_MOST_LINES", 10)
    assert len(read("G21\n" + "X1\nX2\n".replace("X", "G0 X") * 20).moves) == 40
    with pytest.raises(InputError, match="10 lines have run again, so the program does not end"):
        read("G21\nO1 while [1 EQ 1]\nG0 X1\nO1 endwhile\n")


REFUSED = [
    ("G92.3\nG0 X1", 1, "G92.3", "what the control kept before the program"),
    ("G0 X1\nF9 G5.2 X5 P1 L3", 2, "F9", "has X and Y: give both"),
    ("F9 G5.2 X5 Y1 P1 L3", 1, "G5.2", "is not ended"),
    ("F9 G5.2 X5 Y1 P1 L3\nG0 X1", 2, "G0", "only control points"),
    ("F9 G5.2 X5 Y1 P1 L3\nX1 Y1 P1 M2", 2, "M2", "only control points"),
    ("F9 G5.2 P1 L3\nX1 Y1 P1 Q2", 2, "Q2", "belongs to a word that is not"),
    ("F9 G5.2 P1 L3\nX1 Y1 P0", 2, "X1", "without a weight"),
    ("F9 G5.2 P1 L2", 1, "L2", "is 3 or more"),
    ("F9 G5.2 P1 L3\nX10 Y10 P1\nX20 Y0 P1 L4", 3, "L4", "give its order where it begins"),
    # The arc before it is in force again, to LinuxCNC.
    ("F9 G2 X10 I5\nG5.1 X20 I5 J5\nX30 I5 J0", 3, "I5", "belongs to a word that is not"),
    ("F9 G1 X10\nG5.1 X20 I5 J5\nX30", 3, "X30", "no G0 or G1"),
    ("G0 X1 Y2\nF9 G5 X31 Y17 I10 J5 P-7 Q-3.5", 2, "X31", "straight over a step"),
    # The turns are left out: within the tolerance it goes straight to the end.
    ("F9 G64 P.05\nG0 X5\nG3 X5 Y.001 Z-12 I-5 P6", 3, "X5", "leaves the turns out"),
    ("F9 G64 P.05\nG0 X5\nG2 X5 Y-.001 Z-12 I-5 P2", 3, "X5", "leaves the turns out"),
    ("G5.2 P1 L3", 1, "G5.2", "without a feed"),
    ("F9 G5.2 P1 L3\nX1 Y1 P1\nG5.3", 3, "G5.3", "2 points"),
    ("F9 G5.2 P1 L3\nX1 Y1 P1\nX1 Y2 P1\nG5.3 X3", 4, "X3", "on a line with G5.3"),
    ("F9 G19 G5.2 P1 L3\nX1 Y1 P1", 2, "X1", "has Y and Z"),
    ("F9 G5.2 L3\nX0 Y0 P1\nX0 Y0 P1\nG5.3", 1, "G5.2", "stands still"),
    ("F9 G5.2 L3\nX4 Y0 P1\nX9 Y0 P1\nG5.3", 1, "G5.2", "straight over a step"),
    (
        "F9 G5.2 X4 Y0 P1 L3\nX9 Y5 P1\nX12 Y9 P1\nX16 Y9 P1\nX20 Y9 P1\nX24 Y9 P1\nG5.3",
        1,
        "G5.2",
        "straight",
    ),
    (
        "F9 G5.2 L4\nX1 Y9 P1\nX1 Y9 P1\nX1 Y9 P1\nX28 Y21 P1\nX28 Y26 P1\nX33 Y23 P1\nG5.3",
        1,
        "G5.2",
        "still",
    ),
    ("G92 X100\nF9 G92.1 G5.2 X10 Y10 P1", 2, "G92.1", "on a line with G5.2"),
    ("F9 G53 G5.2 X10 Y10 P1", 1, "G53", "on a line with G5.2"),
    ("F9 G5.2 @10 ^45 P3", 1, "@10", "on a line with G5.2"),
    ("F9 G64 P1 G5.2 X1 Y1", 1, "G64", "on a line with G5.2"),
    ("G0 X1\nG5.3", 2, "G5.3", "no NURBS to end"),
    ("G0 X1 R2", 1, "R2", "belongs to a word that is not on the line"),
    ("G28 Z0", 1, "G28", "only the machine knows"),
    ("G0 X1\nF9 G2 X5 I3", 2, "X5", "the radii at both ends of the arc, 3 and 1, differ"),
    ("G0 X1\nF9 G2 X1 R3", 2, "X1", "ends where it starts"),
    ("G0 X1\nF9 G2 X9 R3", 2, "X9", "does not reach"),
    ("G0 X1\nF9 G2 X9", 2, "X9", "give I and J, or R"),
    ("G0 X1\nF9 G81 X9 Z-3", 2, "G81", "without its depth"),
    ("G0 X1\nG55 X2", 2, "G55", "where G55 has its zero, only the machine knows"),
    ("G0 Z9\nF9 G81 X9 Z-3 R2", 2, "G81", "say which, by G99 or G98"),
    ("G0 X1\nG64", 2, "G64", "round corners"),
    ("G0 X#<_hal[x]>", 1, "X#<_hal[x]>", "take another"),
    ("#<_task>=5\nG0 X#<_task>", 1, "#", "#<_task> is the control's own"),
    ("M3 S9 $0", 1, "$0", "not known"),
    ("G0 X#40", 1, "X#40", "has a value that the program does not give it"),
    ("G0 X[1/0]", 1, "X[1/0]", "has no value"),
    ("G0 X[1+2", 1, "X[1+2", "does not end"),
    ("O1 if [1]\nG0 X1", 1, "O if", "has no endif"),
    ("O1 call", 1, "O<1>", "no such subroutine"),
    ("O1 fly", 1, "O1", "not understood"),
    ("G0 X1\nG21 O1 if [1]\nG0 X2\nO1 endif", 2, "O1", "an O word begins its line"),
    ("#1=2 O<t> call", 1, "O<t>", "an O word begins its line"),
    ("M250", 1, "M250", "not known"),
    ("G0 X1e3", 1, "e3", "not on the line"),
    ("G0 X1,5", 1, ",5", "not a letter followed by a decimal number"),
    # No advice that would change the path.
    ("F9 G1 X1,R2", 1, ",R2", "rounded or a bevelled corner"),
    ("#5=1\nIF [#5 EQ 1] GOTO 10", 2, "IF", "macros of a control"),
    ("GOTO 10", 1, "GOTO", "macros of a control"),
    ("G98 F9 G81 X9 Z-3 R2\nG92 X1\nX20", 2, "G92", "give the whole cycle again after it"),
    ("G0 X", 1, "X", "no decimal number: give one"),
    ("G0 X1 X2", 1, "X2", "stands twice"),
    ("G0 G1 X1 F5", 1, "G1", "exclude each other"),
    ("G90 G91 G0 X1", 1, "G91", "exclude each other"),
    ("X1", 1, "X1", "no G0 or G1"),
    ("G0 X1\nG80\nX2", 3, "X2", "no G0 or G1"),
    ("G21\nG1 X1", 2, "G1", "without a feed"),
    ("G1 X1 F-5", 1, "F-5", "must not be negative"),
    ("G0 X1\nT2 M6", 2, "M6", "changes the tool, and so its shape"),
    ("G4 X1", 1, "X1", "may take it for a time"),
    ("G0 X1 N5", 1, "N5", "must be the first word"),
    ("O100 G0 X1", 1, "O100", "is not understood after it"),
    ("G0 (X1", 1, "(X1", "does not end on its line"),
    ("G0 X1) Y2", 1, ") Y2", "')' without '('"),
    ("G0 (a (b) X1", 1, "(a (b) X1", "comment within a comment"),
    ("G0 X1 /Y2", 1, "/Y2", "beginning of a line"),
    ("G0 X1234567890123456789", 1, "X1234567890123456789", "more than 18 digits"),
    ("G0 X0.1234567890123456789", 1, "X0.1234567890123456789"[:20], "more than 18 digits"),
    ("%\nG0 Z1\n%\nG1 Z-50 F9", 4, "G1", "after the end of the program"),
    ("%\nG0 Z1\nM30\n%\n%\nO2\nG0 Z-50\n%", 6, "O2", "after the end of the program"),
    ("G0 X1 M30\nG0 X2\n%", 2, "G0", "after the end of the program"),
    ("G0 Z1\nM2\n/G0 Z-50", 3, "G0", "after the end of the program"),
    ("G0 X\u0661", 1, "G0 X\u0661", "outside of comments"),
    ("F9 G83 X1 Z-1 Q1", 1, "G83", "a cycle without its depth"),
    ("F9 G73 X1 R2 Q1", 1, "G73", "a cycle without its depth"),
    ("G0 Z9\nG1 X5\rY5", 2, "G1 X5", "a carriage return"),
    ("/O1 call", 1, "/O1", "may be left out"),
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


def test_all_that_is_not_understood_is_told_at_once(read):
    with pytest.raises(InputError) as refused:
        read("G21 G0 X1\nG41 D1\nG0 A5 X2\nG41\nM250")
    told = str(refused.value).split("; ")
    assert [re.findall(r"line (\d+): word '(\w+)'", one) for one in told if "line" in one] == [
        [("2", "G41")], [("3", "A5")], [("4", "G41")], [("5", "M250")],
    ]  # fmt: skip


def test_what_ends_the_reading_is_told_with_what_came_before(read):
    for lines, words in (
        ("G0 X1\nG41 D1\nG1 X2 (a\nG68", ["G41", "(a"]),
        ("G0 X1\nT2 M6\nG55\nG41 D1\nX2 X3", ["M6", "G55", "G41", "X3"]),
        ("G0 X1\n" + "G41 D1\n" * 20, ["G41"] * 12),
    ):
        with pytest.raises(InputError) as refused:
            read(lines)
        told = str(refused.value)
        assert re.findall(r"word '(\S+)'", told) == words
        # One path, and no limit that is not told.
        assert told.count("moves.nc") == 1
        assert ("there may be more" in told) == (len(words) == 12)


def test_programs_that_do_not_end_are_refused(read, monkeypatch):
    monkeypatch.setattr("triaxis.host.motion.gcode._MOST_LINES", 1000)
    for body in ("", "X1\n"):
        with pytest.raises(InputError, match=r"line \d: .*so the program does not end"):
            read(f"G0 X1\nO1 while [1]\n{body}O1 endwhile")
    with pytest.raises(InputError, match="calls within calls"):
        read("O1 sub\nO1 call\nO1 endsub\nO1 call")


COMPUTED = [
    ("#1=2\n#<far>=[#1**3]\nG0 X#1 Y[#<far>+1] Z-#1", [(2, 9, -2)]),
    # All values of a line are those from before it.
    ("#1=2\n#1=5 G0 X#1\nX#1", [(2, 0, 0), (5, 0, 0)]),
    ("G0 X[1+2*3**2-[8 MOD 3]] Y[7/2] Z[ABS[-1]]", [(17, 3.5, 1)]),
    ("G0 X[2 GT 1] Y[[1 EQ 1] AND [1 LT 0]] Z[1 OR 0 XOR 1]", [(1, 0, 0)]),
    ("G0 X[10.0modabs[3]] Y[3xorsin[0]]", [(1, 1, 0)]),
    ("G0 X SIN[30] Y[ATAN[1]/[1]] Z[SQRT[2]*SQRT[2]]", [(0.5, 45, 2)]),
    ("G0 X[ROUND[-2.5]] Y[FIX[-1.5]] Z[FUP[1.2]]", [(-3, -2, 2)]),
    ("#<_k>=1 #50=50\nG0 X[EXISTS[#<_k>]] Y[EXISTS[#<b>]] Z[##50+EXISTS[#5602]]", [(1, 0, 50)]),
    ("O1 sub\nG0 X#1 Y#2\nO1 endsub [#1*2]\nO1 call [3] [4]\nG0 Z#<_value>", [(3, 4, 0), (3, 4, 6)]),
    ("O<t> sub\nO2 if [#1 GT 3]\nO<t> return\nO2 endif\nG0 X#1\nO<t> call [#1+1]\nO<t> endsub\nO<T> call [2]",
     [(2, 0, 0), (3, 0, 0)]),
    # Out of a loop, or of two.
    ("O1 sub\nO2 while [1]\nG0 X#1\nO1 return\nO2 endwhile\nO1 endsub\nO1 call [3]\nG0 Y1",
     [(3, 0, 0), (3, 1, 0)]),
    ("#1=0\nO1 while [1]\n#1=[#1+1]\nO2 while [1]\nG0 X#1\nO3 if [#1 EQ 2]\nO1 break\nO3 endif\nO1 continue\n"
     "O2 endwhile\nO1 endwhile\nG0 Y1", [(1, 0, 0), (2, 0, 0), (2, 1, 0)]),
    # By names that are computed.
    ("#1=1 #2=0\nO1 while [#2 LT 3]\n#2=[#2+1]\nG0 X#2\nO3 if [#2 EQ 2]\nO[#1] break\nO3 endif\nO1 endwhile",
     [(1, 0, 0), (2, 0, 0)]), ("#1=1\nO1 sub\nG0 X3\nO1 endsub\nO[#1] call", [(3, 0, 0)]),
    # An argument is computed before the call begins.
    ("O1 sub\nG0 X[#1+1]\nO1 endsub [15]\nO1 call [0]\nO1 call [#<_value>]", [(1, 0, 0), (16, 0, 0)]),
    ("O1 if [0]\nG0 X1\nO1 elseif [1]\nG0 X2\nO1 else\nG0 X3\nO1 endif", [(2, 0, 0)]),
    ("#1=0\nO1 while [#1 LT 5]\n#1=[#1+1]\nO2 if [#1 EQ 2]\nO1 continue\nO2 endif\nO3 if [#1 EQ 4]\n"
     "O1 break\nO3 endif\nG0 X#1\nO1 endwhile", [(1, 0, 0), (3, 0, 0)]),
    ("#1=0\nO1 do\nG0 X#1\n#1=[#1+1]\nO1 while [#1 LT 2]", [(0, 0, 0), (1, 0, 0)]),
    ("G91\nO1 repeat [3]\nG0 X1\nO1 endrepeat", [(1, 0, 0), (2, 0, 0), (3, 0, 0)]),
    ("G0 X5\nG92 X0 Y1\nX1 Y1\nG92.2\nX1\nG92.3\nX1\nG92.1\nX1",
     [(5, 0, 0), (6, 0, 0), (1, 0, 0), (6, 0, 0), (1, 0, 0)]),
    ("G0 X5\nG10 L20 P2 X0 Y0 Z0\nG55 X1\nX[#5420+1]\nG54 X1", [(5, 0, 0), (6, 0, 0), (7, 0, 0), (1, 0, 0)]),
    ("G52 X10\nG0 X1\nG52 X0\nX1", [(11, 0, 0), (1, 0, 0)]),
    ("F9 G81 X1 Z-3 R2\nX2\nG80 G0 X9",
     [(0, 0, 2), (1, 0, 2), (1, 0, 2), (1, 0, -3), (1, 0, 2), (2, 0, 2), (2, 0, 2), (2, 0, -3), (2, 0, 2),
      (9, 0, 2)]),
    ("G0 Z9\nF9 G99 G83 X1 Z-3 R2 Q1", [(0, 0, 9), (1, 0, 9), (1, 0, 2), (1, 0, -3), (1, 0, 2)]),
    ("G0 Z9\nF9 G98 G91 G82 X1 Z-3 R-1 L2 P1",
     [(0, 0, 9), (1, 0, 9), (1, 0, 8), (1, 0, 5), (1, 0, 9), (2, 0, 9), (2, 0, 8), (2, 0, 5), (2, 0, 9)]),
    ("G0 @2 ^90\n^[30+150]\nG91 @1\n^90", [(0, 2, 0), (-2, 0, 0), (-3, 0, 0), (0, -3, 0)]),
    ("G0 X- 1", [(-1, 0, 0)]),
    ("F9 G18 G2 X4 R2", [(4, 0, 0)]),
]  # fmt: skip


@pytest.mark.parametrize(("text", "wanted"), COMPUTED)
def test_parameters_flow_offsets_and_cycles(read, text, wanted):
    found = ends(read(text))
    assert len(found) == len(wanted)
    assert np.allclose(np.array(found, np.float64), wanted, rtol=0, atol=1e-8)


def test_a_subroutine_beside_the_program_is_found(read, tmp_path):
    (tmp_path / "drill.ngc").write_text("o<drill> sub\nG0 X#1\no<drill> endsub\nM2")
    assert ends(read("o<drill> call [7]")) == [(7, 0, 0)]
    # A control that has not come by a subroutine yet takes the file.
    held = "o<drill> sub\nG0 X1\no<drill> endsub"
    assert ends(read(f"{held}\no<drill> call [7]")) == [(1, 0, 0)]
    with pytest.raises(
        InputError, match=r"line 1: word 'O<drill>': is called before it is defined, and drill.ngc"
    ):
        read(f"o<drill> call [7]\nM2\n{held}")


def test_a_subroutine_in_a_called_file_is_not_taken_where_a_file_has_its_name(read, tmp_path):
    helper = "o<helper> sub\nG0 X2\no<helper> endsub\n"
    (tmp_path / "drill.ngc").write_text(f"{helper}o<drill> sub\no<helper> call\no<drill> endsub\nM2")
    assert ends(read("o<drill> call")) == [(2, 0, 0)]
    (tmp_path / "helper.ngc").write_text(helper.replace("X2", "X9"))
    with pytest.raises(InputError, match=r"word 'O<helper>': stands in drill.ngc.* and in helper.ngc"):
        read("o<drill> call")


@pytest.mark.parametrize(
    "text",
    [
        # Where the machine is: a control adds up doubles.
        "G0 Z5\nG91\nO1 while [#<_z> GT 4]\nG1 F9 Z-.1\nO1 endwhile",
        "G92 X.1\nG0 X.3\nG92.1\nO1 if [#5420 LT .2]\nG0 X9\nO1 endif",
        "G0 Z205\nX[FIX[#<_z>]]", "G0 X4\nY[#5420 MOD 2]", "G0 X4\nO1 if [#5420 AND 1]\nO1 endif\nG91 X-4\n"
        "O2 if [#5420]\nO2 endif", "G0 X2.5\nO1 repeat [#5420]\nO1 endrepeat",
        "G0 X4\n#1=-#5420\nO1 if [#1 EQ -4]\nO1 endif", "G0 X1\nY[1/[#5420-1]]",
        # Of libraries.
        "G0 X[FIX[10*SIN[30]]]", "G0 X[FIX[TAN[45]]]", "G0 X[FUP[ASIN[.5]]]", "G0 X[SIN[30] LT .5]",
        "G0 X[COS[90] LT 0]", "G0 X[ATAN[SIN[180]]/[COS[180]]]", "G0 X[ROUND[10**.5*0+EXP[1]-EXP[1]+.5]]",
        "G91\nG1 F9 X.3\nX-.1\nX-.1\nX-.1\nG90\nY[ATAN[0]/[#5420]/180*50]", "G0 X[ATAN[0]/[COS[90]]/10]",
        "G0 X.3\nY[[#5420-.3]*1000000000000000]", "G0 X[TAN[270]/1000000000000000]", "G0 X[2**.5*2**.5 GE 2]",
        "G0 X[[SIN[30]-.5]/.00000000000000001]", "G0 X[2**.5*2**.5 LE 2]",
        "G0 X[2 XOR SIN[180]]", "G0 X[ROUND[3000000000]/1000000000]",
    ],
)  # fmt: skip
def test_nothing_hangs_on_digits_that_controls_do_not_share(read, text):
    with pytest.raises(InputError, match=r"line \d+: word .*(controls|32 bits)"):
        read(text)


@pytest.mark.parametrize(
    ("text", "end"),
    [
        ("G0 Z5\nG91\nO1 while [#<_z> GT 4.05]\nG1 F9 Z-.1\nO1 endwhile", (0, 0, 4)),
        ("G0 X4.2\nX[FIX[#5420]+[2**3 GE 8]+[SIN[0] EQ 0]]", (5 + 1, 0, 0)),
        # The sign of a zero is that of the angle.
        ("#1=0\nG0 X[ATAN[-#1]/[-1]/2]", (-90, 0, 0)), ("#1=0\nG0 X[ATAN[#1]/[-1]/2]", (90, 0, 0)),
        ("#2=0\n#1=-5\nG0 Y[10*SIN[ATAN[-#2]/[#1]/2]]", (0, -10, 0)),
        ("G0 X[ATAN[FUP[-.5]]/[-1]/10]", (-18, 0, 0)), ("#1=0\nG0 X[ATAN[FIX[-#1]]/[-1]/10]", (-18, 0, 0)),
        ("G0 X[ATAN[ROUND[-.2]]/[-1]/10]", (18, 0, 0)), ("G0 X[ATAN[ABS[-0]]/[-1]/10]", (-18, 0, 0)),
        ("G0 X[ATAN[0]/[SIN[-30]]/10]", (18, 0, 0)), ("G0 X4\nX[#5420*1000/25.4]", (4000 / 25.4, 0, 0)),
        # What is set is found before anything of its line is.
        ("#1=2\n#2=8\n#3=8\n#1=3 #[#1]=1\nG0 Z#2", (0, 0, 1)), ("#1=2\n#1=3 ##1=1\nG0 Z#2", (0, 0, 1)),
    ],
)  # fmt: skip
def test_what_is_exact_in_double_precision_is_taken(read, text, end):
    assert np.allclose(np.array(ends(read(text))[-1], np.float64), end, rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("G0 X10 Y0\nG92 X0 Y5\nG92.1 G1 F9 @7", "polar positions"),
        ("G0 X10 Y0\nG92 X0 Y5\nG92.2 G0 ^90", "polar positions"),
        ("#<aa>=5 G0 X[EXISTS[#<aa>]]", "is set on the very line"),
        ("#<aa>=[EXISTS[#<aa>]]", "is set on the very line"),
    ],
)
def test_what_depends_on_the_order_within_a_line_is_refused(read, text, said):
    with pytest.raises(InputError, match=said):
        read(text)


@pytest.mark.parametrize(("cycle", "highest"), [("G83", 0.204), ("G73", 0.204), ("G81", 0), ("G82", 0)])
def test_pecks_go_above_where_they_begin(read, cycle, highest):
    """LinuxCNC's goes up to 0.254 mm above the last one."""
    peck = "Q.05" if cycle in ("G83", "G73") else ""
    found = ends(read(f"F9 G0 Z0\nG99 {cycle} X-5 Z-.2 R0 {peck}\nX5"))
    assert max(float(z) for _, _, z in found) == pytest.approx(highest)


def test_every_letter_has_a_word_that_takes_it(read):
    assert set(TAKERS) <= set("DEHIJKLPQR")


ARC = st.tuples(*[st.decimals(-50, 50, places=3)] * 5)


@given(ARC, st.sampled_from(["G17", "G18", "G19"]), st.booleans(), st.integers(1, 2), st.data())
def test_curves_stay_by_their_chords(tmp_path_factory, numbers, plane, clockwise, turns, data):
    """Points of an arc computed apart, by turning its start, are as near to chords as its bend says."""
    x, y, i, j, rise = numbers
    if i * i + j * j < 1:
        return
    a, b = {"G17": "XY", "G18": "ZX", "G19": "YZ"}[plane]
    c = ({*"XYZ"} - {a, b}).pop()
    centre = {
        a: "I" if a == "X" else "J" if a == "Y" else "K",
        b: "I" if b == "X" else "J" if b == "Y" else "K",
    }
    path = tmp_path_factory.getbasetemp() / "arc.nc"
    path.write_text(
        f"G21 {plane} F1 G1 {a}{x} {b}{y}\n{'G2' if clockwise else 'G3'} {a}{x} {b}{y} {c}{rise} "
        f"{centre[a]}{i} {centre[b]}{j} P{turns}"
    )
    _, move = read_program(path, ORIGIN).moves
    first, last = sorted((data.draw(st.fractions(0, 1)), data.draw(st.fractions(0, 1))))
    assert move.curve
    sag = float(move.curve.bend) * float(last - first) ** 2 / 8 + 2 * float(SLACK)
    ends = [np.array([float(c) for c in move.at(part)]) for part in (first, last)]
    low, high = ([float(c) for c in corner] for corner in move.extent)
    for k in range(9):
        part = float(first + (last - first) * k / 8)
        turn = 2 * math.pi * turns * part * (-1 if clockwise else 1)
        p, q = -float(i), -float(j)
        point = dict.fromkeys("XYZ", 0.0)
        point[a] = float(x) + float(i) + p * math.cos(turn) - q * math.sin(turn)
        point[b] = float(y) + float(j) + p * math.sin(turn) + q * math.cos(turn)
        point[c] = float(rise) * part
        true = np.array([point[axis] for axis in "XYZ"])
        chord = ends[0] + (ends[1] - ends[0]) * k / 8
        assert np.linalg.norm(true - chord) <= sag
        assert (np.array(low) <= true).all() and (true <= np.array(high)).all()


@pytest.mark.parametrize("turns", [1, 3, 32, 100])
def test_many_turns_are_as_long_and_drawn_as_they_are(read, turns):
    (move,) = read(f"F1 G3 X0 Y0 Z9 I5 P{turns}").moves
    length = math.hypot(10 * math.pi * turns, 9)
    assert move.length == pytest.approx(length)
    assert np.linalg.norm(np.diff(move.corners, axis=0), axis=1).sum() == pytest.approx(length, rel=0.01)


def test_arcs_by_radius(read):
    for text, middle in (
        ("F1 G2 X2 R1", (1, 1)), ("F1 G3 X2 R1", (1, -1)),
        ("F1 G2 X2 R-2", (1, 2 + 3**0.5)), ("F1 G2 X2 R2", (1, 2 - 3**0.5)),
        # Too short by no more than a control takes for nothing.
        ("F1 G2 X2 R.999", (1, 1)),
    ):  # fmt: skip
        (move,) = read(text).moves
        assert np.allclose([float(c) for c in move.at(Fraction(1, 2))][:2], middle, atol=1e-6), text
        # The second derivative by differences is no longer than its bound.
        for k in range(1, 16):
            three = [[float(c) for c in move.at(Rational(k + d, 16))] for d in (-1, 0, 1)]
            second = np.linalg.norm(np.diff(three, 2, axis=0)) * 16**2
            assert second <= float(move.curve.bend) + 1e-5


def basis(k, order, at, knots):
    """Return the value of a basis spline by its definition."""
    if order == 1:
        last = at == knots[-1] and knots[k] < knots[k + 1] == at
        return float(knots[k] <= at < knots[k + 1] or last)
    found = 0.0
    for low, high, one, sign in ((k, k + order - 1, k, 1), (k + 1, k + order, k + 1, -1)):
        if knots[high] > knots[low]:
            share = (at - knots[low]) / (knots[high] - knots[low])
            found += (share if sign > 0 else 1 - share) * basis(one, order - 1, at, knots)
    return found


def spline_point(points, weights, order, at):
    n = len(points)
    knots = [0] * order + [*range(1, n - order + 1)] + [n - order + 1] * order
    shares = np.array([basis(k, order, at, knots) for k in range(n)]) * weights
    return shares @ points / shares.sum()


def two_arcs(start, leaving, end, arriving, count=40):
    """Return points (N, 2) of two arcs with the same length of tangents, each turned about its centre."""
    chord = end - start
    a, b, c = 2 * (leaving @ arriving - 1), -2 * chord @ (leaving + arriving), chord @ chord
    tangent = max(np.roots([a, b, c]).real) if abs(a) > 1e-9 else -c / b
    middle = (start + tangent * leaving + end - tangent * arriving) / 2
    found = []
    for one, way, other in ((start, leaving, middle), (end, -arriving, middle)):
        left = np.array([-way[1], way[0]])
        across = (other - one) @ left
        for k in range(count + 1):
            if abs(across) < 1e-9 * np.linalg.norm(other - one):
                found.append(one + (other - one) * k / count)
                continue
            radius = (other - one) @ (other - one) / (2 * across)
            full = 2 * math.atan2(across, (other - one) @ way)
            turn = full * k / count
            found.append(one + radius * (math.sin(turn) * way + (1 - math.cos(turn)) * left))
    return np.array(found)


@pytest.mark.long
@pytest.mark.parametrize("plane", ["G17", "G18", "G19"])
def test_nurbs_and_the_arcs_of_controls_are_by_the_moves(read, plane):
    """By the definition of basis splines, and arcs computed apart: all is as near as the moves say."""
    rng, axes = np.random.default_rng([17, int(plane[1:])]), {"G17": "XY", "G18": "ZX", "G19": "YZ"}[plane]
    places = ["XYZ".index(axis) for axis in axes]
    compared = 0
    for _ in range(6):
        order = int(rng.integers(3, 6))
        count = int(rng.integers(order, 9))
        points = np.concatenate([[[0, 0]], np.cumsum(rng.integers(-20, 60, (count - 1, 2)), 0)]).astype(float)
        weights = rng.integers(1, 9, count) / 2
        lines = [
            f"{axes[0]}{x:g} {axes[1]}{y:g} P{w:g}" for (x, y), w in zip(points[1:], weights[1:], strict=True)
        ]
        text = f"G21 G61 {plane} F1\nG5.2 P{weights[0]:g} L{order}\n" + "\n".join(lines) + "\nG5.3\nG0 X0"
        try:
            moves = read(text).moves[:-1]
        except InputError as error:
            assert "write it as plain moves" in str(error)
            continue
        compared += 1
        assert len(moves) == 4 * count and {move.line for move in moves} == {2}
        last = count - order + 1
        for k, move in enumerate(moves):
            low, high = last * k / len(moves), last * (k + 1) / len(moves)
            true = [spline_point(points, weights, order, low + (high - low) * j / 8) for j in range(9)]
            here = [[float(c) for c in move.at(Fraction(j, 8))] for j in range(9)]
            assert np.allclose(np.array(here)[:, places], true, atol=1e-6)
            assert (
                np.linalg.norm(np.diff(true, 2, axis=0), axis=1).max() * 64 <= float(move.curve.bend) + 1e-5
            )
            ways = [
                spline_point(points, weights, order, min(at + 1e-5, last))
                - spline_point(points, weights, order, max(at - 1e-5, 0.0))
                for at in (low, high)
            ]
            arcs = two_arcs(
                true[0], ways[0] / np.linalg.norm(ways[0]), true[-1], ways[1] / np.linalg.norm(ways[1])
            )
            fine = np.array([[float(c) for c in move.at(Fraction(j, 200))] for j in range(201)])[:, places]
            # Of chords so short that the curve is within 1e-5 of them.
            one, way = fine[:-1], np.diff(fine, axis=0)
            share = ((arcs[:, None] - one) * way).sum(2) / (way**2).sum(1)
            nearest = one + np.clip(share, 0, 1)[..., None] * way
            off = np.linalg.norm(arcs[:, None] - nearest, axis=2).min(1).max()
            assert off <= float(move.slack) + float(move.curve.bend) / 8 / 200**2, (k, off)
    assert compared > 2


def test_a_nurbs_of_many_points_takes_no_more_than_they_do(read):
    """Each part keeps the points that it depends on, and no others."""
    lines = "\n".join(f"X{k} Y{k * k % 7} P1" for k in range(1, 120))
    moves = read(f"G21 G61 F1\nG5.2 L4\n{lines}\nG5.3").moves
    assert len(moves) == 480 and max(len(move.curve.points) for move in moves if move.curve) <= 5


def test_nurbs_of_a_circle_and_what_is_added(read):
    """A quarter of a circle about 0, of weights 1, sqrt(1/2), 1 as decimals: the arcs are all but it."""
    program = read("G21 G61 F1 G1 X10\nG5.2 L3\nX10 Y10 P0.70710678\nX0 Y10 P1\nG5.3\nG1 X0 Y0")
    quarter = program.moves[1:-1]
    for move in quarter:
        for j in range(5):
            x, y, _ = (float(c) for c in move.at(Fraction(j, 4)))
            assert abs(math.hypot(x, y) - 10) < 1e-6
        assert move.slack < Fraction(1, 100)
    assert sum(move.length for move in quarter) == pytest.approx(5 * math.pi, abs=1e-3)
    (note,) = (note for note in program.notes if "follow splines" in note)
    assert note.startswith("line 2: 0.00")


MACHINE = """
path_tolerance = 0.5
loaded = 2
[offsets]
G54 = [10, 20, 30]
G55 = [11, 20, 30.5]
[homes]
G28 = [0, 0, 0]
[[tools]]
number = 1
length = 50
parts = [{ diameter = 6, length = 20 }, { diameter = 20, length = 40 }]
[[tools]]
number = 2
length = 30.5
parts = [{ diameter = 10, length = 30.5 }]
"""


def test_a_machine_file_says_what_a_program_does_not(read, tmp_path):
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE)
    machine = read_machine(file)
    # The spindle stands at 0, so the tip of tool 2 is 30.5 below.
    program = read(
        "G21 G90 G43 H2 G0 Z5\nG55 X0\nG53 G0 Z-1\nG28 X3\n"
        "T1 M6\nG43 G54 G0 X0 Z1\nG49 Z60\nG64 P0.1\nZ61\nG61\nZ62",
        machine=machine,
    )
    assert ends(program) == [
        (0, 0, 5), (1, 0, 5), (1, 0, -61.5), (4, 0, -61.5), (-10, 0, -61.5), (0, 0, 1), (0, 0, 10),
        (0, 0, 11), (0, 0, 12),
    ]  # fmt: skip
    assert program.moves[0].start == (0, 0, Fraction(-61, 2))
    assert [part.moves[0].tool for part in program.stretches] == [2, 1]
    assert [float(move.slack) for move in program.moves[-4:]] == [0.5, 0.5, 0.5, 0.225]
    facets = machine.tools[1].mesh.facets
    assert facets[..., 2].min() == 0 and facets[..., 2].max() == 60
    # The prism holds the cylinder: the middles of its sides are no nearer than the radius.
    sides = [side for side in facets if np.ptp(side[:, 2]) > 0 and side[:, 2].max() <= 20]
    edges = [(side[i, :2] + side[j, :2]) / 2 for side in sides for i, j in ((0, 1), (1, 2), (2, 0))]
    assert len(sides) == 128 and np.linalg.norm(edges, axis=1).min() >= 3
    for text, why in (
        ("tools = 3", "'tools': must be a list"), (f"x = 1\n{MACHINE}", "'x': not known"),
        ("rapids = 'no'", "'rapids': must be"), ("[[tools]]\nnumber = 1", "'mesh': must be given"),
        ("= 3", "no TOML"), ("", "'tools': must be given"),
        ("path_tolerance = nan", "no TOML: nan: a decimal"),
        ("[[tools]]\nnumber = 1\nparts = [{diameter = 3}]", "must be positive"),
        ("x = " + "[" * 900, "no TOML: tables or lists in"), ("[[tools]]\nnumber = true", "a whole number"),
        (f"x = 1\na{'.a' * 500} = 1", "line 2: more than 1000 characters"),
        ("[offsets]\nG54 = [true, 0, 0]", "three numbers"), ("loaded = 1e9", "no TOML: 1e9"),
        ("[[tools]]\nnumber = 1\nlength = -1", "must be not negative"),
        ("path_tolerance = 9999999", "at most"),
        ("[offsets]\nG59.3 = [1, 2, 3]", "keys in quotes where these have a point"),
        ("path_tolerance = -0.1", "must be not negative"), ("tools = [3]", "tool 1: a table is needed"),
        (MACHINE.replace("number = 2", "number = 1"), "tool number 1 stands twice: keep one"),
        (MACHINE.replace("loaded = 2", "loaded = 3"), r"'loaded': must be the number of a tool \(1, 2\)"),
        ("[[tools]]\nnumber = -1", "'number': must be given, and 1 or more"),
        ('[[tools]]\nnumber = 1\nmesh = "a\\u0000.stl"', "'mesh': must be the name of a file"),
    ):  # fmt: skip
        file.write_text(text)
        with pytest.raises(InputError, match=why):
            read_machine(file)
    with pytest.raises(InputError, match="no tool 7"):
        read("T7 M6\nG0 X1", machine=machine)
    with pytest.raises(InputError, match="'G30': goes where only the machine knows: give homes"):
        read("G30 X0", machine=machine)
    unknown = replace(machine, tools={2: replace(machine.tools[2], length=None)})
    with pytest.raises(InputError, match="'G53': with a tool of unknown length"):
        read("G43 H2\nG53 G0 Z5", machine=unknown)
    with pytest.raises(InputError, match="no tool is in the spindle"):
        read("T0 M6\nG0 X1", machine=machine)
    assert [move.tool for move in read("T0 M6\nT1 M6\nG0 X1", machine=machine).moves] == [1]
    # It falls short of 1 by 4e-16.
    assert [move.tool for move in read("T[4.1-3.1] M6\nG0 X1", machine=machine).moves] == [1]
    file.write_text(MACHINE + "[[tools]]\nnumber = 0\nlength = 0\nparts = [{ diameter = 60, length = 9 }]\n")
    with_empty = read_machine(file)
    assert [move.tool for move in read("T0 M6\nG43 H0\nG0 X1", machine=with_empty).moves] == [0]
    # Of two meanings that controls give it, one has the tool too low.
    with pytest.raises(InputError, match="'H0': the tool in the spindle to some controls"):
        read("G43 H0\nG0 X1", machine=with_empty)
    # What the control has selected before nobody tells.
    with pytest.raises(InputError, match="'M6': changes to the tool that the control has selected"):
        read("M6\nG0 X1", machine=with_empty)
    with pytest.raises(InputError, match=r"may be the control's|does not give it"):
        read("G0 X#<_selected_tool>", machine=with_empty)
    assert [move.tool for move in read("T1 M6\nM6\nG0 X1", machine=with_empty).moves] == [1]
    with pytest.raises(InputError, match="changes the tool, and so its shape"):
        read("G0 X1\nM6\nG0 X2")
    for text, changes in (("T2 M6", True), ("T2 M6\nT1 M6", True), ("T1 M6", True), ("", False)):
        found = read(f"T1 M6\nG0 X1\n{text}", machine=machine)
        assert found.changes == changes == any("after the last move" in note for note in found.notes)
        # Whatever tool is there then.
        assert len(read(f"T1 M6\nG0 X1\n{text}\nX2", machine=machine).stretches) == 1 + changes
    for text, tells in (("M0", False), ("M60", True)):
        notes = read(f"G0 X1\n{text}\nG0 X2", machine=machine).notes
        assert any("change of the pallet" in note for note in notes) == tells


EVERY_WORD = Path(__file__).with_name("data") / "every_word.nc"
BEGUN_AT = Fraction(3), Fraction(-2), Fraction(7)


def machine_of_both(tmp_path):
    file, others = tmp_path / "machine.toml", ["G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"]
    more = "".join(f'"{system}" = [9, 8, 7]\n' for system in others) + "[homes]\nG30 = [0, 0, 5]"
    file.write_text(MACHINE.replace("path_tolerance = 0.5\n", "").replace("[homes]", more))
    return read_machine(file)


def test_every_word_does_what_it_should(read, tmp_path):
    lines = EVERY_WORD.read_text().splitlines()
    words = {word for line in lines for word in re.findall(r"[GM]\d+(?:\.\d)?", re.sub(r"\(.*?\)", "", line))}
    assert words == set(GROUPS) - {"M30"}
    wanted = {
        number: tuple(map(float, told[1].split()))
        for number, line in enumerate(lines, 1)
        if (told := re.search(r"\(to (.*)\)", line))
    }
    moves = read_program(EVERY_WORD, BEGUN_AT, False, machine_of_both(tmp_path)).moves
    assert {move.line: tuple(map(float, move.end)) for move in moves} == wanted
    # The same but for the last word.
    assert len(read("G21 G0 X1\nM30").moves) == 1


BOTH = (
    "G20 G90 F10\n#1=[2/3]\nG0 X1 Y#1 Z.5\nG3 X2 I.5 J0\nG18 G2 X2.5 Z.75 R1\nG17\nG91 G1 X-.25\nG90\n"
    "O1 repeat [2]\nG2 X[#5420+.1] I.05\nO1 endrepeat\nG92 X0\nX.1 Y1 R3\n"
    "G92.1\nG10 L20 P2 X0 Y0 Z0\nG55 G1 X.1\n"
    "(PRINT, 1)\n/ T0 M6\n;debug, #5420\nN7.5 T1 M6 S9 G43 (z stays)\nX.2\nZ1\nG64 P.001\n"
    "/G1 X.5\nG98 G83 X.2 Y.1 Z.3 R.6 Q.1\nG80\nG54 G53 G0 X0\nG28 Z2\nM2\n",
    "G21\nG0 X0\nF100 G17 G2 X10 I5 P2 Z3\nG0 X0 Y5\nG1 X1\n",
    # It does not print splines, and knows no tool but by M6.
    re.sub(r"(?s)G17 G5 X.*?G5\.3", "G17", EVERY_WORD.read_text()).replace("M61 Q2", "T2 M6"),
)


@pytest.mark.parametrize("reader", [read_program, read_by_rs274])
def test_progress_is_told_while_a_program_is_read(reader, tmp_path):
    if reader is read_by_rs274 and shutil.which("rs274") is None:
        pytest.skip("rs274 (linuxcnc-uspace) is not installed")
    file, done = tmp_path / "long.nc", list[int]()
    file.write_text("G21 G90 F100 G0 X0\n" + "".join(f"G1 X{n}\n" for n in range(1, 3500)))
    assert len(reader(file, BEGUN_AT, False, Machine(), done.append).moves) == 3500
    assert len(done) == 3 and 3000 <= sum(done) <= 3500


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
@pytest.mark.parametrize("text", BOTH)
def test_linuxcnc_reads_the_same(tmp_path, text):
    """Two readers, of which one is the control's own: the same moves, but for what one of them prints."""
    program, machine = tmp_path / "both.ngc", machine_of_both(tmp_path)
    program.write_text(text)
    theirs = read_by_rs274(program, BEGUN_AT, True, machine).moves
    ours = read_program(program, BEGUN_AT, True, machine).moves
    places = {0: [*theirs], 1: [*ours]}
    # Pecking up and down is one plunge here.
    heights = [{round(float(move.end[2]), 3) for move in moves} for moves in places.values()]
    assert heights[0] >= heights[1]
    pecks = {move.line for move in ours if sum(other.line == move.line for other in ours) > 2}
    theirs, ours = ([move for move in moves if move.line not in pecks] for moves in (theirs, ours))
    assert [(move.line, move.rapid, move.tool) for move in theirs] == [
        (move.line, move.rapid, move.tool) for move in ours
    ]
    for a, b in zip(theirs, ours, strict=True):
        for part in (Fraction(0), Fraction(1, 3), Fraction(1)):
            apart = max(abs(x - y) for x, y in zip(a.at(part), b.at(part), strict=True))
            assert apart <= a.slack, (a.line, float(apart))


def some_program(rng):
    """Return a program of cycles, polar steps, arcs and offsets by random."""

    def number(low=-3, high=5):
        return f"{rng.uniform(low, high):.3f}" if rng.random() < 0.5 else f"{rng.integers(low, high + 1)}"

    def words(letters, part):
        return "".join(f" {letter}{number()}" for letter in letters if rng.random() < part)

    def polar():
        return rng.choice([f"@{number(1, 6)}", f"^{number(-90, 200)}", f"@{number(1, 6)} ^{number(0, 99)}"])

    def series():
        code = rng.choice(["G81", "G81", "G82 P0.5", "G85", "G84" if plane == "G17" else "G89 P0"])
        yield f"{code}{words('XYZ', 1)} R{number(5, 9)}"
        for _ in range(rng.integers(1, 6)):
            again = rng.choice(["", "", " L2", " L3"])
            height = f" R{number(5, 9)}" if rng.random() < 0.4 else ""
            step = polar() if rng.random() < 0.3 and plane == "G17" else words("XYZ", 0.5) or " X2"
            yield rng.choice(["", "", "", "G98", "G99", "G90", "G91"]) + f" {step}{height}{again}"
        yield f"G80 {rng.choice(['G90', 'G91'])}"

    plane, lines = rng.choice(["G17", "G17", "G17", "G18", "G19"]), list[str]()
    for _ in range(rng.integers(2, 7)):
        kind = rng.random()
        if kind < 0.5:
            lines += series()
        elif kind < 0.6:
            lines.append(
                f"{rng.choice(['G0', 'G1'])}{words('XYZ', 0.6) or ' Z9'} {rng.choice(['G20', 'G21'])}"
            )
        elif kind < 0.7 and plane == "G17":
            lines.append(f"{rng.choice(['G0', 'G1'])} {polar()}")
        elif kind < 0.8:
            ends = words({"G17": "XY", "G18": "XZ", "G19": "YZ"}[plane], 1)
            lines.append(f"{rng.choice(['G2', 'G3'])}{ends} R{rng.choice(['', '-'])}{rng.integers(60, 90)}")
        elif kind < 0.92:
            lines.append(rng.choice(["G92", "G52", "G10 L20 P1", "G28", "G90 G0 G53"]) + words("XYZ", 1))
        else:
            lines.append(rng.choice(["M62 P1", "M67 E1 Q2", "M64 P0", "G4 P1", "M8", "S300"]))
    begin = f"G21 G90 {plane} G61 F500 S100 M3 {rng.choice(['G98', 'G99'])}\nG0 X1 Y1 Z4"
    return "\n".join([begin, *lines, "M2", ""])


def some_changes(rng):
    """Return a program that changes tools, lengths and systems by random."""
    lines, tool = ["G21 G90 G61 F100", "G0 X0 Y0 Z5"], 1
    for _ in range(rng.integers(4, 14)):
        x, z, kind = rng.integers(-9, 9), rng.integers(-5, 30), rng.random()
        if kind < 0.25:
            tool = rng.integers(1, 3)
            lines.append(f"T{tool} M6")
        elif kind < 0.5:
            lines.append(rng.choice([f"G43 H{tool}", f"G43 H{tool} Z{z}", "G43", "G49"]))
        elif kind < 0.65:
            lines.append(rng.choice(["G28 G91 Z0\nG90", "G53 G0 Z0", "G92 X1 Z3", "G92.1", "G10 L20 P1 Z5"]))
        else:
            lines.append(rng.choice(["G0", "G1"]) + rng.choice([f" X{x}", f" Z{z}", f" X{x} Z{z}"]))
    return "\n".join([*lines, "G0 X77", "M2", ""])


def corners(moves):
    """Return places on the way, (N, 3), of straight ones where the way turns."""
    found = [np.array([float(c) for c in moves[0].start])]
    for move in moves:
        for part in (Fraction(k, 4) for k in ((1, 2, 3, 4) if move.curve else (4,))):
            place = np.array([float(c) for c in move.at(part)])
            if len(found) > 1 and not move.curve:
                before, on = found[-1] - found[-2], place - found[-1]
                off = np.linalg.norm(np.cross(before, on)) / max(1e-9, np.linalg.norm(before + on))
                if before @ on > 0 and off < 0.005:
                    found.pop()
            if np.abs(place - found[-1]).max() > 0.005:
                found.append(place)
    return np.array(found)


@pytest.mark.long
@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
@pytest.mark.parametrize("made_up", [some_program, some_changes])
def test_linuxcnc_goes_the_same_way_through_programs_made_up(tmp_path, rng, made_up):
    program, file = tmp_path / "p.ngc", tmp_path / "machine.toml"
    file.write_text(MACHINE.replace("path_tolerance = 0.5\n", ""))
    machine, start, same = read_machine(file), (Fraction(1), Fraction(1), Fraction(60)), 0
    for _ in range(150):
        text = made_up(rng)
        program.write_text(text)
        try:
            ours, theirs = (
                corners(read(program, start, False, machine).moves) for read in (read_program, read_by_rs274)
            )
        except InputError:
            continue
        assert len(ours) == len(theirs) and np.abs(ours - theirs).max() < 0.02, text
        same += 1
    assert same > 40


@pytest.mark.parametrize(
    ("text", "is_read", "theirs"),
    [
        # Whole turns, a little less, a little more, of a radius below the tolerance; and not joined at all.
        ("G64 P.05\nG0 X5\nG3 X5 Z-12 I-5 P6", True, False),
        ("G64 P.05\nG0 X5\nG3 X5 Y-.001 Z-12 I-5 P6", True, True),
        ("G64 P.05\nG0 X5\nG3 X5 Y.001 Z-12 I-5 P6", False, False),
        ("G64 P.002 Q.05\nG0 X5\nG3 X5 Y.001 Z-12 I-5 P6", False, False),
        ("G64 P.05\nG0 X.02\nG3 Z-12 I-.02 P6", False, False),
        ("G64 P.05\nG0 X5\nG61 G3 X5 Y.001 Z-12 I-5 P6", True, True),
        ("G64 P.05\nG0 X5\nG3 X5 Y.001 Z-12 I-5", True, True),
    ],
)
def test_turns_that_a_tolerance_leaves_out_are_refused(tmp_path, text, is_read, theirs):
    """Of places as LinuxCNC prints them nobody knows whether turns are whole."""
    program = tmp_path / "p.ngc"
    program.write_text(f"G21 G17 F9 {text}\n")
    for reader, wanted in ((read_program, is_read), (read_by_rs274, theirs)):
        if reader is read_by_rs274 and shutil.which("rs274") is None:
            continue
        if wanted:
            move = reader(program, ORIGIN, False, Machine()).moves[-1]
            assert move.curve and move.curve.turns == (6 if "P6" in text else 1)
        else:
            with pytest.raises(InputError, match="leaves the turns out"):
                reader(program, ORIGIN, False, Machine())


def test_a_tiny_arc_holds_the_whole_circle_that_a_control_makes_of_it(read):
    """LinuxCNC with inches, where r^2 times the angle is below 10^-8 of them squared."""
    (tiny,) = read("F1 G3 X-0.00000006 Y0.00006 I-0.03").moves
    (small,) = read("F1 G3 X-0.00006 Y0.06 I-30").moves
    assert tiny.curve.sweep > 2 * math.pi > 1 > small.curve.sweep > 0


@pytest.mark.parametrize("unit", ["G20", "G21"])
@pytest.mark.parametrize(
    ("line", "points"),
    [
        ("G5.1 X40 Y0 I20 J400", [(0, 0), (20, 400), (40, 0)]),
        ("G5 X30 Y10 I10 J20 P-5 Q15", [(0, 0), (10, 20), (25, 25), (30, 10)]),
    ],
)
def test_a_spline_is_the_nurbs_of_its_points(read, line, points, unit):
    """So LinuxCNC takes it: by two arcs a step, up to 0.33 mm off the first of these."""
    program = read(f"{unit} G61 F1\n{line}")
    first, *others = (" ".join(f"{axis}{x}" for axis, x in zip("XY", p, strict=True)) for p in points[1:])
    lines = "\n".join(f"{other} P1" for other in others)
    assert list(program.moves) == [
        replace(move, line=2)
        for move in read(f"{unit} G61 F1\nG5.2 L{len(points)} {first} P1\n{lines}\nG5.3").moves
    ]
    weights, order = [1.0] * len(points), len(points)
    scale = 25.4 if unit == "G20" else 1.0
    for k, move in enumerate(program.moves):
        at = (k + 0.5) / len(program.moves)
        t, held = at, np.array(points, float) * scale
        binomial = [math.comb(order - 1, j) for j in range(order)]
        bezier = sum(
            binomial[j] * t**j * (1 - t) ** (order - 1 - j) * held[j] * weights[j] for j in range(order)
        )
        assert np.allclose([float(c) for c in move.at(Fraction(1, 2))][:2], bezier, atol=1e-6)
    assert max(move.slack for move in program.moves) > (Fraction(1, 3) if order == 3 else Fraction(1, 1000))


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
def test_splines_are_read_without_linuxcnc(tmp_path):
    program = tmp_path / "p.ngc"
    program.write_text("G21 G61 F9\nG0 X1\nG5 X4 I1 J1 P-1 Q1\nG1 X9\n")
    ours, theirs = (read(program, ORIGIN, False, Machine()) for read in (read_program, read_by_rs274))
    assert ours.moves == theirs.moves and ours.moves[1].curve
    assert theirs.notes[-1].startswith("line 3: a spline, which it does not print")


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
def test_linuxcnc_leaves_no_tools_with_its_user(tmp_path, monkeypatch):
    """Another program that is read meanwhile, or a control that runs, would take them for its own."""
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    program, file = tmp_path / "p.ngc", tmp_path / "machine.toml"
    file.write_text(MACHINE)
    program.write_text("G21\nG43 H2 G0 Z9\n")
    assert read_by_rs274(program, ORIGIN, False, read_machine(file)).moves
    assert not list((tmp_path / "home").iterdir())


NOT_KNOWN_THERE = [
    # L before G10; words that are rounded to these; the end of a branch that is not run.
    ("L2 G10 P1 X5\nG0 X1", "", "word 'g10': needs machine coordinates"),
    ("L11 G10 P1 Z5\nG0 X1", MACHINE, "by the zero of G59.3"), ("G53.00001 G0 Z5", "", "rounded to another"),
    ("G27.99999\nG0 X1", "", "rounded to another"), ("G10 L1.99999 P1 X5\nG0 X1", "", "rounded to another"),
    ("G91 G0 X1\n/M2\nO5\nG0 X2\nM99", "", "begins the program anew"),
    ("O1 if [0]\nM2\nO1 endif\nG0 X1\nO5\nM99", "", "begins the program anew"),
    ("#<m2>=1\nG0 X1\nO5\nM99", "", "begins the program anew"),
    # What is not reached; a word that goes on after a comment, of which each part would be another.
    ("G0 X1\nM2\nG0 X2", "", "line 4: word 'g0x2': stands after the end"),
    ("O1 sub\nO1 if [1]\nO1 endif\nM2\nO1 endsub\nG0 X1\n/M2\nG0 X2\nM30\n(..)\n/G0 X3", "",
     "line 12: word 'g0x3': stands after"),
    ("#40=1\n#(c)40=5\nG0 X#40", "", "a comment within a word"),
    ("G5(c)3 G0 X1", "", "not a letter followed"),
    ("G(c)53 G0 X1", MACHINE, "a comment within a word"), ("G0 X1\n//G0 X5", "", "'/g0x5': block delete"),
    ("O1 if [0]\n#<_metric_machine>=1\nO1 endif\nG0 X#<_metric_machine>", "", "'#<_metric_machine>'"),
    # Files that it looks for by number.
    ("M98 P77\nG0 X1\nM2\nO77\nG0 X5\nM99", "", "word 'M98': may call 77.ngc"),
    ("M98 P#31\nG0 X1\nM2", "", "may call 77.ngc"),
    ("M98 P078\nG0 X1\nM2\nO78\nM99\nG92.3", "", "kept before"),
    ("o077 call\nG0 X1\nM2\no77 sub\nG0 X5\no77 endsub", "", "77.ngc has one of its name"),
    ("o<77> call\nG0 X1\nM2\no 0 77 sub\nG0 X5\no77 endsub", "", "77.ngc has one of its name"),
    # What it refuses, and would not as it is given it; names that it would be given others for.
    ("12 G0 X5", "", "not a letter followed"), ("G0 X1\nN5 %\nX9", "", "'%' stands alone"),
    ("#<exists[#1]>=4\nG0 X1", "", "take another"), ("#<call>=1\nG0 X#<_value>", "", "word '#<_value>'"),
    ("G0 X1\nG55 X2", "", "where G55 has its zero"), ("G53 G0 X1", "", "needs machine coordinates"),
    ("G28", "", "needs machine coordinates"), ("G10 L2 P1 X1", "", "needs machine coordinates"),
    ("G30", MACHINE, "give G30 in a machine file"), ("G43 H1\nG0 Z1", "", "needs the length of each tool"),
    ("F9 G41 D1 G1 X1", "", "needs the diameter"), ("G0 X#5221", MACHINE, "does not give it"),
    ("G43 H2 G0 X9\nT1 M6", MACHINE, "mistakes where the tool is"),
    ("G43 H2 G0 Z9\nG20", MACHINE, "a change of units"),
    ("T[1] M6 G43 H1\nG0 Z9", MACHINE, "on a line with a change of the tool"), ("X1", "", "rs274 refuses it"),
    ("%\nG0 X1\n%\nG0 X2", "", "after the end"), ("F9 G38.2 Z-1", "", "ends where the part is"),
    ("G0 A1", "", "none of the machine's"), ("M61 Q2", MACHINE, "change tools with M6"),
    ("T0 M6\nG0 X1", MACHINE, "no tool is in the spindle"),
    ("M6\nG0 X1", MACHINE, "that the control has selected"),
    ("T0 M6\nG43\nG0 X1", MACHINE, "compensation of an empty spindle"),
    ("T0 M6 G43 H0\nG0 X1", MACHINE, "compensation of an empty spindle"),
    ("o<changing> call\nG0 X1", MACHINE, "in a file of its own"),
    ("G10 L2.0 P1 X1", "", "needs machine coordinates"), ("G5 3 G0 X-9", "", "needs machine coordinates"),
    ("#1=5221\nG0 X##1", "", "may be any parameter"), ("G0 X#100", "", "does not give it"),
    ("O1 if [#<_task> EQ 1]\nO1 endif", "", "does not give it"),
    ("o<below> call", "", "needs machine coordinates"),
    ("G0 X1\nG64", "", "round corners"), ("G92.3\nG0 X1\nG92 X2", "", "what the control kept before"),
    # Set later, under a condition, in a subroutine that has arguments of its own, by an earlier program.
    ("G0 X#100\n#100=2", "", "line 2: word '#100': has a value"),
    ("O1 if [#<_absolute> EQ 0]\n#100=2\nO1 endif\nG0 X[#100]", "", "line 5: word '#100': has a value"),
    ("O1 if [#100 EQ 1]\nG0 X1\nO1 endif\n#100=1", "", "line 2: word '#100': has a value"),
    ("G0 X# 5", "", "line 2: word '#5': has a value"), ("G0 X1\n#<_p5>=1 #<a>=1\nX#5", "", "word '#5'"),
    ("o<own> call [3]\nG0 X#1", "", "word '#1'"),
    # To itself, on the line that sets it.
    ("G0 X1\n# 40=[#40+1]\nX#40", "", "line 3: word '#40'"),
    ("#<_ours>=1 G0 X#<_ours>", "", "line 2: word '#<_ours>'"),
    ("/#40=2\n#41=#40 #40=3\n#40=4 #42=#42\nG0 X1", "", "line 4: word '#42'"),
    ("O1 if [EXISTS[#<_ours>]]\nG0 X1\nO1 endif\n#<_ours>=1", "", "word '#<_ours>'"),
    ("O1 if [EX ISTS[# <_ours>]]\nG0 X1\nO1 endif\n#<_ours>=1", "", "word '#<_ours>'"),
    # Numbers that are not digits alone, subroutines computed, or left out, names that look like these.
    ("G0 X#+100\n#100=2", "", "may be any parameter"), ("G0 X#abs[100]", "", "may be any parameter"),
    ("G0 X#-[-100]", "", "may be any parameter"), ("#5=9\nG0 X#5.0", "", "may be any parameter"),
    ("o[100] sub\nG0 X#1\no[100] endsub\nG0 X1", "", "name is computed"),
    ("o1.0 sub\nG0 X#1\no1.0 endsub\no1 call [3]", "", "word 'o1.0sub': says nothing"),
    ("/o1 sub\nG0 X#1\n/o1 endsub\nG0 X2", "", "may be left out"), ("#<o1sub>=3\nG0 X#5", "", "word '#5'"),
    ("O1 if [0]\nG92 X0 Y0 Z0\nO1 endif\nG92.3\nG0 X1", "", "what the control kept before"),
    ("#<g92>=1\nG92.3\nG0 X1", "", "what the control kept before"),
    ("G[92.3]\nG0 X1", MACHINE, "kept before"),
    ("O1 if [0]\n#<_task>=1\nO1 endif\nG0 X#<_task>", "", "word '#<_task>'"),
    ("G0 X#<_value>", "", "word '#<_value>'"),
    ("G0 X#<_ours>\n#<_ours>=1", "", "line 2: word '#<_ours>'"), ("#5221=1\nG0 X#5221", MACHINE, "'#5221'"),
    # Numbers with signs, or of functions; what only the control has; a main program that begins anew.
    ("G+53 G0 X1", "", "word 'g+53'"), ("Gabs[53] G0 X1", "", "'gabs[53]'"),
    ("M+61 Q1\nG0 X1", MACHINE, "'m+61'"), ("G10 L+2 P1 X5\nG0 X1", "", "'l+2'"),
    ("M[61] Q1\nG0 X1", MACHINE, "word 'm[61]'"),
    ("#5222=1\nG0 X1", MACHINE, "'#5222': sets what is the control's"),
    ("G10 L11 P1 Z20\nG0 X1", MACHINE, "by the zero of G59.3"),
    ("G0 X1\nG91 X1\nM99", "", "line 4: word 'm99': begins the program anew"),
    ("O5\nG0 X1\nM99\nO6\nG0 X2\nM99", "", "begins the program anew"),
    ("G0 Z9\nG1 F9 X5\rY5", "", "line 3: word 'G1 F9 X5': the line has a carriage return"),
    ("o<own> call [1]\nM2\no<own> sub\nG0 X2\no<own> endsub", "", "word 'O<own>': is called before it is"),
    ("o<a> sub\nM98 P9\no<a> endsub\no<a> call [1]\nM2\nO9\nG0 X#1\nM99", "", "use #31 or more"),
    ("G0 X1\nT0 M6\nG0 X2", "", "changes the tool, and so its shape"), ("G90", "", "no moves"),
    ("G43.1 A5\nG0 X1", MACHINE, "of more than X, Y and Z"), ("G0 X" + "[" * 240, "", "nested too deeply"),
    ("O1 do\nG0 X1\nO1 while [0]\nM2\nG0 X9", "", "line 6: word 'g0x9': stands after the end"),
    ("o<unset> call", "", "p.ngc: in a file that it calls: #40 has a value"),
]  # fmt: skip


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
@pytest.mark.parametrize(("text", "machine", "why"), NOT_KNOWN_THERE)
def test_linuxcnc_is_not_asked_what_it_is_not_told(tmp_path, text, machine, why):
    program, file = tmp_path / "p.ngc", tmp_path / "machine.toml"
    program.write_text(f"G21\n{text}\n")
    (tmp_path / "below.ngc").write_text("o<below> sub\nG53 G0 X1\no<below> endsub\n")
    (tmp_path / "own.ngc").write_text("o<own> sub\nG0 X#1\no<own> endsub\n")
    (tmp_path / "77.ngc").write_text("O77 sub\nG0 Y77\nO77 endsub\n")
    (tmp_path / "changing.ngc").write_text("o<changing> sub\nT1 M6 G43 H1\no<changing> endsub\n")
    (tmp_path / "unset.ngc").write_text("o<unset> sub\nG0 X#40\no<unset> endsub\n")
    file.write_text(machine)
    with pytest.raises(InputError, match=re.escape(why)):
        read_by_rs274(program, ORIGIN, False, read_machine(file) if machine else Machine())


def test_what_linuxcnc_does_not_say_is_not_passed_over(tmp_path):
    file, of_no_length = tmp_path / "machine.toml", "1 N0 USE_TOOL_LENGTH_OFFSET(0, 0, 5, 0, 0, 0)"
    file.write_text(MACHINE)
    for machine, calls, why in (
        (Machine(), ["\n", "1 N3 WAVE(1)\n"], "line 3: word 'WAVE': WAVE is not understood"),
        (Machine(), ["Broken\n"], "rs274 says 'Broken', which is not understood"),
        (read_machine(file), ["1 N3 CHANGE_TOOL_NUMBER(9)"], "line 3: .* the machine file does not have"),
        (Machine(), [of_no_length, *["1 N1 STRAIGHT_FEED(1, 0, 0, 0, 0, 0)"] * 2], "line 1: .* is not known"),
    ):
        with pytest.raises(InputError, match=rf"^p.ngc: {why}"):
            rs274._take(rs274._Told(Path("p.ngc"), machine=machine), calls, unwatched)


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
def test_numbers_of_parameters_mean_the_same_by_names(tmp_path):
    """Of the program, of a subroutine, of one in a file of its own; on a line that sets them, too."""
    (tmp_path / "own.ngc").write_text(
        "o<own> sub\n#40=[#40+1] (#77)\nG0 X#1 Y#2 Z#40\no<own> endsub\nO9 if [0]\no<twin> call\nO9 endif\n"
    )
    # Two files that call each other.
    (tmp_path / "twin.ngc").write_text("o<twin> sub\no<own> call\no<twin> endsub\n")
    program = tmp_path / "p.ngc"
    program.write_text(
        "G21 G90 G0 X0\n#1=5 #31=7 #<_p1>=9\n#31=8 X#31\nX[#31*2] (#77)\n# 4 0=3\no<own> call [#1]\n"
        "X#1 Y#<_p1> ;#77\nO2 while [#40 LT 6]\n#40=[#40+1]\nX#40\nO2 endwhile\n"
    )
    ends = [tuple(map(float, move.end)) for move in read_by_rs274(program, ORIGIN, False, Machine()).moves]
    assert ends == [
        (0, 0, 0), (7, 0, 0), (16, 0, 0), (5, 0, 4), (5, 9, 4), (5, 9, 4), (6, 9, 4),
    ]  # fmt: skip


READ_AS_WRITTEN = [
    # Words in names and comments; blanks within words, and numbers of lines in parts.
    ("#<m1.5>=2 #<g53>=3 #<_l2>=4\nX#<m1.5> Y#<g53> Z#<_l2>", (2, 3, 4)),
    ("#<x=1>=7\nX#<x=1>", (7, 0, 0)),
    ("G 0 X 1 2 (G53) Y[# 3 1 + # 31] ;G28", (12, 16, 0)),
    ("N5.5 X1\nn 1 2X5", (5, 0, 0)),
    ("O1 if [#31 EQ 0]\nG53.5 X1\nO1 endif\nX2", (2, 0, 0)),
    # What is called after the end.
    ("M98 P9\no<s> call [3]\nM2\no<s> sub\nX#1\no<s> endsub\nO9\nY3\nM99\nX100", (3, 3, 0)),
    ("%\nX4\nM30\n%", (4, 0, 0)),
]


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
@pytest.mark.parametrize(("text", "end"), READ_AS_WRITTEN)
def test_words_are_those_that_linuxcnc_reads(tmp_path, text, end):
    program = tmp_path / "p.ngc"
    begin = "G21 G90 G0 X0 #31=8"
    program.write_text(text.replace("%", f"%\n{begin}", 1) if "%" in text else f"{begin}\n{text}\n")
    move = read_by_rs274(program, ORIGIN, False, Machine()).moves[-1]
    assert tuple(map(float, move.end)) == end


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
@pytest.mark.parametrize(("text", "limit"), [("", "_LONGEST"), ("G0 X1\nX2\n", "_MOST_BYTES")])
def test_a_program_without_an_end_is_told(tmp_path, monkeypatch, text, limit):
    monkeypatch.setattr(rs274, limit, 1)
    program = tmp_path / "p.ngc"
    program.write_text(f"G21\nO1 while [1 EQ 1]\n{text}O1 endwhile\nM2\n")
    with pytest.raises(InputError, match="rs274 did not end within"):
        read_by_rs274(program, ORIGIN, False, Machine())
    assert not completes(program, Machine(), 1)
    program.write_text("G21 G0 X1\nM60\nM2\n")
    if limit == "_LONGEST":
        assert "change of the pallet" in " ".join(read_by_rs274(program, ORIGIN, False, Machine()).notes)
        assert completes(program, Machine(), 9)


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
def test_whole_circles_stay_whole_where_decimals_are_lost(tmp_path):
    program = tmp_path / "p.ngc"
    program.write_text(
        "G21 F100\nG0 X0 Y1.00006\nG92 Y2.00004\nG3 X0 I25\nG92.1\nS9 M3\nG33.1 Z-5 K1\nG1 X9\n"
    )
    circle, down, up, last = read_by_rs274(program, ORIGIN, False, Machine()).moves[1:]
    assert circle.curve and max(circle.extent[1]) > 49
    assert down.end[2] == -5 and up.end[2] == last.end[2] == 0


def zero_of(file):
    """Return the offset of G54."""
    return np.array([float(c) for c in read_machine(file).offsets["G54"]])


@pytest.mark.parametrize("mode", ["G64 Q.25", "G64 P0 Q.25", "G64 P.0005 Q.25"])
def test_moves_may_be_joined_beside_the_tolerance_of_the_machine(tmp_path, read, mode):
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE)
    plain, joined = (
        read(f"G21 T1 M6 {said}\nG1 F9 X1\nX2 Y1", machine=read_machine(file)).moves[-1].slack
        for said in ("G64", mode)
    )
    # And arcs replaced by points before, a quarter of it apart.
    assert joined - plain == Fraction(5, 16)


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
def test_tolerances_are_not_less_than_the_program_gives(tmp_path):
    """Of 0.00014 inch LinuxCNC prints 0.0001."""
    program, slacks = tmp_path / "p.ngc", list[Fraction]()
    for mode in ("G61", "G64 P0.00014", "G64 P0.00014 Q0.00014"):
        program.write_text(f"G20 {mode}\nG1 F9 X1\nX2 Y1\n")
        slacks.append(read_by_rs274(program, ORIGIN, False, Machine()).moves[-1].slack)
    given = Fraction("0.00014") * Fraction("25.4")
    assert all(slack - slacks[0] >= Fraction(9, 4) * given for slack in slacks[1:])


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
def test_arcs_of_turned_systems(tmp_path):
    """What R of G10 turns is the path of the same program without it, turned about the zero."""
    program, file = tmp_path / "p.ngc", tmp_path / "machine.toml"
    file.write_text(MACHINE.replace("path_tolerance = 0.5\n", ""))
    found = []
    for angle in ("0", "30"):
        program.write_text(
            f"G21 G61 F9\nG10 L2 P1 X3 Y4 Z5 R{angle}\nG43 H1 G0 X9 Y0 Z2\nG18 G2 X15 Z1 R5\n"
            "G19 G3 Y-3 Z3 R7\nG17 G2 X10 R4\n"
        )
        found.append(read_by_rs274(program, ORIGIN, False, read_machine(file)).moves[1:])
    cos, sin = math.cos(math.pi / 6), math.sin(math.pi / 6)
    turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    called = tmp_path / "turn.ngc"
    called.write_text("o<turn> sub\nG10 L2 P1 X3 Y4 Z5 R30.00004\no<turn> endsub\n")
    program.write_text("G21 G61 F9\no<turn> call\nG43 H1 G0 X500 Y0 Z2\n")
    far = read_by_rs274(program, ORIGIN, False, read_machine(file)).moves[-1]
    # Its centre is 90 m away: that of a short arc says nothing of where the tool is.
    program.write_text("G21 G61 F9\nG10 L2 P1 R30\nG43 H1 G0 X0 Y0 Z2\nG2 X10 R90000\nX10.35 R4.8\n")
    long, short = read_by_rs274(program, ORIGIN, False, read_machine(file)).moves[-2:]
    assert max(short.slack, long.slack) < Fraction(1, 100) and short.length < 0.4
    angle = math.radians(30.00004)
    assert abs(float(far.end[1]) - (500 * math.sin(angle) + 4 - zero_of(file)[1])) <= float(far.slack)
    zero = np.array([3.0, 4.0, 5.0]) - zero_of(file)
    for plain, turned in zip(*found, strict=True):
        assert plain.curve is not None and turned.curve is not None
        assert turned.slack < Fraction(1, 1000) and turned.length == pytest.approx(plain.length)
        assert len(turned.corners) == len(plain.corners)
        low, high = (np.array([float(c) for c in corner]) for corner in turned.extent)
        for part in (Fraction(k, 7) for k in range(8)):
            there, here = (np.array([float(c) for c in move.at(part)]) for move in (plain, turned))
            assert np.abs(turn @ (there - zero) + zero - here).max() <= float(plain.slack + turned.slack)
            assert (low <= here).all() and (here <= high).all()


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
def test_linuxcnc_is_understood_to_the_last_line(tmp_path):
    program, file = tmp_path / "p.ngc", tmp_path / "machine.toml"
    # From six digits on a line's number and what follows stand together.
    program.write_text("G21 G61 G90 F100\nG0 X0\n" + "(c)\n" * 99_997 + "G1 X1\nG1 X14\n")
    assert [move.line for move in read_by_rs274(program, ORIGIN, False, Machine()).moves] == [
        2,
        100_000,
        100_001,
    ]
    # Rows of the tool table in another order than numbers; a radius that H and D do not name; no end.
    file.write_text(
        "loaded = 7\n[[tools]]\nnumber = 7\nlength = 10\nparts = [{ diameter = 2, length = 10 }]\n"
        "[[tools]]\nnumber = 3\nlength = 20\nparts = [{ diameter = 9, length = 10 }]\n"
    )
    program.write_text("G21 F9\nG43 G0 Z40\nG41 G1 X3 Y-9\nX8\nY9\nG40 Y20\nG49 Z70\nT3 M6\nG43 H3 Z60\n")
    moves = read_by_rs274(program, ORIGIN, False, read_machine(file)).moves
    assert [move.tool for move in moves] == [7] * (len(moves) - 1) + [3]
    assert (moves[0].end[2], moves[-1].end[2]) == (40, 60) and max(move.end[1] for move in moves[:-2]) >= 9
    assert abs(moves[1].end[1] + 8) < 0.001 or abs(moves[2].end[1] + 8) < 0.001
    program.write_text("G21 F9\nG41 G1 X3 Y-9\nX8\nY9\n(end)\n")
    assert [move.line for move in read_by_rs274(program, ORIGIN, False, read_machine(file)).moves] == [
        3,
        4,
        4,
    ]


def test_without_linuxcnc_its_reader_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "a.nc").write_text("G0 X1")
    with pytest.raises(InputError, match="rs274 is not installed: install linuxcnc-uspace"):
        read_by_rs274(tmp_path / "a.nc", None, False, Machine())


def test_compensation_of_a_tool_of_unknown_length(read):
    program = read("G21 G43 H1\nG0 X1")
    assert program.notes[0] == "line 1: G43 is taken for the tool's true length"
    with pytest.raises(InputError, match=r"line 3: .*whose lengths are not known"):
        read("G0 Z1\nG43 H1\nG0 X1")


# What controls do differently, or what a reader that passes over a word would get wrong.
NOT_PASSED_OVER = [
    ("G18 F9 G98 G84 X5 Z5 Y-5 R2", "G84", "tapping in G18"), ("F9 G19 G98 G74 X-5 R2", "G74", "tapping"),
    ("F9 G98 G81 X1 Z-1 R2\nG20\nX5 Z-1 R2", "G81", "changed within a series"),
    ("F9 G98 G81 X1 Y1 Z-1 R2\nG18 X5 Y-1", "G81", "changed within a series"),
    ("T1 M6\nG0 X1\nT2 M6", "M6", "changes the tool"),
    ("G64 P0\nG0 X1", "G64", "round corners"), ("O[2.5] call", "O", "whole"),
    ("G92 @5 ^0\nG0 X1", "@5", "of a move"),
    ("G0 @30", "@30", "no angle"), ("G0 X1\nF9 G82 R5 P1", "F9", "without X, Y or Z"),
    ("G53", "G53", "without X, Y"),
    ("G64 P-1\nG0 X1", "P-1", "negative"), ("G0 X1\nG5 F9 X3 I1 J1 P1 Q1 T-3", "T-3", "negative"),
    ("O1 sub\nG0 X#2\nO1 endsub\nO1 call [1]", "X#2", "does not give it"),
    ("G98 F9 G81 X1 R2 Z-1\nG20\nX1", "G81", "without its depth"),
    ("G98 F9 G81 X1 R2 Z-1\nG92 X0", "G92", "series of cycles"),
    ("G98 F9 G81 X1 R2 Z-1\nG55 X1", "G55", "series of cycles"),
    ("G43 H1 G0 Z9\nG53 G0 Z-1", "G53", "offsets"), ("G43 H1 G0 Z9\nG43 H2 Z0", "move", "not known"),
    ("G0 X1\nM70", "M70", "not followed"),
    ("#1=[1 GE 1.0000005]\nG0 X1", "#", "equal to some controls only"),
    ("#1=EXISTS[#<_task>]\nG0 X1", "#", "may be the control's"), ("G0 X#5210", "X#5210", "does not give it"),
    ("G0 X#5400", "X#5400", "does not give it"),
    ("F9 G2 X0 I5\nG53 X10", "G53", "goes with G0 or G1"), ("G0 X1\nG53 @10", "@10", "of a move"),
    ("F9 G2 X0 I5\nG54 P5", "P5", "not on the line"), ("F9 G2 X0 I5\nG1 X5 R1", "R1", "not on the line"),
    ("F9 G98 G81 X1 R2 Z-1\nG0 X2 R5", "R5", "not on the line"),
    ("F9 G2 X0 I5\nR10", "R10", "not on the line"),
    ("G0 G92 X1", "G92", "split it"), ("G92\nG0 X1", "G92", "give one"), ("G53 G28 X0", "G28", "split it"),
    ("M61 Q1.7\nG0 X1", "Q1.7", "whole number"), ("M61\nG0 X1", "M61", "give Q"),
    ("F9 G2 X0 I5 P0", "X0", "give P1 to"), ("F9 G2 X0 I5 P10001", "X0", "give P1 to P10000"),
    ("F9 G2 X0 I5 P1.5", "P1.5", "whole number"), ("F9 G98 G81 X1 R2 Z-1 L0", "L0", "repeats 1 to"),
    ("O1 if [0]\nO2 if [1]\nG0 X2\nO1 endif\nO2 endif", "O endif", "another name"),
    ("O1 sub\nO1 endsub\nO1 sub\nO1 endsub\nG0 X1", "O<1>", "second subroutine"),
    ("G0 X[10**305]", "X[10**305]", "more than 1e+09"), ("O[#<foo>] call", "O", "does not give it"),
    ("O[10**305] call", "O", "more than"), ("G0 X1\nO1 break", "O", "no loop"),
    ("O1 repeat [10**200]\nO1 endrepeat", "O", "repeats more than"),
    # What LinuxCNC goes on to count; what it sets as it passes an end, and has not returned yet.
    ("O1 sub\nO3 repeat [2]\nG0 X#1\nO1 return\nO3 endrepeat\nO1 endsub\nO1 call [1]", "O", "leaves a"),
    ("#1=1\nO1 while [#1]\nO3 repeat [2]\nO1 break\nO3 endrepeat\nO1 endwhile", "O", "leaves a repeat"),
    ("O1 sub\nO3 repeat [2]\nO1 call\nO3 endrepeat\nO1 endsub\nO1 call", "O", "while it does already"),
    # What it keeps of a loop that was left, takes on its way to the end of one, or takes for another one.
    ("#1=0\nO1 while [1]\nO1 break\nO1 endwhile\nO2 do\n#1=[#1+1]\nO2 while [#1 lt 3]", "O",
     "with a break"),
    ("#1=0\nO9 sub\nO1 while [1]\nO1 break\nO1 endwhile\nO9 endsub\nO9 call\n"
     "O2 do\n#1=[#1+1]\nO2 while [#1 lt 3]", "O", "with a break"),
    ("#1=0\nO1 do\n#1=[#1+1]\nO2 if [#1 eq 2]\nO1 continue\nO2 elseif [#1 gt 9]\nO1 break\nO2 endif\n"
     "O1 while [#1 lt 4]", "O", "continue of a do"),
    ("#1=0\nO1 do\n#1=[#1+1]\nO2 if [#1 eq 1]\nO1 continue\nO2 endif\nO1 while [#1 lt 3]\nO3 repeat [2]\n"
     "G0 X1\nO3 endrepeat", "O", "continue of a do"),
    ("#1=0\nO1 while [0]\nO1 break\nO1 endwhile\nO3 do\n#1=[#1+1]\nO3 while [#1 lt 3]", "O", "with a break"),
    ("#1=0\nO1 while [0]\nO2 if [0]\nO2 else\nO1 break\nO2 endif\nO1 endwhile\nO3 do\n#1=[#1+1]\n"
     "O3 while [#1 lt 3]", "O", "with a break"),
    ("#1=0\nO1 while [#1 lt 4]\n#1=[#1+1]\nO2 if [#1 eq 2]\nO1 continue\nO2 endif\nO3 if [#1 gt 9]\n"
     "O1 break\nO3 endif\nO1 endwhile\nO4 do\n#1=[#1-1]\nO4 while [#1 gt 2]", "O", "with a break"),
    ("#1=0\nO1 do\n#1=[#1+1]\nO1 while [#1 lt 3]\nO1 do\n#1=[#1+1]\nO1 while [#1 lt 6]", "O<1>",
     "second loop"),
    ("O1 if [1]\nO1 endif\nO1 while [0]\nO1 endwhile", "O<1>", "second loop"),
    ("O1 repeat [2]\nO1 break\nO1 endrepeat", "O", "break of a repeat"),
    ("O1 repeat [2]\nO1 continue\nO1 endrepeat", "O", "continue of a repeat"),
    # In the machine's unit, of the table and not of the length in force.
    ("G92 X1\nG0 X#5211", "X#5211", "does not give it"), ("G49\nG0 Z#5403", "Z#5403", "does not give it"),
    ("G0 X#5410", "X#5410", "does not give it"),
    ("O1 sub\nG0 X#<_value>\nO1 endsub [5]\nO1 call", "X#<_value>", "does not give it"),
    ("O1 sub\nO1 endsub [5]\nO1 call\nO2 sub\nO2 endsub [7]\nG0 X#<_value>", "X#<_value>", "does not give"),
    # O<> is not O0, and the control may have an axis C.
    ("G0 X1\nM2\n(c)\nG0 X2 (a (b)", "(a (b)", "comment within a comment"),
    ("F0 G0 X1", "F0", "a feed must be positive"), ("G10 L3 P1 X0\nG0 X1", "G10", "only G10 L2 and L20"),
    ("G10 L2 P1 R30 X1\nG0 X1", "R30", "give --reader rs274"),
    ("G10 L20 P2 X0\nG55 G0 X1", "G10", "where G55 has its zero"),
    ("F9 G2 X9 R5 I4", "X9", "an arc by R and a centre"), ("F9 G2 X9 I4.5 K1", "X9", "K is not in the plane"),
    ("F9 G90.1 G2 X9 I4.5", "X9", "takes a whole centre: give I and J"),
    ("F9 G2 X0 I0", "X0", "an arc without a radius"),
    ("F9 G18 G5 X1 Y1 I1 J1 P1 Q1", "X1", "is in the XY plane"),
    ("F9 G5 X1 Z1 I1 J1 P1 Q1", "X1", "is in the XY plane"),
    ("F9 G5.1 X1 Y1 I1", "X1", "without its first control point"),
    ("F9 G5 X5 Y1 I1 J1 P1", "X5", "without its second control point"),
    ("F9 G5.2 X5 Y1 P1 L3\nF5", "F5", "not a control point: give X and Y and P"),
    ("F9 G0 X3\nG5.2 P.01 L3\nX4 Y0 P.01\nX-4 Y0 P20\nG5.3", "G5.2", "two arcs do not follow"),
    ("#5220=2\nG0 X1", "#", "set none but #1 to #4999"),
    ("##7=1\nG0 X1", "#", "#7 has a value that the program does not give it"),
    ("O.5 G0 X1", "O.5", "stands alone on its line"),
    ("O1 if [1]\nG0 X1\nO1 endwhile", "O endwhile", "endif expected"),
    ("O0 sub\nG0 X3\nO0 endsub\nO<> call", "O", "a name of letters, digits"),
    ("O1 if [1] [1]\nO1 endif", "O1", "if takes one value"),
    ("O1 if [1]\nG0 X1\nO1 else [0]\nG0 X2\nO1 endif", "O1", "else takes no value"),
    ("O1 sub\nO1 return [1] [2]\nO1 endsub", "O1", "return takes one value at most"),
    ("O1 call" + " [1]" * 31, "O1", "call takes 30 values at most"),
    ("T1 M6\nG43 H2 G0 X1", "G43", "the length of tool 2 is not known"),
    ("G43 H2\nT1 M6\nG0 Z1", "move", "with the length of another tool"),
    ("G0 X#5425", "X#5425", "does not give it"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "word", "why"), NOT_PASSED_OVER)
def test_nothing_is_passed_over(read, text, word, why):
    with pytest.raises(InputError) as refused:
        read(text)
    assert f"word '{word}': " in str(refused.value) and why in str(refused.value)


def test_what_is_nested_too_deeply_is_refused(read):
    for text in ("G0 X" + "[" * 240, "".join(f"O{n} if [1]\n" for n in range(3000))):
        with pytest.raises(InputError, match=r"nested too deeply"):
            read(text)


@pytest.mark.parametrize("reader", ["own", "rs274"])
def test_moves_of_another_file_have_the_line_of_its_call(tmp_path, reader):
    if reader == "rs274" and shutil.which("rs274") is None:
        pytest.skip("rs274 (linuxcnc-uspace) is not installed")
    program = tmp_path / "main.ngc"
    program.write_text(
        "o<beside> call\nG21 G61 F9\nO1 repeat [2]\no<beside> call\no<beside> call\nO1 endrepeat\n"
        "G0 X9\nO2 if [0]\no<beside> call\nO2 endif\no<beside> call\nM2\n"
    )
    (tmp_path / "beside.ngc").write_text("o<beside> sub\nF9 G21 G1 X2\nN100 G1 X3\no<beside> endsub\n")
    read = read_program if reader == "own" else read_by_rs274
    found = read(program, ORIGIN, False, Machine())
    assert [move.line for move in found.moves] == [1, 1, 4, 4, 5, 5, 4, 4, 5, 5, 7, 11, 11]
    noted = [note for note in found.notes if "without G61" in note]
    assert [note.partition(":")[0] for note in noted] == ["line 1"]
    assert "millimetres" not in str(found.notes)


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is not installed")
def test_a_file_of_its_own_changes_the_tool(tmp_path):
    program, file = tmp_path / "p.ngc", tmp_path / "machine.toml"
    file.write_text(MACHINE)
    program.write_text("G21 G61\no<change> call\nG0 X5\n")
    (tmp_path / "change.ngc").write_text("o<change> sub\nT1 M6\nG43 H1\nG0 Z90\no<change> endsub\n")
    ours, theirs = (
        read(program, ORIGIN, False, read_machine(file)) for read in (read_program, read_by_rs274)
    )
    assert [(move.line, move.end, move.tool) for move in ours.moves] == [
        (move.line, move.end, move.tool) for move in theirs.moves
    ]
    program.write_text("G21 T1 M6\nG0 X5\nT2 M6\n")
    late = read_by_rs274(program, None, False, read_machine(file))
    start = "line 2: the first move starts at X0 Y0 Z0, which is assumed: give --start"
    assert late.changes and start in late.notes and "changed to after the last move" in late.notes[-1]


def test_each_step_of_a_repeated_angle_turns_on(read):
    moves = read("T1 M6\nG0 X10 Z10\nF9 G91 G98 G81 ^90 R-5 Z-10 L3\nG80\nT1 M6\nG0 X1").moves
    holes = [tuple(round(float(c), 9) for c in move.end[:2]) for move in moves if move.end[2] == -5]
    assert holes == [(0, 10), (-10, 0), (0, -10)]


SERIES = [
    ("G0 Z10\nF9 G91 G99 G81 X10 R-8 Z-3\nX10", [2, -1, 2, 2, -1, 2]),
    ("G0 Z-5\nF9 G99 G81 X1 R19 Z-6\nX5 R6", [19, -6, 19, 6, 6, -6, 6]),
    # Below R, not below the height at which it began: straight to the next hole.
    ("G0 Z5\nF9 G99 G81 X1 R1 Z-6\nX5 R2", [1, -6, 1, 2, -6, 2]),
    ("G0 Z20\nF9 G99 G81 X1 R2 Z-1\nG98 X5\nX9", [2, -1, 2, 2, -1, 20, 2, -1, 20]),
]


@pytest.mark.parametrize(("text", "heights"), SERIES)
def test_a_series_of_cycles_has_the_height_at_which_it_began(read, text, heights):
    found = [move.end[2] for move in read(text).moves if move.start[:2] == move.end[:2]]
    assert found[-len(heights) :] == heights


def test_files_without_moves(read, tmp_path):
    for text in ("", "\n\n", "G21 G90\nM30", "(only a comment)", b"\x00"):
        with pytest.raises(InputError, match=r"no moves|line 1: word"):
            read(text)
    with pytest.raises(InputError, match="cannot read"):
        read_program(tmp_path / "no.nc", ORIGIN)


DECIMALS = st.decimals(-9999, 9999, places=4)


# A slow machine is no failure.
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
