"""The words of a line, as LinuxCNC's interpreter reads them, or a refusal where a word may be any."""

import re
from dataclasses import dataclass
from functools import cached_property

from triaxis.golden.input_file import Place
from triaxis.host.motion.expression import Parameter
from triaxis.host.motion.gcode import LATE_DELETE, Computed, Flow, Word, read_line, without_comments
from triaxis.host.motion.program_text import COMMENT

_COMMENTS = re.compile(f"({COMMENT.pattern})")
# Of a line without blanks, which the interpreter passes over within numbers, too.
_BEGINNING = re.compile(r"(/?)(?:n\d+(?:\.\d+)?)?", re.ASCII)
# Words that say what is done, with a number that is not rounded, or a computed one.
_DECIDING, _CLEAR = "GML", re.compile(r"(g\d*\.?\d?|[ml]\d*\.?)0*|[gml][\[#].*", re.ASCII)


@dataclass(frozen=True)
class Line:
    """A line of a program. ``text``: without blanks, and without / and N at its beginning.

    ``does``: what its O word does, with what is called ``name``; ``within``: whether it is of a subroutine.
    """

    place: Place
    text: str
    optional: bool = False
    words: tuple[Word | Computed, ...] = ()
    sets: tuple[Parameter, ...] = ()
    reads: tuple[Parameter, ...] = ()
    does: str = ""
    name: str = ""
    within: bool = False

    @cached_property
    def codes(self) -> dict[str, Word | Computed]:
        """Return the words that say what is done, by what they are."""
        return {word.code: word for word in self.words if word.letter in _DECIDING}

    def any_of(self, *codes: str) -> Word | Computed | None:
        """Return a word that is one of some, or may be, as it is computed."""
        return next((self.codes[key] for code in codes for key in (code, code[0]) if key in self.codes), None)


def words_of(place: Place, line: str) -> Line:
    """Return what is on a line; raise InputError where that is not known, or where it is not understood."""
    parts = enumerate(_COMMENTS.split(line))
    text = "".join(part if index % 2 else "".join(part.split()).lower() for index, part in parts)
    if text == "%":
        return Line(place, text)
    beginning = _BEGINNING.match(text)
    assert beginning is not None
    optional, text = bool(beginning[1]), text[beginning.end() :]
    code = without_comments(place, text)
    try:
        read = read_line(place, text, code)
    except RecursionError as error:
        raise place.error(text, "expressions nested too deeply: simplify it") from error
    words, sets, does, name = (), (), "", ""
    if isinstance(read, Flow):
        does, name = read.does, read.written
    else:
        words, sets = read.words, read.sets
        if read.optional:
            raise place.error(text, LATE_DELETE)
    parameters = {code[parameter.start : parameter.end]: parameter for parameter in (*sets, *read.reads)}
    if apart := next((part for part in (*parameters, *(w.text for w in words)) if " " in part), None):
        raise place.error(apart, "a comment within a word: move it behind that")
    for word in words:
        if word.letter == "O":
            does, name = "program", "" if word.text[1:].isdigit() else None
        if word.letter in _DECIDING and not _CLEAR.fullmatch(word.text):
            why = "a number with a sign, or of a function, that says what is done: write the number alone"
            if re.match(r"[\d.]", word.text[1:]):
                why = "is rounded to another word: write that"
            raise place.error(word.text, why)
    if name is None:
        raise place.error(text, "an O word whose name is computed: name it, or leave --reader out")
    if optional and does in ("sub", "endsub"):
        raise place.error(text, "a subroutine that may be left out: begin its lines without /")
    if computed := next((shown for shown, parameter in parameters.items() if parameter.key is None), None):
        raise place.error(computed, "may be any parameter: name it, or leave --reader out")
    return Line(place, text, optional, words, sets, read.reads, does, name)
