"""``tritest``: sets of triangle pairs with proofs, and how programs score on them."""

import argparse
import json
import shlex
import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path

from rich.console import Console

from triaxis.bench.harness import FOLDER, Findings, report
from triaxis.bench.peers.peer import Peer, PeerAbsentError, present
from triaxis.bench.tritest.cases import makers, write_set
from triaxis.bench.tritest.libraries import LIBRARIES, OURS, PAPERS, answer, named
from triaxis.bench.tritest.recheck import Family, SetError, case_of, families_of, lines_of, recheck
from triaxis.bench.tritest.scoring import KINDS, Asked, Score, Tally, read_set, rows_of, score
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import named_folder
from triaxis.host.cli.terminal import progress_bar, table
from triaxis.sim.build import built
from triaxis.sim.validity import Sources

# Of the set that is made where none is named; each set has what it was made from in its name.
_SET, _SOURCES = FOLDER / "tritest", Sources(("triaxis.bench.tritest.cases",))
LEAGUE = FOLDER / "tritest.json"
# Of each family.
_PAIRS, _SEED = 1000, 1
# Of what is printed, in columns.
_WIDTH = 100
# A league of fewer packages of others is none.
_LEAST = 8
_ABOUT_SET = "a set's folder (one of 1,000 pairs a family in build/, made where it is not there)"


def add_make(parser: argparse.ArgumentParser) -> None:
    """Add what `tritest make` takes."""
    parser.description = (
        "Make a set: pairs of every family, each with its exact distance and the proof of it."
    )
    parser.add_argument("folder", type=named_folder, metavar="SET", help="the folder to write to")
    parser.add_argument("--pairs", type=int, default=_PAIRS, metavar="N", help=f"of each family ({_PAIRS})")
    parser.add_argument("--seed", type=int, default=_SEED, help=f"what all pairs follow from ({_SEED})")
    parser.set_defaults(run=lambda options: _make(options.folder, options.pairs, options.seed))


def _make(folder: Path, pairs: int, seed: int) -> int:
    if pairs < 1 or seed < 0:
        raise InputError(f"--pairs {pairs}, --seed {seed}: at least 1, and at least 0")
    families = _written(folder, pairs, seed)
    print(f"{sum(family.pairs for family in families):,} pairs of {len(families)} families: {folder}")
    return DONE


def _written(folder: Path, pairs: int, seed: int) -> list[Family]:
    with progress_bar("pairs proven", pairs * len(makers())) as progress:
        return write_set(folder, pairs, seed, progress)


def _own_set() -> Path:
    """Return the set in build/ of the families as they are now, made where it is not there."""

    def make(folder: Path) -> None:
        _written(folder, _PAIRS, _SEED)

    return built(_SET, _SOURCES.files(), (str(_PAIRS), str(_SEED)), make)


def add_recheck(parser: argparse.ArgumentParser) -> None:
    """Add what `tritest recheck` takes."""
    parser.description = (
        "Prove each pair of a set again, by its own numbers alone. The file bench/tritest/recheck.py does it "
        "anywhere, with nothing but Python."
    )
    parser.add_argument("folder", type=Path, metavar="SET", help="the set's folder")
    parser.set_defaults(run=_recheck)


def _recheck(options: argparse.Namespace) -> int:
    try:
        return recheck(options.folder)
    except SetError as error:
        raise InputError(str(error)) from error


def add_run(parser: argparse.ArgumentParser) -> None:
    """Add what `tritest run` takes."""
    parser.description = (
        "Score a program on a set. By --command it is any that answers a line of 18 whole numbers (x y z of "
        "A1 A2 A3 B1 B2 B3) by a line: 1 where the triangles have a point in common, 0 where not, ? where it "
        "cannot tell."
    )
    who = parser.add_mutually_exclusive_group(required=True)
    who.add_argument("--library", metavar="NAME", help=f"one of {', '.join(LIBRARIES)}")
    who.add_argument("--command", metavar="COMMAND", help="a program with its arguments, as a shell has them")
    parser.add_argument("folder", type=Path, nargs="?", metavar="SET", help=_ABOUT_SET)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures, and which pairs failed")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.library is not None:
        try:
            named(options.library).version()
        except PeerAbsentError as error:
            raise InputError(f"{options.library}: {error}") from error
        command = _answering(options.library)
    else:
        command = _words(options.command)
    asked = _asked(options.folder)
    with progress_bar("families", len(asked)) as progress:
        found = score(command, asked, progress)
    rows = table(None, ("pairs of", "pairs", "colliding", "missed", "false alarms", "unanswered"))
    for name, tally in rows_of(found):
        rows.add_row(name, *(f"{count:,}" for count in vars(tally).values()))
    Console(width=_WIDTH).print(rows)
    for name, how in found.ended.items():
        print(f"{name}: {how}")
    if found.first_error and any(tally.unanswered for tally in found.kinds.values()):
        print(f"its first error: {found.first_error}")
    if options.json:
        content = {"command": shlex.join(command), "passed": found.all_right, **asdict(found)}
        write_whole(options.json, json.dumps(content) + "\n")
    print("PASSED: every pair is right" if found.all_right else f"FAILED: {_failed(found)}")
    return DONE if found.all_right else NO


def _words(text: str) -> list[str]:
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise InputError(f"--command {text}: {error}: correct it") from error
    if not words:
        raise InputError("--command: names no program")
    return words


def _answering(name: str) -> list[str]:
    begin = "import sys; from triaxis.host.cli import tritest; sys.exit(tritest())"
    return [sys.executable, "-c", begin, "answer", name]


def _asked(folder: Path | None) -> list[Asked]:
    return read_set(folder or _own_set())


def _failed(found: Score) -> str:
    total = sum(tally.pairs for tally in found.kinds.values())
    missed, alarms, none = (
        sum(getattr(tally, name) for tally in found.kinds.values())
        for name in ("missed", "false_alarms", "unanswered")
    )
    return f"{missed:,} missed, {alarms:,} false alarms, {none:,} unanswered, of {total:,}"


def add_answer(parser: argparse.ArgumentParser) -> None:
    """Add what `tritest answer` takes."""
    parser.description = "Answer pairs on standard input for a library, as `tritest run` asks them."
    parser.add_argument("library", metavar="NAME", help=f"one of {', '.join(LIBRARIES)}")
    parser.set_defaults(run=_answer)


def _answer(options: argparse.Namespace) -> int:
    answer(named(options.library), sys.stdin, sys.stdout)
    return DONE


def add_show(parser: argparse.ArgumentParser) -> None:
    """Add what `tritest show` takes."""
    parser.description = "Print a pair of a set: its vertices, its distance, the proof."
    parser.add_argument("pair", metavar="FAMILY:NUMBER", help="as reports name it")
    parser.add_argument("folder", type=Path, nargs="?", metavar="SET", help=_ABOUT_SET)
    parser.set_defaults(run=_show)


def _show(options: argparse.Namespace) -> int:
    name, _, number = options.pair.rpartition(":")
    folder = options.folder or _own_set()
    try:
        families = {family.name: family for family in families_of(folder)}
        if name not in families:
            raise InputError(f"{options.pair}: no such family: one of {', '.join(families)}")
        lines = dict(lines_of(folder, families[name]))
        if not number.isdecimal() or int(number) not in lines:
            raise InputError(f"{options.pair}: its pairs are 1..{len(lines)}")
        case = case_of(lines[int(number)])
    except SetError as error:
        raise InputError(str(error)) from error
    for label, triangle, weights in (("A", case.a, case.weights_a), ("B", case.b, case.weights_b)):
        for k, (vertex, weight) in enumerate(zip(triangle, weights, strict=True), 1):
            print(f"{label}{k}  ({', '.join(map(str, vertex))})  weight {weight} / {sum(weights)}")
    p, q = case.distance
    print(f"distance {p} / {q}" + ("" if case.collides else f", shown by the axis {case.axis}"))
    print("they collide" if case.collides else "they are clear of each other")
    return DONE


def add_league(parser: argparse.ArgumentParser) -> None:
    """Add what `tritest league` takes."""
    parser.description = (
        "Score every library that is installed (`make peers`), the published tests in single and double "
        f"precision, and this project's own; write {LEAGUE.name} to build/bench."
    )
    parser.add_argument("folder", type=Path, nargs="?", metavar="SET", help=_ABOUT_SET)
    parser.set_defaults(run=lambda options: report(LEAGUE, partial(_league, options.folder)))


def _league(folder: Path | None) -> Findings:
    asked = _asked(folder)
    there, presence = present(tuple(LIBRARIES.values()))
    names = {library.name: name for name, library in LIBRARIES.items()}
    scores: dict[str, Score] = {}
    with progress_bar("families", len(there) * len(asked)) as progress:
        for library, _ in there:
            scores[library.name] = score(_answering(names[library.name]), asked, progress)
    return league_of(
        asked, there, scores, [f"{one.name}: {one.why_absent}" for one in presence if one.why_absent]
    )


def league_of(
    asked: list[Asked], there: list[tuple[Peer, str]], scores: dict[str, Score], notes: list[str]
) -> Findings:
    """Return what is shown and written of a league: ours must be right, and answer what fits 32 bits."""
    pairs = sum(one.family.pairs for one in asked)
    problems = [
        f"{one.name}: {_failed(scores[one.name])}"
        for one in OURS
        if any(scores[one.name].wrong) or scores[one.name].kinds["float32"].unanswered
    ]
    for one, _ in there:
        found = scores[one.name]
        if one not in OURS and found.kinds["float32"].unanswered == found.kinds["float32"].pairs:
            why = found.first_error or "no error told"
            problems.append(f"{one.name}: answers none of the pairs that float32 holds: {why}")
    if (others := sum(one not in (*OURS, *PAPERS) for one, _ in there)) < _LEAST:
        problems.append(f"{others} packages of others: {_LEAST} are wanted (`make peers`)")
    kinds = (f"{kind}: missed, false, unanswered" for kind in KINDS)
    title = "in percent; float32, float64: proper triangles that it holds; degenerate: segments, points"
    rows = table(title, ("library", "version", *kinds, "families all right"), text=2)
    best = sorted(there, key=lambda one: scores[one[0].name].place)
    for library, found in best:
        one = scores[library.name]
        right = sum(tally.right == tally.pairs for tally in one.families.values())
        rows.add_row(
            library.name, found, *(_shares(one.kinds[kind]) for kind in KINDS), f"{right} of {len(asked)}"
        )
    content = {
        "pairs": pairs,
        "families": [asdict(one.family) for one in asked],
        "libraries": [
            {"name": library.name, "version": found, "call": library.call, **asdict(scores[library.name])}
            for library, found in best
        ],
    }
    summary = f"{len(there)} libraries on {pairs:,} pairs of {len(asked)} families"
    return Findings("tritest league", summary, problems, content, [rows], notes=notes)


def _shares(tally: Tally) -> str:
    clear = tally.pairs - tally.colliding
    parts = ((tally.missed, tally.colliding), (tally.false_alarms, clear), (tally.unanswered, tally.pairs))
    return "  ".join("0" if not count else f"{100 * count / of:.2g}" for count, of in parts)
