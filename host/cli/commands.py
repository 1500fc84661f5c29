"""Which commands there are: their groups, their modules, what their exit codes mean, what they write.

A command's module is imported when the command is run, or asked for its own help.
"""

import argparse
import json
import os
import re
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from inspect import getdoc
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import remove_older, write_whole


class Answer(NamedTuple):
    """A file that a command leaves its answer in: the endings it may have, what is in it until then, and how
    an older one begins (99 bytes): a file of anything else is not to be lost.
    """

    endings: tuple[str, ...] = ()
    before: str | None = None
    older: re.Pattern[bytes] | None = None


class Command(NamedTuple):
    """A command: its help, its module, what exit codes 0 and 1 mean, the files it writes by option.

    The module's ``add_arguments``, or ``add_examples`` of ``scene examples``, adds its arguments, and sets as
    default ``run`` what runs it.
    """

    about: str
    module: str
    codes: tuple[str, ...] = ("passed", "failed")
    answers: Mapping[str, Answer] = {}


_JSON, _ARRAY = re.compile(rb"\s*(\{[^\0]*)?$"), re.compile(rb"\x93NUMPY|$")
_REPORT = {"--json": Answer(before='{\n  "verdict": "unknown"\n}\n', older=_JSON)}
_PICTURE = {"--picture": Answer(endings=(".png", ".svg"))}
_MESHES = "decide whether two STL meshes come within a clearance"

COMMANDS = {
    "check": Command(_MESHES, "host.cli.check", ("clear", "near"), _REPORT),
    "path": Command(
        "decide whether a tool stays clear of a workpiece along a G-code program", "host.cli.path",
        ("clear", "near"), _REPORT | _PICTURE,
    ),
    "watch": Command(
        "permit a machine to go through a program without a stop", "host.cli.watch",
        ("to the end", "near, or ended before"), _REPORT | _PICTURE,
    ),
    "verdict": Command(
        "decide pairs of triangles from a .npy file", "host.cli.verdict", ("decided",),
        {"--out": Answer(older=_ARRAY)},
    ),
    "board check": Command(_MESHES, "host.cli.board", ("clear", "near"), _REPORT),
    "board status": Command("print what the board is, and its status", "host.cli.board", ("done",)),
    "board simulate": Command("serve a simulated board at a pseudo-terminal", "host.cli.board", ("done",)),
    "scene examples": Command(
        "write example meshes: a tool and a vise with a workpiece, in several positions", "host.cli.scene",
        ("written",),
    ),
    "scene advise": Command(
        "choose the coordinate width for meshes, a working volume and a clearance", "host.cli.scene",
        ("a width is advised", "none fits"), {"--json": Answer(older=_JSON)},
    ),
    "sim": Command("run one test on the simulated core, mesh engine or board", "verif.commands.sim"),
    "regress run": Command("run a regression on dvsim, or go on with it", "verif.commands.regress"),
    "regress four-state": Command(
        "run the tests on the pins with values that may be unknown, in Icarus Verilog",
        "verif.commands.regress", ("nothing is unknown, and nothing wrong", "something is"),
    ),
    "regress forget": Command("forget the seeds that failed before", "verif.commands.regress", ("done",)),
    "regress shrink": Command(
        "make failing pairs small, draw them, keep them as regression cases", "verif.commands.regress",
        ("shrunk", "no pair fails on the bare core"),
    ),
    "results": Command("show what became of all runs over time", "verif.commands.results", ("done",)),
    "prove formal": Command(
        "prove streams, axes, widths, certificates, skipping, memories, runs, go, for all inputs",
        "verif.commands.prove", ("all hold", "one does not"),
    ),
    "prove theorem": Command(
        "have Coq check why the 32 axes decide, and print what that assumes", "verif.commands.prove",
        ("every theorem is proved", "one is not"),
    ),
    "prove netlist": Command(
        "run the tests on the synthesised design, and prove modules equal to their netlists",
        "verif.commands.prove", ("no difference, and every proof holds", "something differs"),
    ),
    "prove exhaustive": Command(
        "run every ordered pair of triangles on a small grid", "verif.commands.prove"
    ),
    "prove faults": Command(
        "put known faults into the design, and see each caught", "verif.commands.inject",
        ("all caught", "not"),
    ),
    "prove mutate": Command(
        "put small faults into dut/, and see each noticed by a test or shown to change nothing",
        "verif.commands.inject", ("every mutant killed or equivalent", "not"),
    ),
    "prove power": Command(
        "let a sample of mutants meet every test: which notices which, and the fewest that notice all",
        "verif.commands.inject", ("each test came to a verdict on each", "one did not"),
    ),
    "prove certificates": Command(
        "see that no mutant of what the core alone has gets a wrong clear through certificates",
        "verif.commands.inject", ("each is near, with a fault", "one comes through"),
    ),
    "prove upsets": Command(
        "invert bits of the running board, and count what comes of it", "verif.commands.inject",
        ("nothing dangerous with the measures, and something without", "not"),
    ),
    "coverage plan": Command(
        "print the testplan and check that nothing is missing in it", "verif.commands.coverage",
        ("clean", "refused"),
    ),
    "coverage code": Command(
        "measure line, branch, expression and toggle coverage of dut/", "verif.commands.coverage",
        ("all covered", "not"),
    ),
    "coverage page": Command(
        "add up the functional coverage of runs, and show each bin", "verif.commands.coverage",
        ("written",), {"--out": Answer((".html",))},
    ),
    "coverage export": Command(
        "write stored coverage as an lcov tracefile and as UCIS XML, requirements as ReqIF",
        "verif.commands.coverage", ("written",), dict.fromkeys(("--lcov", "--ucis", "--reqif"), Answer()),
    ),
    "signoff": Command(
        "simulate, measure, prove, account for every mutant, and give a verdict", "verif.commands.signoff"
    ),
    "evidence": Command(
        "pack a sign-off with its sources, witnesses, and what verifies them anywhere",
        "verif.signoff.archive", ("written",), {"--out": Answer()},
    ),
    "bench error": Command(
        "measure run time against error, also of other packages", "bench.error.report",
        ("everything demanded is reached", "something is not"),
    ),
    "bench stress": Command(
        "turn inputs from easy to impossible, and count wrong answers", "bench.stress.report",
        ("the core is right everywhere, and its no-miss mode within its band", "not"),
    ),
    "bench sim": Command(
        "measure the speed of the simulations", "bench.speed",
        ("measured",),
    ),
    "bench mesh": Command(
        "count what whole scenes cost the mesh engine", "bench.mesh_cycles",
        ("all bounds reached and all scenes right", "not"),
    ),
    "bench path": Command(
        "check a program of 100,000 moves, and ask others about continuous motion", "bench.paths.report",
        ("what is clear is said to be, and nothing planted is missed", "not"),
    ),
    "bench follow": Command(
        "supervise a moving tool on the simulated board, and plant collisions", "bench.paths.supervised",
        ("no false stop, nothing missed, every stop in time", "not"),
    ),
    "bench programs": Command(
        "count the G-code programs of a folder that are read, and say why others are not",
        "bench.paths.reading", ("as many are read as must be", "fewer"),
    ),
    "bench skipping": Command(
        "measure what skipping saves, and compare it with other broad phases", "bench.skipping.report",
        ("all bounds reached and all answers right", "not"),
    ),
    "tritest make": Command(
        "make pairs of triangles of every family, each with its distance and the proof of it",
        "bench.tritest.command", ("written",),
    ),
    "tritest recheck": Command(
        "prove each pair of a set again", "bench.tritest.command", ("all proven", "not"),
    ),
    "tritest run": Command(
        "score a library, or any program, on a set", "bench.tritest.command",
        ("every pair is right", "not"), {"--json": Answer(older=_JSON)},
    ),
    "tritest answer": Command(
        "answer pairs for a library, as `tritest run` asks them", "bench.tritest.command", ("done",),
    ),
    "tritest show": Command("print a pair of a set", "bench.tritest.command", ("done",)),
    "tritest league": Command(
        "score every library that is installed", "bench.tritest.command",
        ("ours are right, and there are enough of others", "not"),
    ),
    "fpga report": Command(
        "synthesise for the XC7A100T and compare with its budget", "verif.commands.fpga",
        ("within the limits", "beyond one"),
    ),
    "fpga timing": Command(
        "route the core on a Gowin part: frequency and critical path", "verif.commands.fpga",
        ("fast enough", "too slow"),
    ),
    "fpga activity": Command(
        "count the toggles of all multipliers with and without operand gating", "bench.activity",
        ("gating saves what it must", "it does not"),
    ),
    "fpga ip": Command(
        "write a block as a component: IP-XACT, and for Vivado's catalogue", "verif.commands.fpga",
        ("written",),
    ),
    "fpga registers": Command(
        "make the registers of the AXI4-Lite top anew: RTL, C header, text", "verif.commands.fpga",
        ("made",),
    ),
    "fpga gate": Command(
        "say whether the stored sign-off allows a bitstream of this RTL", "verif.commands.fpga",
        ("allowed", "refused"),
    ),
    "fpga bitstream": Command(
        "build the board's bitstream with Vivado, if the sign-off allows it", "verif.commands.fpga",
        ("written", "refused: by the gate, or for timing, routing or critical warnings"),
    ),
}  # fmt: skip

GROUPS = {
    "board": "two meshes on the board, over its serial port; a simulated board",
    "scene": "example meshes; which coordinate width suits your own",
    "regress": "many tests with many seeds, and what to do with a failure",
    "prove": "proofs, every small case, and faults put in to be found",
    "coverage": "the testplan, code coverage, coverage for other tools",
    "bench": "accuracy and speed, also of other packages",
    "tritest": "pairs of triangles with proofs, to score any library on",
    "fpga": "resources, timing, activity, components, registers; the gate before a bitstream",
}

_SECTIONS = {
    "does anything come close?": ("check", "path", "watch", "verdict", "board", "scene"),
    "is the design right?": ("sim", "regress", "prove", "coverage", "signoff", "results", "evidence"),
    "how good is it, and onto the board": ("bench", "tritest", "fpga"),
}

_CODES = (
    "Exit codes: 0 done, or the answer is yes (check, path: clear; watch: to the end); 1 the answer is no\n"
    "(check, path, watch: near; others: failed); 2 bad input or a missing tool, there is no answer;\n"
    "130 interrupted."
)


class _Once(argparse.Action):
    """Stores a value; of two of an option one would be lost."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: object,
        option_string: str | None = None,
    ) -> None:  # fmt: skip
        """Keep the value."""
        assert isinstance(parser, _Parser)
        if option_string is not None and self.dest in parser.given:
            raise InputError(f"{option_string}: given twice: give it once")
        parser.given.add(self.dest)
        setattr(namespace, self.dest, values)


class _Parser(argparse.ArgumentParser):
    """Says what is wrong with the arguments in one line."""

    def __init__(self, name: str, command: Command) -> None:
        codes = "; ".join(f"{code} {meaning}" for code, meaning in enumerate(command.codes))
        super().__init__(
            prog=f"triaxis {name}",
            epilog=f"Exit codes: {codes}; 2 error, there is no answer; 130 interrupted.",
            # `remove_older_answers` knows the options by their names.
            allow_abbrev=False,
        )
        # Wherever an option takes a value.
        self.register("action", None, _Once)
        self.given = set[str]()
        # Older versions of argparse take -1e-3 for an option, and complain of a missing value.
        self._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message} (see {self.prog} --help)")


def find(words: list[str]) -> tuple[str, list[str]]:
    """Return the command's name and its arguments.

    Prints help, and ends, where that is asked for; raises InputError where no command is named.
    """
    first = words[0] if words else ""
    if first in ("-h", "--help"):
        _print_help()
    if first in COMMANDS:
        return first, words[1:]
    if first not in GROUPS:
        known = (name for names in _SECTIONS.values() for name in names)
        raise InputError(_unknown("triaxis", first, list(known)))
    second = words[1] if len(words) > 1 else ""
    if second in ("-h", "--help"):
        _print_group_help(first)
    if f"{first} {second}" not in COMMANDS:
        raise InputError(_unknown(f"triaxis {first}", second, [name for name, _ in _actions(first)]))
    return f"{first} {second}", words[2:]


def _unknown(program: str, word: str, known: list[str]) -> str:
    what = f"{word:.40}: no such command" if word else "a command is missing"
    return f"{what}: one of {', '.join(known)} (see {program} --help)"


def _actions(group: str) -> Iterator[tuple[str, Command]]:
    for name, command in COMMANDS.items():
        first, _, second = name.partition(" ")
        if second and first == group:
            yield second, command


def _print_help() -> NoReturn:
    print("usage: triaxis COMMAND ..\n")
    print("Exact triangle-collision core: verdicts on triangles and meshes, simulation, sign-off.")
    for title, names in _SECTIONS.items():
        print(f"\n{title}")
        for name in names:
            about = COMMANDS[name].about if name in COMMANDS else GROUPS[name]
            print(f"  {name:10}{about}")
            if name in GROUPS:
                print(f"{'':14}{' | '.join(action for action, _ in _actions(name))}")
    print(f"\n{_CODES}\n`triaxis COMMAND --help` tells more, as does `triaxis board check --help`.")
    raise SystemExit(0)


def _print_group_help(group: str) -> NoReturn:
    print(f"usage: triaxis {group} COMMAND ..\n\n{GROUPS[group]}\n")
    for name, command in _actions(group):
        print(f"  {name:14}{command.about}")
    print(f"\n`triaxis {group} COMMAND --help` tells more.")
    raise SystemExit(0)


def remove_older_answers(name: str, words: list[str]) -> None:
    """Remove what earlier runs left where this one will leave its answer; write unknown for a verdict.

    Raises InputError where such a file cannot be written, or is an input. Other options may still be wrong:
    whatever comes, no older answer is left.
    """
    if not {"-h", "--help"}.isdisjoint(words[: words.index("--")] if "--" in words else words):
        return
    answers = COMMANDS[name].answers
    named, others = _named(answers, words)
    wrong: list[InputError] = []
    for number, (option, value) in enumerate(named):
        also = [file for other, file in named if other != option]
        try:
            _remove_older(option, value, answers[option], others, also)
            # Of several the last alone would get an answer.
            if option in (before for before, _ in named[:number]):
                raise InputError(f"{option}: given twice: give it once")
        # The others have to go all the same.
        except InputError as error:
            wrong.append(error)
    if wrong:
        raise wrong[0]


def _remove_older(option: str, value: str, answer: Answer, others: list[str], also: list[str]) -> None:
    path = Path(value)
    if not value:
        raise InputError(f"{option}: names no file: give the file to write to, ./- where it begins with -")
    if answer.endings and path.suffix not in answer.endings:
        raise InputError(f"{value}: must end in {' or '.join(answer.endings)}")
    if any(_same(path, Path(other)) for other in others):
        raise InputError(f"{value}: is an input file: name another to write to")
    if any(_same(path, Path(other)) for other in also):
        raise InputError(f"{value}: named for two outputs: name another for one of them")
    if answer.older is not None and path.is_file() and not answer.older.match(_begin(path)):
        what = "report" if answer.older is _JSON else "answer"
        raise InputError(f"{value}: is there, and is no {what}: name another to write to")
    remove_older(path)
    if answer.before is not None:
        write_whole(path, answer.before)


def _begin(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(99)


def withdraw_yes(words: list[str]) -> None:
    """Say "unknown" in reports of a command that ended without an answer, though they say yes."""
    try:
        name, rest = find(words)
        answers = COMMANDS[name].answers
        for option, value in _named(answers, rest)[0]:
            before, path = answers[option].before, Path(value)
            if before is None or not path.is_file():
                continue
            if json.loads(path.read_bytes())["verdict"] in ("clear", "followed"):
                try:
                    write_whole(path, before)
                except InputError:
                    # A full disk has room for less.
                    path.unlink()
    # What ended the command is to be told.
    except Exception:
        return


def _named(answers: Mapping[str, Answer], words: list[str]) -> tuple[list[tuple[str, str]], list[str]]:
    """Return the files that are named for answers, each with its option, and what may be inputs.

    What begins with - names none: the parser takes some of that for a file, and some for the next option.
    """
    named: list[tuple[str, str]] = []
    others: list[str] = []
    rest = deque(words)
    while rest:
        word = rest.popleft()
        option, equals, value = word.partition("=")
        if word == "--":
            others += rest
            break
        if option in answers:
            named.append((option, value if equals or not rest or rest[0][:1] == "-" else rest.popleft()))
        else:
            others.append(value if equals and word.startswith("--") else word)
    return named, others


def _same(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other)
    except OSError:
        return os.path.realpath(one) == os.path.realpath(other)


def runner(name: str, words: list[str]) -> Callable[[], int]:
    """Import a command and parse its arguments; return what runs it."""
    parser = _Parser(name, COMMANDS[name])
    module = import_module(f"triaxis.{COMMANDS[name].module}")
    own = name.partition(" ")[2].replace("-", "_")
    add = getattr(module, f"add_{own or 'arguments'}")
    parser.description = getdoc(add)
    add(parser)
    options: Any = parser.parse_args(words)
    return lambda: options.run(options)
