"""The words of a G-code file, read strictly: what is not understood is refused, with its line and word.

The parsers on the package index do not fit: gcodeparser 0.3.0 drops lines of axis words without a G, runs
comments in parentheses, and pygcode 0.2.1 drops the rest of a line after a character that it does not know;
both round to binary.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import Place, read_input

# What follows a program could be run by a control: nothing of a file is passed over.
AFTER_THE_END = "stands after the end of the program: remove it, or split the file"

# Digits of a number: more than any control takes, few enough to keep exact sums small.
_DIGITS = 15

_WORD = re.compile(r"([A-Za-z])[ \t]*([+-]?(?:\d+\.?\d*|\.\d+))", re.ASCII)
_LINE_END = re.compile(r"\r\n|\n|\r")


@dataclass(frozen=True)
class Word:
    """A letter, in upper case, and an exact number. ``text`` is how it stands in the file."""

    letter: str
    value: Fraction
    text: str

    @property
    def code(self) -> str:
        """Return the word in its shortest form: G1 for g01, G38.2, X-0.5."""
        value = self.value
        return f"{self.letter}{value.numerator if value.denominator == 1 else float(value)}"


@dataclass(frozen=True)
class Block:
    """The words of one line. ``optional``: it begins with the block-delete sign, /."""

    place: Place
    words: tuple[Word, ...]
    optional: bool


def read_blocks(path: Path) -> Iterator[Block]:
    """Yield the lines with words, in order. A single % stands before the first, and after the last.

    Raises InputError where the file cannot be read, a line is not made of words, comments and blanks, or
    anything follows the closing %.
    """
    text = read_input(path).removeprefix(b"\xef\xbb\xbf").decode("utf-8", errors="replace")
    started = closed = False
    for number, line in enumerate(_LINE_END.split(text), 1):
        place = Place(path, number)
        body = _without_comments(place, line).strip()
        if body == "%":
            closed = started
            started = True
        elif body and closed:
            raise place.error(body.split()[0], AFTER_THE_END)
        elif body:
            started = True
            yield _block(place, body)


def _without_comments(place: Place, line: str) -> str:
    """Return the line with a blank in place of each comment, ( .. ) or ; to its end."""
    kept: list[str] = []
    rest = line
    while match := re.search(r"[();]", rest):
        kept.append(rest[: match.start()])
        tail = rest[match.start() :]
        if match[0] == ";":
            return "".join(kept)
        if match[0] == ")":
            raise place.error(tail, "')' without '(': remove it")
        end = tail.find(")")
        if end < 0:
            raise place.error(tail, "the comment does not end on its line: add ')'")
        if "(" in tail[1:end]:
            raise place.error(tail, "a comment within a comment: remove the inner '('")
        kept.append(" ")
        rest = tail[end + 1 :]
    return "".join((*kept, rest))


def _block(place: Place, body: str) -> Block:
    optional = body.startswith("/")
    rest = body.removeprefix("/").lstrip()
    words: list[Word] = []
    while rest:
        match = _WORD.match(rest)
        if match is None:
            raise _not_a_word(place, rest)
        letter, digits = match.groups()
        if sum(c.isdigit() for c in digits) > _DIGITS:
            raise place.error(match[0], f"more than {_DIGITS} digits: round it")
        words.append(Word(letter.upper(), Fraction(digits), match[0]))
        rest = rest[match.end() :].lstrip()
    return Block(place, tuple(words), optional)


def _not_a_word(place: Place, rest: str) -> InputError:
    """Return what is wrong with a line that goes on with ``rest``."""
    word = rest.split()[0]
    if "#" in word or "[" in word or "=" in word:
        why = "parameters and expressions are not supported: post-process to plain numbers"
    elif rest[0] == "/":
        why = "block delete is understood at the beginning of a line only: move it there"
    elif rest[0] == "%":
        why = "'%' stands alone on its line: remove it"
    elif rest[0].isascii() and rest[0].isalpha():
        why = "no decimal number after the letter: give one"
    else:
        why = "not a letter followed by a decimal number: correct or remove it"
    return place.error(word, why)


# Words that change where the tool is, or its shape, in ways that are not followed: why, and what to do.
WHY_REFUSED = {
    code: why
    for codes, why in (
        ("G2 G3", "arcs are not supported: let the post-processor write them as G1 chords"),
        ("G5", "splines are not supported: let the post-processor write them as G1 chords"),
        ("G10 G52 G92 G92.1 G92.2 G92.3 G55 G56 G57 G58 G59 G59.1 G59.2 G59.3",
         "moves the program's zero by a value of the control: remove it, or give absolute moves from program "
         "zero"),
        ("G28 G28.1 G30 G30.1",
         "goes to a position that only the machine knows: remove it, or write the move with G0"),
        ("G53",
         "moves in machine coordinates, which only the machine knows: remove it, or write the move with G0"),
        ("G33", "threading is not supported: let the post-processor write plain moves"),
        ("G38.2 G38.3 G38.4 G38.5 G31", "probing ends where the part is: remove it from the program"),
        ("G41 G42 G41.1 G42.1",
         "radius compensation moves the path by a value of the control: compensate in the post-processor"),
        ("G43 G43.1 G43.2 G43.4 G44",
         "length compensation moves the tool by a value of the control: give the tool's STL in its true "
         "place"),
        ("G50 G51 G68 G69", "scaling and rotation of the program are not supported: remove it"),
        ("G64", "lets the control round corners, off the programmed path: use G61"),
        ("G73 G76 G81 G82 G83 G84 G85 G86 G87 G88 G89",
         "canned cycles are not supported: let the post-processor write plain moves"),
        ("G93 G95", "only feed per minute is supported: use G94"),
        ("M19", "orients the spindle, and so turns the tool: remove it"),
        ("M97 M98 M99", "subprograms are not supported: write them out"),
        ("A B C U V W",
         "only X, Y and Z move: remove it, or check each position with `triaxis check --rotate`"),
        ("D H I J K L Q R", "belongs to a word that is not supported: remove it"),
        ("E", "not a word of a mill's program, and numbers take no exponent: write the number out"),
        ("O", "subprograms are not supported; a program number stands alone on its line: write them out"),
    )
    for code in codes.split()
}  # fmt: skip
