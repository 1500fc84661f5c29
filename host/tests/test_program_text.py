"""Lines that controls read otherwise, by both readers of programs."""

import shutil

import pytest

from triaxis.golden.errors import InputError
from triaxis.host.motion.interpreter import ORIGIN
from triaxis.host.motion.machine import Machine
from triaxis.host.motion.program import read_program
from triaxis.host.motion.rs274 import completes, read_by_rs274

READERS = [
    read_program,
    pytest.param(
        read_by_rs274,
        marks=pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is missing"),
    ),
]
# Each is put into a branch that is not run.
READ_OTHERWISE = [
    # LinuxCNC goes on after 254 characters, and at a zero, with a new line.
    (b";\0" + b"a" * 252 + b"G0 X50", "after 253 characters"),
    (b"G1 X5 (" + b"a" * 250 + b")", "after 253 characters"),
    (b"G1 X5\0", "ends at a zero"),
    # It knows these two apart, and would take the last for #<ab>.
    ("#<WEITE_Ä>=50".encode(), "'\\\\xc4' outside of comments"),
    ("#<länge>=50".encode("latin-1"), "'\\\\ufffd' outside of comments"),
    ("#<a\u00a0b>=50".encode(), "'\\\\xa0' outside of comments"),
    (b"#<a\x0bb>=50", "'\\\\x0b' outside of comments"),
    (b"#<a(x)>=50", "word '#<a\\(x\\)>=50': a comment within a name"),
    # It runs these.
    (b"(py,import os)", "as Python"), (b"G0 X1 ; PY run,a.py", "as Python"), (b"( pyreload)", "as Python"),
]  # fmt: skip


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize(("line", "why"), READ_OTHERWISE)
def test_lines_that_controls_read_otherwise_are_refused(tmp_path, reader, line, why):
    program = tmp_path / "p.ngc"
    program.write_bytes(b"G21 G90 F100\nG1 X1\no1 if [0]\n" + line + b"\no1 endif\nM2\n")
    with pytest.raises(InputError, match=f"line 4: .*{why}"):
        reader(program, ORIGIN, False, Machine())
    # What a called file holds, too.
    program.write_text("G21 G90 F100\nG1 X1\no<called> call\nM2\n")
    (tmp_path / "called.ngc").write_bytes(b"o<called> sub\n" + line + b"\no<called> endsub\n")
    with pytest.raises(InputError, match=f"called.ngc: line 2: .*{why}"):
        reader(program, ORIGIN, False, Machine())


@pytest.mark.parametrize("reader", READERS)
def test_comments_may_hold_anything_else(tmp_path, reader):
    program = tmp_path / "p.ngc"
    line = "G1 X2 (für: <x> ; pyramid, py) (print,1) ; #<ä> (py)"
    program.write_bytes("\ufeff".encode() + f"G21 G90 F100\r\n{line}\r\no<called> call\nM2\r".encode())
    (tmp_path / "called.ngc").write_text("o<called> sub\n(print,2) (DEBUG, 3)\nG1 X3 (ü)\no<called> endsub\n")
    moves = reader(program, ORIGIN, False, Machine()).moves
    assert [float(move.end[0]) for move in moves] == [2, 3]


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is missing")
@pytest.mark.parametrize("called", [False, True])
def test_a_line_does_not_grow_beyond_what_is_read(tmp_path, called):
    program, own = tmp_path / "p.ngc", tmp_path / "own.ngc"
    line = "#31=5 ;" + "a" * 238 + " G0 X50"
    assert len(line) == 252
    program.write_text(f"G21 G0 X1\n{'o<own> call' if called else line}\nM2\n")
    own.write_text(f"o<own> sub\n{line}\no<own> endsub\n")
    with pytest.raises(InputError, match=f"{(own if called else program).name}: '.*longer than it reads"):
        read_by_rs274(program, ORIGIN, False, Machine())


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is missing")
def test_parameter_0_does_not_exist(tmp_path):
    program = tmp_path / "p.ngc"
    program.write_text("G21 G90 G0 X1\nX[5+EXISTS[# 0 0]]\nX[7+EXISTS[#1]]\nM2\n")
    moves = read_by_rs274(program, ORIGIN, False, Machine()).moves
    assert [float(move.end[0]) for move in moves] == [1, 5, 8]


# What LinuxCNC takes for the end of a branch that it does not run, where it checks nothing but the word.
TAKEN_FOR_AN_END = [
    "o1 else if [#1 EQ 2]", "o1 el se", "o1 else foo", "o1 else )", "N 5 o1 else", "N5.5 o1 else", "/o1 else",
    "o1.0 else", "o+1 else", "o1 elseif [1] G0 X7", "(otherwise) o1 else", "o1 (c) else", "N5 (c) o1 else",
    "o1 elseif (c) [1]",
]  # fmt: skip


@pytest.mark.parametrize("line", TAKEN_FOR_AN_END)
def test_an_o_word_that_is_wrong_is_refused_in_a_branch_that_is_not_run(tmp_path, line):
    program = tmp_path / "p.ngc"
    program.write_text(f"G21 G90 F100 #1=2\nG1 X1\no1 if [#1 EQ 1]\nG1 X5\n{line}\nG1 X50\no1 endif\n")
    with pytest.raises(InputError, match="line 5"):
        read_program(program, ORIGIN)
    program.write_text("G21 G90 F100\nG1 X1\no1 if [0] (never) ; not\nG1 X5\nO1 else(c)\nG1 X2\no1 endif\n")
    assert [float(move.end[0]) for move in read_program(program, ORIGIN).moves] == [1, 2]


@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 (linuxcnc-uspace) is missing")
@pytest.mark.parametrize("called", [False, True])
def test_a_program_that_would_be_run_as_python_is_not(tmp_path, called):
    program, trace = tmp_path / "p.ngc", tmp_path / "trace"
    runs = f"(py,open('{trace}', 'w'))"
    (tmp_path / "a.ngc").write_text(f"o<a> sub\n{runs if called else ''}\no<a> endsub\n")
    program.write_text(f"G21 G0 X1\n{'' if called else runs}\no<a> call\nM2\n")
    assert not completes(program, Machine(), 9) and not trace.exists()
    program.write_text("G21 G0 X1\nM2\n")
    (tmp_path / "a.ngc").unlink()
    assert completes(program, Machine(), 9)
