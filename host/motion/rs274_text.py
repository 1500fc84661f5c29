"""What LinuxCNC's interpreter is given of a program: text that it cannot mistake, or a refusal.

Each line is given its number as N word, so that moves know theirs. Where a line changes the tool and its
compensation the interpreter forgets the new tool's length until Z moves: as both are done in turn, such a
line is given as two. Comments of the program that print become plain ones. Numbered parameters are given as
named ones: of these it tells when one is read that has no value yet, where it would take a number for what
the last program left, or for 0.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import Place
from triaxis.host.motion.expression import ARGUMENTS, NO_VALUE
from triaxis.host.motion.gcode import AFTER_THE_END, BOTH_PLACES
from triaxis.host.motion.interpreter import RESTORES
from triaxis.host.motion.machine import Machine
from triaxis.host.motion.program_text import COMMENT, LONGEST_LINE, lines_of

_NUMBER = re.compile(r"^(\s*/?)\s*(?:[Nn]\s*\d+)?", re.ASCII)
# What the interpreter would take for 0, in words that say that it is needed: of lines without blanks.
_ANY_WORD, _END = r"[gm][\[#]", r"(\.0*)?(?![\d.])"
# None of the patterns below knows a number that is written so, and nobody needs to.
_FUNCTION = "abs|acos|asin|atan|cos|exists|exp|fix|fup|ln|round|sin|sqrt|tan"
_SIGNED = re.compile(rf"[gml](?:[+-]|(?:{_FUNCTION})\[)")
# It rounds these: what no pattern shows may be any of them.
_NEARLY = re.compile(r"g\d*\.\d0*[1-9]|[ml]\d*\.0*[1-9]")
_MACHINE_WORDS = re.compile(rf"g0*(53|28|30){_END}|{_ANY_WORD}")
# With L of a kind, wherever on the line that stands.
_SETS = re.compile(rf"g0*10{_END}|{_ANY_WORD}")
_HOMES = {name: re.compile(rf"g0*{name[1:]}{_END}|{_ANY_WORD}") for name in ("G28", "G30")}
_LENGTH_WORDS = re.compile(rf"g0*43(\.0*[12]?)?(?!\d)|{_ANY_WORD}")
_RADIUS_WORDS = re.compile(rf"g0*4[12](\.0*1?)?(?!\d)|{_ANY_WORD}")
_ANY_HOME, _BY_LINEAR = re.compile(rf"g0*(28|30){_END}"), re.compile(r"(?!.*[abc])(?=.*[xyz]).*")
_CHANGES, _COMPENSATES = (re.compile(rf"{word}{_END}|{_ANY_WORD}") for word in ("m0*6", "g0*4[39]"))
_LOADING = re.compile(rf"m0*61{_END}|m[\[#]")
_SET_CONTROLS = re.compile(r"#(\d+)=")
# Lines of a program that is called by M98, which begin with its number; and what ends one.
_NUMBERED_PROGRAM, _ENDS_PROGRAM = re.compile(r"(?:n\d+)?o\d+$"), re.compile(rf"m0*99{_END}|m[\[#]")
_ENDS_ALL = re.compile(rf"m0*(2|30){_END}")
_RESTORING, _SHIFTING = re.compile(r"g0*92\.30*(?!\d)|g[\[#]"), re.compile(rf"g0*(92(\.10*)?|52){_END}")
_TURNS = re.compile(rf"g0*10{_END}|{_ANY_WORD}")
_READ_NAME = re.compile(r"#<[^>]*>(?!=)")
_READ, _SET_NAME = re.compile(r"#(\d+|<[^>]*>)(?!\d*=)"), re.compile(r"#(<[^>]*>)=")
# From which number on parameters are the control's; in a line without blanks, and in any line.
_CONTROLS, _NUMBERED = 5000, re.compile(r"#((?:\s*\d)+)", re.ASCII)
# Whether a name exists that all programs share hangs on those before; where it has a value it does.
_WORD_EXISTS = r"\s*".join("exists")
_EXISTS = re.compile(rf"{_WORD_EXISTS}\s*\[\s*(#\s*<\s*_[^>]*>)\s*\]", re.IGNORECASE)
# A number always does.
_EXISTS_NUMBER = re.compile(rf"{_WORD_EXISTS}\s*\[\s*#([\d\s]*)\]", re.IGNORECASE | re.ASCII)
_FLOW = r"(?:n\d+)?o(?:<[^>]*>|\d+)"
_BOUNDS, _NO_BOUNDS = re.compile(rf"{_FLOW}(sub|endsub)"), re.compile(rf"^/{_FLOW}(sub|endsub)")
# An O word whose name is neither of letters nor plain digits.
_COMPUTED = re.compile(r"^/?(?:n\d+)?o(?!<[^>]*>|\d+(?:[a-z]|$))")
_NAME = re.compile(r"#<[^>]*>")
_FANUC = re.compile(rf"m(0*98{_END}|[\[#])")
_WHOSE = "an argument, in a program with M98 and O sub: of which call is not known: use #31 or more"
_INDIRECT = re.compile(r"#(?![\d<])|#\d+\.")
_ANY_FLOW = re.compile(r"/?(?:n\d+)?o")
_NESTS = re.compile(r"(?:n\d+)?o(<[^>]*>|\d+)((?:end)?(?:sub|if|while|repeat)|do)")
_BEGINS_WITH_NUMBER, _BESIDE_PERCENT = re.compile(r"^/?[\d.]"), re.compile(r".%|%.")
_CODE_IN_NAME = re.compile(r"<[^>]*[#\[\]=][^>]*>")
_CALLED, _DEFINED = re.compile(r"o(<[^>]*>|\d+|[\[#]).*?call"), re.compile(r"o(<[^>]*>|\d+)sub")
# Of names that begin with _, those that mean the same on each machine; the others are the control's.
_NAMES = ("x", "y", "z", "metric", "imperial", "absolute", "incremental")
# Those of the control that no program can set, though a line may try (LinuxCNC's manual, G code: overview).
_SYSTEM_NAMES = (
    "vmajor vminor line motion_mode plane ccomp ijk_absolute_mode lathe_diameter_mode lathe_radius_mode "
    "inverse_time units_per_minute units_per_rev coord_system tool_offset retract_r_plane retract_old_z "
    "spindle_rpm_mode spindle_css_mode spindle_on spindle_cw mist flood speed_override feed_override "
    "adaptive_feed feed_hold feed rpm a b c u v w abs_x abs_y abs_z abs_a abs_b abs_c abs_u abs_v abs_w "
    "current_tool current_pocket selected_tool selected_pocket value value_returned task call_level "
    "remap_level"
)
_OTHERS = frozenset(f"<_{name}>" for name in _SYSTEM_NAMES.split())
_MEANT = frozenset(f"<_{name}>" for name in _NAMES)
# Words without expressions, after / and N; of these what changes the tool, and what sets compensation.
_VALUE = r"(?:[+-]?[\d.]+|#\d+|#<[^>]*>)"
_PLAIN = re.compile(rf"(\s*/?\s*)(?:[Nn]\s*\d+)?((?:\s*[A-Za-z]\s*{_VALUE})*)\s*", re.ASCII)
_WORD = re.compile(rf"[A-Za-z]\s*{_VALUE}", re.ASCII)
_CHANGE = re.compile(r"[Tt].*|[Mm]\s*0*6", re.ASCII)
_COMPENSATION = re.compile(r"[Gg]\s*0*4(3|9)", re.ASCII)
_PRINTING = re.compile(r"([(;]\s*)(?=print|debug|log|probe)", re.IGNORECASE)
_PERCENT = re.compile(r"\s*(?:N\d+\s*)?%\s*")
# What the interpreter says of a name without a value: the name, its number where it stands for one, the line.
_UNSET = re.compile(r"Named parameter #(<(?:_p+(\d+))?[^>]*>) not defined\s*(?:N(\d+) )?")


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
    lines = lines_of(path)
    turns, files = _refuse_unknown(path, lines, machine)
    named = _with_names({path: lines, **{file: lines_of(file) for file in files}})
    named = {file: [_PRINTING.sub(r"\1-", line) for line in text] for file, text in named.items()}
    parted = [_split(line) for line in named.pop(path)]
    numbered = [
        _NUMBER.sub(rf"\g<1>N{count} ", line, count=1) if line.strip() else line
        for count, parts in enumerate(parted, 1)
        # What another file holds has no numbers: a comment that is printed tells that it is called.
        for line in (*(["(MSG,)"] if _CALLED.search(_bare(parts[0])) else []), *_read_before(parts), *parts)
    ]
    called = {
        file.name: [
            _NUMBER.sub(r"\g<1>", part, count=1) for line in text for part in (*_read_before([line]), line)
        ]
        for file, text in named.items()
    }
    for file, text in {path: numbered, **{path.parent / name: text for name, text in called.items()}}.items():
        if long := next((line for line in text if len(line.encode()) > LONGEST_LINE), None):
            why = "with its number, and names for parameters, longer than it reads: break the line"
            raise InputError(f"{file}: '{long[:20]}': {why}")
    return Prepared(
        [line for line in numbered if _PERCENT.fullmatch(line) is None],
        called,
        frozenset(count for count, parts in enumerate(parted, 1) if len(parts) > 1),
        turns,
        any(line.lstrip().startswith("/") for line in lines),
    )


def unset(path: Path, errors: str) -> InputError | None:
    """Return what is to be said where the interpreter tells of a parameter without a value."""
    found = _UNSET.search(errors)
    if found is None:
        return None
    name = f"#{found[2] or found[1]}"
    return (
        Place(path, int(found[3])).error(name, NO_VALUE)
        if found[3]
        else InputError(f"{path}: {name} {NO_VALUE}")
    )


def _bare(line: str) -> str:
    """Return a line without comments and blanks, which the interpreter passes over within numbers, too."""
    return "".join(COMMENT.sub("", line).split()).lower()


def _refuse_unknown(path: Path, lines: Sequence[str], machine: Machine) -> tuple[bool, list[Path]]:
    """Raise InputError at words for which the interpreter would take what it is not told for 0, and others
    that it mistakes; return whether any line may turn a system, and the files that are called.
    """
    tools = machine.tools.values()
    no_frame, no_lengths = (
        "G54" not in machine.offsets,
        not tools or any(tool.length is None for tool in tools),
    )
    frame = "needs machine coordinates: give the offset of G54 in a machine file"
    lengths = "needs the length of each tool: give all in a machine file"
    needed = [
        (_MACHINE_WORDS, no_frame, frame),
        *((words, name not in machine.homes, f"goes home: give {name} in a machine file")
          for name, words in _HOMES.items()),
        (_LENGTH_WORDS, no_lengths, lengths),
        (_RADIUS_WORDS, not tools or any(tool.diameter is None for tool in tools),
         "needs the diameter of each tool: give parts with diameters in a machine file"),
        (_LOADING, True, "its tool is not known to the interpreter: change tools with M6"),
        (_NEARLY, True, "is rounded to another word: write that"),
        (_BEGINS_WITH_NUMBER, True, "begins its line without a letter: correct it"),
        (_BESIDE_PERCENT, True, "'%' stands alone on its line: remove it"),
        (_CODE_IN_NAME, True, "a name with #, [ or = in it: take another"),
        (_INDIRECT, True, "may be any parameter: name it, or leave --reader out"),
        (_COMPUTED, True, "an O word whose name is computed: name it, or leave --reader out"),
        (_NO_BOUNDS, True, "a subroutine that may be left out: begin its lines without /"),
    ]  # fmt: skip
    set_by = {
        "2": (no_frame, frame), "1": (no_lengths, lengths),
        "11": (not {"G54", "G59.3"} <= machine.offsets.keys(),
               "sets a tool by the zero of G59.3: give the offsets of G54 and G59.3 in a machine file"),
    }  # fmt: skip
    files, texts = [path], {path: [_bare(line) for line in lines]}
    for file in files:
        files += [more for more in _called(file, texts[file]) if more not in texts]
        texts |= {more: list(map(_bare, lines_of(more))) for more in files if more not in texts}
    set_names = {name for text in texts.values() for line in text for name in _SET_NAME.findall(line)}
    for file, text in texts.items():
        shift_known = called = any_flow = False
        for count, line in enumerate(text, 1):
            words = _NAME.sub("#", line)
            if match := _SIGNED.search(re.sub("<[^>]*>", "<>", words)):
                why = "a number with a sign, or of a function, that says what is done: write the number alone"
                raise Place(file, count).error(match[0], why)
            for key in map(int, _SET_CONTROLS.findall(line)):
                if key >= _CONTROLS:
                    why = "sets what is the control's: say it by G10, or in a machine file"
                    raise Place(file, count).error(f"#{key}", why)
            if _RESTORING.search(words) and not shift_known:
                raise Place(file, count).error("G92.3", RESTORES)
            any_flow |= _ANY_FLOW.match(line) is not None
            # What a branch, a call or / may leave out says nothing.
            plain = file == path and not any_flow and line[:1] != "/"
            shift_known |= plain and _SHIFTING.search(words) is not None
            called |= (any_flow and "call" in re.sub("<[^>]*>", "<>", line)) or file != path
            if file != path and _CHANGES.search(line) and _COMPENSATES.search(line):
                why = "with a change of the tool, in a file of its own, which it mistakes: give two lines"
                raise Place(file, count).error("G43", why)
            if machine.rotary and (home := _ANY_HOME.search(line)) and not _BY_LINEAR.fullmatch(line):
                why = "turns axes to where only the machine knows: name X, Y or Z, and no other"
                raise Place(file, count).error(home[0], why)
            if match := _SETS.search(words):
                for kind, (missing, why) in set_by.items():
                    if missing and re.search(rf"l0*{kind}{_END}|l[\[#]", words):
                        raise Place(file, count).error(match[0], why)
            for pattern, missing, why in needed:
                if missing and (match := pattern.search(line)):
                    raise Place(file, count).error(match[0], why)
            for name in _READ.findall(line):
                # Of numbers up to the control's own the interpreter tells (`_with_names`).
                free = name.isdigit() and (int(name) < _CONTROLS or 5420 <= int(name) <= 5422)
                known = name in _MEANT or (name in set_names and name not in _OTHERS)
                # The last value that a subroutine has returned, of this program once it has called one.
                if not (known or free or (name == "<_value>" and called)):
                    raise Place(file, count).error(f"#{name}", NO_VALUE)
    _refuse_beginning_anew(path, texts[path])
    ends = [count for count, line in enumerate(texts[path], 1) if line == "%"]
    closed = ends[1] if len(ends) > 1 else ends[0] if ends and any(texts[path][: ends[0] - 1]) else None
    for count, line in enumerate(texts[path], 1):
        if closed is not None and count > closed and line:
            raise Place(path, count).error(line[:20], AFTER_THE_END)
    return any(_TURNS.search(line) for text in texts.values() for line in text), files[1:]


def _refuse_beginning_anew(path: Path, lines: Sequence[str]) -> None:
    """Raise InputError where M99 may end the program itself, which a control then runs again for ever."""
    ended = called = False
    # What is open: a branch, a loop, or a subroutine, by its name.
    within = dict[str, str]()
    for count, line in enumerate(lines, 1):
        if match := _NESTS.match(line):
            name, does = _plain(match[1]), match[2]
            if does[:3] == "end" or (does == "while" and within.get(name) == "do"):
                within.pop(name, None)
            else:
                within[name] = does
        # What a branch or / may leave out ends nothing.
        plain = not within and line[:1] != "/"
        ended |= plain and _ENDS_ALL.search(_NAME.sub("#", line)) is not None
        # A number that stands before the program's end may be its own.
        called |= ended and _NUMBERED_PROGRAM.match(line) is not None
        if not called and (match := _ENDS_PROGRAM.search(_NAME.sub("#", line))):
            why = "begins the program anew, for ever: end it with M2, and begin what M98 calls after that"
            raise Place(path, count).error(match[0], why)


def _with_names(texts: Mapping[Path, Sequence[str]]) -> dict[Path, list[str]]:
    """Return files with names in place of the numbers of parameters, but for arguments of subroutines.

    Raises InputError where it is not known whose arguments numbers are.
    """
    if not any("#" in line for text in texts.values() for line in text):
        return {file: list(text) for file, text in texts.items()}
    bare = {file: list(map(_bare, text)) for file, text in texts.items()}
    every = [line for text in bare.values() for line in text]
    prefix = "_p"
    while any(f"<{prefix}" in line for line in every):
        prefix += "p"
    # M98 calls lines that stand in no subroutine, with the arguments of whoever calls.
    unclear = any(map(_FANUC.search, every)) and any(map(_BOUNDS.match, every))
    named = dict[Path, list[str]]()
    for file, text in texts.items():
        within, lines = False, list[str]()
        for count, (line, bare_line) in enumerate(zip(text, bare[file], strict=True), 1):
            bound = _BOUNDS.match(bare_line)
            within |= bound is not None and bound[1] == "sub"
            numbers = map(int, _NUMBERED.findall(bare_line)) if unclear and not within else ()
            if any(1 <= number <= ARGUMENTS for number in numbers):
                raise Place(file, count).error("#", _WHOSE)
            lines.append(_with_name(line, prefix, within))
            within &= bound is None or bound[1] == "sub"
        named[file] = lines
    return named


def _with_name(line: str, prefix: str, within: bool) -> str:
    """Return a line with names; ``within`` a subroutine, whose arguments keep their numbers."""

    def name(match: re.Match[str]) -> str:
        key = int("".join(match[1].split()))
        kept = key >= _CONTROLS or (within and key <= ARGUMENTS) or not key
        return match[0] if kept else f"#<{prefix}{key}>"

    def exists(match: re.Match[str]) -> str:
        # Number 0 does not.
        return "[1]" if int("".join(match[1].split()) or 0) else match[0]

    at, parts = 0, list[str]()
    for comment in (*COMMENT.finditer(line), None):
        code = line[at : comment.start()] if comment else line[at:]
        code = _EXISTS_NUMBER.sub(exists, _EXISTS.sub(r"[1+0*\1]", code))
        parts += [_NUMBERED.sub(name, code), comment[0] if comment else ""]
        at = comment.end() if comment else len(line)
    return "".join(parts)


def _read_before(lines: Sequence[str]) -> list[str]:
    """Return a line that reads what others, given for one, both set and read, where there is any.

    On its own line a name that is set has a value already: 0. The number in it is no parameter's any more.
    """
    bare = "".join(map(_bare, lines)) if any("=" in line for line in lines) else ""
    names = {f"#{name}" for name in _SET_NAME.findall(bare)} & set(_READ_NAME.findall(bare))
    if not names:
        return []
    return [f"{'/' * bare.startswith('/')}#{_CONTROLS - 1}=[0*[{'+'.join(sorted(names))}]]"]


def _split(line: str) -> list[str]:
    """Return a line; the change of the tool by itself, and the rest, where it sets compensation, too."""
    begin, words = _PLAIN.fullmatch(COMMENT.sub("", line)), list[str]()
    if begin is not None:
        words = _WORD.findall(begin[2])
    changing = [word for word in words if _CHANGE.fullmatch(word)]
    if not any(_CHANGE.fullmatch(word) and word[0] in "Mm" for word in words) or not any(
        _COMPENSATION.fullmatch(word) for word in words
    ):
        return [line]
    assert begin is not None
    return [f"{begin[1]}{' '.join(part)}" for part in (changing, [w for w in words if w not in changing])]


def _plain(name: str) -> str:
    """Return a subroutine's name: of digits, with < > or without, it is their number."""
    name = name.strip("<>")
    return str(int(name)) if name.isdigit() else name


def _called(path: Path, lines: Sequence[str]) -> list[Path]:
    """Return the files beside a program of subroutines that it calls and does not hold."""
    text = "\n".join(lines)
    defined, names = ({_plain(name) for name in words.findall(text)} for words in (_DEFINED, _CALLED))
    for count, line in enumerate(lines, 1):
        # It looks for a file first. M words that are computed are refused.
        if re.search(rf"m0*98{_END}", line):
            number = re.search(r"p(\d+)(?![\d.])", line)
            beside = [file for file in path.parent.glob("*.ngc") if file.stem.isdigit()]
            if taken := [file for file in beside if not number or file.stem == _plain(number[1])]:
                why = f"may call {taken[0].name}, which stands beside: rename that"
                raise Place(path, count).error("M98", why)
    if names & {"[", "#"}:
        raise InputError(f"{path}: calls a subroutine whose name is computed: name it, or leave --reader out")
    files = {name: path.parent / f"{name}.ngc" for name in sorted(names)}
    here = {name: file for name, file in files.items() if file.exists()}
    for name in here.keys() & defined:
        # A control takes what it has come by, and else the file.
        calls, bounds = (
            [count for count, line in enumerate(lines, 1) if name in map(_plain, words.findall(line))]
            for words in (_CALLED, _DEFINED)
        )
        if calls[0] < bounds[0]:
            word = name if name.isdigit() else f"<{name}>"
            raise Place(path, calls[0]).error(f"O{word}", BOTH_PLACES.format(here[name].name))
    return [file for name, file in here.items() if name not in defined]
