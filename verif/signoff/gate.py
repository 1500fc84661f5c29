"""The gate before a bitstream: whether a stored sign-off allows the RTL that is about to be built."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from triaxis.coverage.stages import STAGES, judge, read_figures
from triaxis.coverage.waiver_upkeep import waiver_problems
from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.sim.validity import Sources
from triaxis.verif.signoff.verify import (
    ABSENT,
    BESIDE,
    PARTS,
    TAKEN,
    contradictions,
    figures,
    left_open,
)
from triaxis.verif.testbench.settings import TEST_DATA, TEST_MODULES

# What all of a sign-off comes from: all that simulates, measures, proves, judges. No page, no command
# line.
SOURCES = Sources(
    (
        "triaxis.verif.signoff.run",
        "triaxis.verif.faults.fault_tests",
        *TEST_MODULES,
        # Simulators load these besides.
        *(f"triaxis.verif.{block}.sabotage_tests" for block in ("core", "mesh", "board")),
        "triaxis.verif.upsets.upset_test",
    ),
    (
        "coverage/*.toml",
        "coverage/testplan.hjson",
        *TEST_DATA,
        "verif/faults/patches/*.patch",
        "verif/formal/rtl/*.svh",
        "verif/formal/unproved.toml",
        "verif/mutation/equivalents.toml",
        "verif/mutation/record.json",
        "verif/netlist/*.vh",
    ),
)

_SHOWN = 3
# Above all figures.
_MOST = 1 << 63


def refusals(result: Path, rtl_hash: str, environment_hash: str) -> list[str]:
    """Return why the sign-off in ``result`` does not cover that RTL; empty: it does.

    Nor does one of another environment: what was missed then may be seen now. The tools are no part of it:
    what was signed with one Verilator is as good where a bitstream is built beside another.

    `remarks` tells what else a reader should know of it, such as uncommitted changes.

    The verdict is computed again from the figures: a file that merely says "passed" opens nothing.
    """
    if not result.exists():
        return [f"{result}: no sign-off: run `make signoff`"]
    data = read_input(result)
    try:
        content = json.loads(data, object_pairs_hook=_no_key_twice)
    except (ValueError, RecursionError) as error:
        return [f"{result}: not readable ({error}): run `make signoff` again"]
    if not isinstance(content, dict):
        return [f"{result}: not a sign-off: run `make signoff` again"]
    found: list[str] = []
    signed = content.get("rtl_hash")
    for what, then, now in (
        ("for RTL", signed, rtl_hash),
        ("by the environment", content.get("environment_hash"), environment_hash),
    ):
        if then != now:
            found.append(
                f"{result}: signed off {what} {_short(then)}, this is {_short(now)}: run `make signoff`"
            )
    if content.get("passed") is not True:
        found.append(f"{result}: the sign-off did not pass")
    problems = content.get("problems")
    if not isinstance(problems, list):
        found.append(f"{result}: does not list its problems: run `make signoff` again")
    else:
        found += _first([str(problem) for problem in problems])
    found += _shortfalls(content.get("figures")) + _parts(content.get("parts"), signed, PARTS)
    found += _missing_of_whole(content, signed) if content.get("whole") is True else _failed_beside(content)
    found += _untold(content)
    # A sign-off rests on its waivers, which may have changed since.
    found += _first(waiver_problems(_waivers(content)))
    # The same from what was counted, by what looks at it in an archive.
    return found or _first([f"{result}: {line}" for line in _by_its_counts(content)])


def _by_its_counts(content: dict[str, Any]) -> list[str]:
    """Return what does not follow from what the parts of a sign-off counted, a line each.

    By what looks at it in an archive: so what opens the gate passes there.
    """
    try:
        parts, stored, beside = content["parts"], content["figures"], content["beside"]
        found = [*left_open(content, "signoff"), *contradictions(parts, content["whole"])]
        counted = figures(parts)
        absent = {name.replace("_", " ") for name, part in beside.items() if set(part) == {"absent"}}
        absent |= {proof["name"] for proof in parts["proofs"]["proofs"] if proof["result"] == ABSENT}
        untold = absent - {line.partition(":")[0] for line in content["exceptions"]}
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        return [f"{type(error).__name__}: {error}: run `make signoff` again"]
    found += [f"{name}: absent, and no exception" for name in sorted(untold)]
    found += [
        f"{name}: {counted.get(name)} by what was counted, {stored.get(name)} in the file"
        for name in sorted(counted.keys() | stored.keys())
        if counted.get(name) != stored.get(name)
    ]
    if (set(parts), set(beside), content["stage"]) != (set(PARTS), set(BESIDE), STAGES[-1]):
        found.append("other parts, or another stage, than those of a sign-off that passed")
    if type(content["whole"]) is not bool:
        found.append("does not say whether it is a whole one")
    return found


def _no_key_twice(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len(found := dict(pairs)) != len(pairs):
        raise ValueError("a key stands twice")
    return found


def remarks(result: Path) -> list[str]:
    """Return what to know of a sign-off that opens the gate, a line each."""
    content = json.loads(read_input(result))
    found = [f"signed off without {exception}" for exception in content.get("exceptions", [])]
    mutation = content["parts"]["mutation"]
    for key, what in TAKEN:
        if mutation[key] and not any(line.startswith(what) for line in content.get("exceptions", [])):
            found.append(f"signed off without {mutation[key]} {what}, which are as recorded")
    if content.get("whole") is True:
        found.append("signed off as a whole: nothing that may be absent otherwise was absent")
    if content.get("git_clean") is not True:
        found.append("signed off from a checkout with uncommitted changes, or outside git")
    return found


def _short(hash_: Any) -> str:
    return hash_[:12] if isinstance(hash_, str) else "of unknown hash"


def _first(lines: list[str]) -> list[str]:
    more = [f".. and {len(lines) - _SHOWN} more"] if len(lines) > _SHOWN else []
    return lines[:_SHOWN] + more


def _is_figure(value: Any, most: int) -> bool:
    """Return whether a value can be a figure: a number from 0 on, or null."""
    if isinstance(value, bool) or not isinstance(value, int | float | None):
        return False
    return value is None or 0 <= value <= most


def _missing_of_whole(content: dict[str, Any], signed: Any) -> list[str]:
    """Return what a sign-off that says it is a whole does not hold."""
    parts = held if isinstance(held := content.get("parts"), dict) else {}
    proofs, mutation = (
        part if isinstance(part := parts.get(name), dict) else {} for name in ("proofs", "mutation")
    )
    found = [f"signed off as a whole, but without {line}" for line in proofs.get("exceptions") or []]
    if [mutation.get(key, 1) for key in ("sample", "recorded", "entries_recorded")] != [None, 0, 0]:
        found.append("signed off as a whole, but not every mutant was played")
    return found + _parts(content.get("beside"), signed, BESIDE)


def _failed_beside(content: dict[str, Any]) -> list[str]:
    """Return which results that stand beside a sign-off failed: those that are absent are exceptions."""
    beside = held if isinstance(held := content.get("beside"), dict) else {}
    absent = [name for name, part in beside.items() if isinstance(part, dict) and set(part) == {"absent"}]
    there = {name: part for name, part in beside.items() if name not in absent}
    return _parts(there, content.get("rtl_hash"), ())


def _untold(content: dict[str, Any]) -> list[str]:
    """Return what `remarks` is to tell of a sign-off, where that cannot be told."""
    exceptions, parts = content.get("exceptions"), content.get("parts")
    told = isinstance(exceptions, list) and all(isinstance(line, str) for line in exceptions)
    mutation = parts.get("mutation") if isinstance(parts, dict) else None
    counts = [mutation.get(key) for key, _ in TAKEN] if isinstance(mutation, dict) else [None]
    if told and all(type(count) is int and count >= 0 for count in counts):
        return []
    return ["the sign-off does not tell its exceptions: run `make signoff` again"]


def _parts(parts: Any, signed: Any, names: Sequence[str]) -> list[str]:
    """Return which parts of the evidence are missing, failed, or of another RTL than the file says."""
    if not isinstance(parts, dict):
        return ["the sign-off holds no evidence: run `make signoff` again"]
    held = {name: part if isinstance(part, dict) else {} for name, part in parts.items()}
    found = [f"{name}: no evidence: run `make signoff` again" for name in names if name not in held]
    for name, part in held.items():
        if part.get("passed") is not True:
            found.append(f"{name}: did not pass")
        elif part.get("rtl_hash") != signed:
            found.append(f"{name}: is of RTL {_short(part.get('rtl_hash'))}, not of that signed off")
    return found


def _waivers(content: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the waivers that were signed with; a file that tells none was signed with none."""
    waivers = content.get("waivers")
    return waivers if isinstance(waivers, list) and all(isinstance(w, dict) for w in waivers) else []


def _shortfalls(values: Any) -> list[str]:
    """Return what today's bounds say of the stored figures."""
    known = read_figures()
    shares = {figure.name for figure in known if figure.unit == "%"}
    if not isinstance(values, dict) or not all(
        _is_figure(value, 100 if name in shares else _MOST) for name, value in values.items()
    ):
        return ["the sign-off holds no figures: run `make signoff` again"]
    try:
        return list(judge(known, values).shortfalls)
    except InputError as error:
        return [f"{error}: run `make signoff` again"]
