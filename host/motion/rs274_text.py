"""What LinuxCNC's interpreter is given of a program: text that it cannot mistake, or a refusal.

Each line is given its number as N word, so that moves know theirs. Where a line changes the tool and its
compensation the interpreter forgets the new tool's length until Z moves: as both are done in turn, such a
line is given as two. Comments of the program that print become plain ones. Numbered parameters are given as
named ones: of these it tells when one is read that has no value yet, where it would take a number for what
the last program left, or for 0.
"""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import Place
from triaxis.host.motion.expression import ARGUMENTS, CONTROL_NAMES, NO_VALUE, Key
from triaxis.host.motion.gcode import AFTER_THE_END, BOTH_PLACES, Word
from triaxis.host.motion.interpreter import RESTORES
from triaxis.host.motion.machine import Machine
from triaxis.host.motion.program_text import LONGEST_LINE, lines_of
from triaxis.host.motion.rs274_words import Line, words_of

# From which number on parameters are the control's; those that follow from the program all the same.
_CONTROLS, _POSITION = 5000, (5420, 5421, 5422)
_WHOSE = "an argument, in a program with M98 and O sub: of which call is not known: use #31 or more"
_NESTING = ("sub", "if", "while", "repeat", "do")
# Of names that begin with _, those that mean the same on each machine; the others are the control's.
_MEANT = frozenset(("_x", "_y", "_z", "_metric", "_imperial", "_absolute", "_incremental"))
_PRINTING = re.compile(r"([(;]\s*)(?=print|debug|log|probe)", re.IGNORECASE)
# A number as a name: a program has none with a bracket in it.
_NAMED = "_[{}]"
# What the interpreter says of a name without a value: the name, its number where it stands for one, the line.
_UNSET = re.compile(r"Named parameter #(<(?:_\[(\d+)\])?[^>]*>) not defined\s*(?:N(\d+) )?")


@dataclass(frozen=True)
class Prepared:
    """A program as the interpreter is given it: its lines, each with its number, and the files that it calls.

    ``split``: numbers of lines that are given as two; ``turns``: whether any may turn a system; ``optional``:
    whether any may be left out.
    """

    lines: list[str]
    called: dict[str, list[str]]
    split: frozenset[int]
    turns: bool
    optional: bool


def prepared(path: Path, machine: Machine) -> Prepared:
    """Return what is given of a program; raise InputError at what would be mistaken."""
    files = _files(path)
    every = [*chain(*files.values())]
    _refuse_unknown(files, machine)
    _refuse_after_the_end(files[path])
    given, split = dict[Path, list[str]](), set[int]()
    for file, lines in files.items():
        given[file] = list[str]()
        for line in lines:
            # Those of the program are given around it.
            if line.text == "%" and file == path:
                continue
            parts, number = [line], ""
            if file == path:
                parts, number = _parts(line), f"N{line.place.line} "
                split |= {line.place.line} if len(parts) > 1 else set()
                # What another file holds has no numbers: a comment that is printed tells that it is called.
                given[file] += [f"{number}(MSG,)"] if line.does == "call" else []
            begin = "/" * line.optional + number
            given[file] += [begin + text for part in parts for text in _given(part) if text]
        if long := next((text for text in given[file] if len(text.encode()) > LONGEST_LINE), None):
            why = "with its number, and names for parameters, longer than it reads: break the line"
            raise InputError(f"{file}: '{long[:20]}': {why}")
    # What waits for the next move goes with the end.
    last = max((line.place.line for line in files[path] if line.words and not line.within), default=0)
    program = [*given.pop(path), f"N{last} M2"]
    called = {file.name: text for file, text in given.items()}
    turns, optional = any(line.any_of("G10") for line in every), any(line.optional for line in every)
    return Prepared(program, called, frozenset(split), turns, optional)


def unset(path: Path, errors: str) -> InputError | None:
    """Return what is to be said where the interpreter tells of a parameter without a value."""
    found = _UNSET.search(errors)
    if found is None:
        return None
    name = f"#{found[2] or found[1]}"
    if found[3]:
        return Place(path, int(found[3])).error(name, NO_VALUE)
    # What another file holds has no numbers.
    return InputError(f"{path}: in a file that it calls: {name} {NO_VALUE}")


def _files(path: Path) -> dict[Path, list[Line]]:
    """Return the lines of a program, and of the files beside it of subroutines that it calls."""
    files, waiting = dict[Path, list[Line]](), [path]
    for file in waiting:
        if file in files:
            continue
        files[file], within = list[Line](), False
        for count, text in enumerate(lines_of(file), 1):
            line = words_of(Place(file, count), text)
            within |= line.does == "sub"
            files[file].append(replace(line, within=True) if within else line)
            within &= line.does != "endsub"
        waiting += _called(file, files[file])
    return files


def _called(path: Path, lines: Sequence[Line]) -> list[Path]:
    """Return the files beside a program of subroutines that it calls and does not hold."""
    calls, defined = (
        {line.name: line.place for line in reversed(lines) if line.does == does} for does in ("call", "sub")
    )
    for line in lines:
        # It looks for a file first. M words that are computed are refused.
        if "M98" in line.codes:
            number = {f"{round(p.value)}" for p in line.words if p.letter == "P" and isinstance(p, Word)}
            beside = [file for file in path.parent.glob("*.ngc") if file.stem.isdigit()]
            if taken := [file for file in beside if not number or file.stem in number]:
                why = f"may call {taken[0].name}, which stands beside: rename that"
                raise line.place.error("M98", why)
    here = {name: file for name in calls if (file := path.parent / f"{name}.ngc").exists()}
    for name in here.keys() & defined:
        # A control takes what it has come by, and else the file.
        if calls[name].line < defined[name].line:
            word = name if name.isdigit() else f"<{name}>"
            raise calls[name].error(f"O{word}", BOTH_PLACES.format(here[name].name))
    return [file for name, file in here.items() if name not in defined]


def _refuse_unknown(files: Mapping[Path, Sequence[Line]], machine: Machine) -> None:
    """Raise InputError at words for which the interpreter would take what it is not told for 0, and others
    that it mistakes.
    """
    wanting, path, every = list(_wanting(machine)), next(iter(files)), [*chain(*files.values())]
    known = _MEANT | ({parameter.key for line in every for parameter in line.sets} - CONTROL_NAMES)
    # M98 calls lines that stand in no subroutine, with the arguments of whoever calls.
    unclear = any(line.any_of("M98") for line in every) and any(line.within for line in every)
    for file, lines in files.items():
        shift_known = any_flow = False
        returned = file != path
        for line in lines:
            for key in (parameter.key for parameter in line.sets):
                if isinstance(key, int) and key >= _CONTROLS:
                    why = "sets what is the control's: say it by G10, or in a machine file"
                    raise line.place.error(f"#{key}", why)
            if not shift_known and line.any_of("G92.3"):
                raise line.place.error("G92.3", RESTORES)
            any_flow |= bool(line.does)
            # What a branch, a call or / may leave out says nothing.
            plain = file == path and not any_flow and not line.optional
            shift_known |= plain and not line.codes.keys().isdisjoint(("G92", "G92.1", "G52"))
            returned |= line.does == "call"
            if file != path and line.any_of("M6") and line.any_of("G43", "G49"):
                why = "with a change of the tool, in a file of its own, which it mistakes: give two lines"
                raise line.place.error("G43", why)
            letters = {word.letter for word in line.words}
            # It goes by the linear axes that are named.
            by_linear = letters & set("XYZ") and not letters & set("ABC")
            if machine.rotary and not by_linear and (word := line.any_of("G28", "G30")):
                why = "turns axes to where only the machine knows: name X, Y or Z, and no other"
                raise line.place.error(word.text, why)
            for codes, kind, why in wanting:
                if (word := line.any_of(*codes)) and (not kind or line.any_of(kind)):
                    raise line.place.error(word.text, why)
            for key in (parameter.key for parameter in line.reads):
                # Of numbers up to the control's own the interpreter tells.
                free = isinstance(key, int) and (key < _CONTROLS or key in _POSITION)
                # The last value that a subroutine has returned, of this program once it has called one.
                if not (free or key in known or (returned and key == "_value")):
                    raise line.place.error(f"#{key}" if isinstance(key, int) else f"#<{key}>", NO_VALUE)
            numbers = {parameter.key for parameter in (*line.sets, *line.reads)}
            if unclear and not line.within and not numbers.isdisjoint(range(1, ARGUMENTS + 1)):
                raise line.place.error("#", _WHOSE)


def _wanting(machine: Machine) -> Iterator[tuple[Collection[str], str, str]]:
    """Yield words for which a machine does not tell enough, on a line with which L word, if any; and why."""
    tools = machine.tools.values()
    if "G54" not in machine.offsets:
        frame = "needs machine coordinates: give the offset of G54 in a machine file"
        yield from ((("G10",), "L2", frame), (("G53", "G28", "G30"), "", frame))
    if not tools or any(tool.length is None for tool in tools):
        lengths = "needs the length of each tool: give all in a machine file"
        yield from ((("G10",), "L1", lengths), (("G43", "G43.1", "G43.2"), "", lengths))
    if not {"G54", "G59.3"} <= machine.offsets.keys():
        why = "sets a tool by the zero of G59.3: give the offsets of G54 and G59.3 in a machine file"
        yield ("G10",), "L11", why
    for home in ("G28", "G30"):
        if home not in machine.homes:
            yield (home,), "", f"goes home: give {home} in a machine file"
    if not tools or any(tool.diameter is None for tool in tools):
        why = "needs the diameter of each tool: give parts with diameters in a machine file"
        yield ("G41", "G42", "G41.1", "G42.1"), "", why
    yield ("M61",), "", "its tool is not known to the interpreter: change tools with M6"


def _refuse_after_the_end(lines: Sequence[Line]) -> None:
    """Raise InputError at what stands after the end, but for what is called; and where M99 may end the
    program itself, which a control then runs again for ever.
    """
    started = closed = ended = numbered = False
    # What is open: branches, loops, and subroutines.
    within = set[tuple[str, str]]()
    for line in lines:
        if line.text == "%":
            closed = started
        says = line.words or line.sets or line.does
        called = numbered or line.within or line.does == "program"
        if says and (closed or (ended and not called)):
            raise line.place.error(line.text, AFTER_THE_END)
        started |= bool(says or line.text == "%")
        kind = line.does.removeprefix("end")
        if kind != line.does:
            within.discard((line.name, kind))
        elif kind == "while" and (line.name, "do") in within:
            within.remove((line.name, "do"))
        elif kind in _NESTING:
            within.add((line.name, kind))
        # What a branch or / may leave out ends nothing.
        plain = not within and not line.optional
        ended |= plain and not line.codes.keys().isdisjoint(("M2", "M30"))
        # A number that stands before the program's end may be its own.
        numbered |= ended and not line.optional and line.does == "program"
        if not numbered and (word := line.any_of("M99")):
            why = "begins the program anew, for ever: end it with M2, and begin what M98 calls after that"
            raise line.place.error(word.text, why)


def _parts(line: Line) -> list[Line]:
    """Return a line; the change of the tool by itself, and the rest, where it sets compensation, too."""
    plain = not line.sets and not any("[" in word.text for word in line.words)
    if not plain or "M6" not in line.codes or line.codes.keys().isdisjoint(("G43", "G49")):
        return [line]
    parts = ["", ""]
    for word in line.words:
        parts[not (word.letter == "T" or word.code == "M6")] += word.text
    return [replace(words_of(line.place, part), within=line.within) for part in parts]


def _given(line: Line) -> list[str]:
    """Return a line with names for numbers of parameters, but for the arguments of subroutines.

    Before it, one that reads what it both sets and reads: on its own line a name that is set has a value
    already, 0. The number in that is no parameter's any more.
    """

    def given(key: Key | None) -> str:
        if isinstance(key, int) and 0 < key < _CONTROLS and not (line.within and key <= ARGUMENTS):
            key = _NAMED.format(key)
        return f"#<{key}>" if isinstance(key, str) else f"#{key}"

    def asked(key: Key | None) -> str:
        # A number always exists, but for 0. Whether a name that all programs share does hangs on those
        # before; where it has a value it does.
        if not isinstance(key, str):
            return f"[{key and 1}]"
        return f"[1+0*{given(key)}]" if key.startswith("_") else f"exists[{given(key)}]"

    text, reads = line.text, set[str]()
    for parameter in sorted((*line.sets, *line.reads), key=lambda parameter: -parameter.start):
        name = (asked if parameter.asked else given)(parameter.key)
        text = text[: parameter.start] + name + text[parameter.end :]
    reads = {given(read.key) for read in line.reads if not read.asked or isinstance(read.key, str)}
    names = "+".join(sorted({given(key.key) for key in line.sets} & {name for name in reads if "<" in name}))
    return [f"#{_CONTROLS - 1}=[0*[{names}]]"] * bool(names) + [_PRINTING.sub(r"\1-", text)]
