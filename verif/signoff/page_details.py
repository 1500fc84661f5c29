"""The details on a sign-off's page: one section for each part of the evidence."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from typing import Any

from triaxis.coverage.html import Cell, Marked, code, folded, mark, table

Content = Mapping[str, Any]


def _part(title: str, part: Content) -> Iterator[str]:
    """Give a part's heading, its summary and its problems, or why it is absent."""
    yield f"<h2>{title}</h2>\n"
    if part["absent"] is not None:
        yield f"<p class=bad>not measured: {escape(part['absent'])}</p>\n"
        return
    yield f"<p>{mark('passed' if part['passed'] else 'failed', part['passed'])}: {escape(part['summary'])}. "
    took = "" if part["seconds"] is None else f"{part['seconds']:.0f} s, "
    yield f"<span class=why>{took}{code(part['command'])}</span></p>\n"


def testplan(part: Content) -> Iterator[str]:
    """Give each testpoint with what was found of it."""
    yield from _part("Testplan", part)
    if part["absent"] is not None:
        return
    rows = (
        [
            point["stage"],
            Marked(
                f"{mark(point['name'], point['passed'])}<br><span class=why>{escape(point['goal'])}</span>"
            ),
            _of(point["tests"]),
            _of(point["bins"]),
            _of(point["mutants"]),
            _of(point["assertions"]),
            _of(point["others"]),
        ]
        for point in part["testpoints"]
    )
    headings = [
        "stage",
        "testpoint",
        "tests passed",
        "bins",
        "mutants",
        "assertions",
        "proofs, faults, checks",
    ]
    yield from table(headings, rows)


def _of(pair: Sequence[int] | None) -> Cell:
    """Return how many of how many; None: nothing of that kind."""
    if pair is None:
        return Marked("")
    good, total = pair
    return mark(f"{good:,}\u00a0of\u00a0{total:,}", good == total)


def simulation(part: Content) -> Iterator[str]:
    """Give the runs by configuration, the scenes, and every seed."""
    yield from _part("Simulation", part)
    if part["absent"] is not None:
        return
    groups: dict[str, list[Content]] = defaultdict(list)
    for run in part["runs"]:
        groups[run["config"]].append(run)
    rows = (
        [
            config,
            _of((sum(run["passed"] for run in runs), len(runs))),
            _sum(runs, "checked"),
            _sum(runs, "judged_by_golden_model"),
            _sum(runs, "clear_claims_rechecked"),
            _sum(runs, "failed"),
        ]
        for config, runs in groups.items()
    )
    headings = ["configuration", "runs passed", "pairs", "judged by the golden model", "claims", "wrong"]
    yield from table(headings, rows)
    yield "<p>Every functional bin: <a href='coverage.html'>coverage.html</a>.</p>\n"
    scenes = [*part["scenes"], *(part["real_meshes"] or [])]
    if part["real_meshes"] is None:
        yield "<p class=why>Real machine parts: not measured, no files were there (TRIAXIS_DATA).</p>\n"
    keys = ("expected", "found", "pairs", "skipped", "tested", "near")
    scene_rows = ([scene["name"], *(scene[key] for key in keys)] for scene in scenes)
    yield from folded(f"{len(scenes)} scenes end to end", table(["scene", *keys], scene_rows))
    listed = (
        [
            mark(run["test"], run["passed"]), run["config"], run["agent"], str(run["seed"]),
            (run["counts"] or {}).get("checked"), run["seconds"], code(run["replay"]),
        ]
        for run in part["runs"]
    )  # fmt: skip
    headings = ["test", "configuration", "agent", "seed", "pairs", "seconds", "replay"]
    yield from folded(f"{len(part['runs'])} runs with their seeds", table(headings, listed))


def _sum(runs: Iterable[Content], key: str) -> int:
    return sum(run["counts"].get(key, 0) for run in runs if run["counts"])


def exhaustive(part: Content) -> Iterator[str]:
    """Give the small grid in full."""
    yield from _part("Every pair on a small grid", part)


def code_coverage(part: Content) -> Iterator[str]:
    """Give the totals of each file."""
    yield from _part("Code coverage", part)
    if part["absent"] is not None:
        return
    kinds = list(part["totals"])

    def cells(totals: Mapping[str, Content]) -> list[Cell]:
        return [
            _of((totals[kind]["hit"] + totals[kind]["waived"], totals[kind]["total"]))
            if kind in totals
            else ""
            for kind in kinds
        ]

    rows = [
        ["all", *cells(part["totals"])],
        *([name, *cells(totals)] for name, totals in part["files"].items()),
    ]
    yield from table(["file", *kinds], rows)


def faults(part: Content) -> Iterator[str]:
    """Give the table of faults."""
    yield from _part("Fault catalogue", part)
    if part["absent"] is not None:
        return
    rows = (
        [
            mark(fault["name"], fault["caught"]),
            fault["title"],
            fault["test"] or "",
            fault["config"] or "",
            _took(fault),
            fault["message"] or "",
            _counterexample(fault),
        ]
        for fault in part["faults"]
    )
    headings = [
        "fault",
        "what it is",
        "caught by",
        "in",
        "after pairs",
        "how it showed",
        "smallest counterexample",
    ]
    yield from table(headings, rows)


def _took(fault: Content) -> Cell:
    """Return after how many pairs, or clocks, it was caught."""
    if not fault["caught"]:
        return mark("not caught", False)
    if fault["pairs"] is not None:
        return fault["pairs"]
    return f"{fault['clocks']:,} clocks" if fault["clocks"] is not None else Marked("")


def _counterexample(fault: Content) -> Marked:
    found = fault["counterexample"]
    return Marked("") if found is None else Marked(f"{code(found['after'])}<br>{escape(found['meaning'])}")


def mutation(part: Content) -> Iterator[str]:
    """Give mutants by file and operator, the survivors, and the equivalent ones with their evidence."""
    yield from _part("Mutation", part)
    if part["absent"] is not None:
        return
    yield "<div class=beside>\n"
    for title, key in (("file", "files"), ("operator", "operators")):
        rows = (
            [name, t["killed"], t["equivalent"], mark(f"{t['surviving']:,}", not t["surviving"])]
            for name, t in part[key].items()
        )
        yield from table([title, "killed", "equivalent", "surviving"], rows)
    yield "</div>\n"
    survivors = (
        [code(m["id"]), m["place"], code(m["original"]), code(m["changed"])] for m in part["survivors"]
    )
    if part["survivors"]:
        yield "<h3>Surviving</h3>\n"
        yield from table(["mutant", "where", "original", "changed"], survivors)
    equivalent = ([code(e["id"]), e["place"], e["reason"], e["evidence"]] for e in part["equivalents"])
    headings = ["mutant", "where", "why", "evidence"]
    yield from folded("equivalent mutants and their evidence", table(headings, equivalent))


def proofs(part: Content) -> Iterator[str]:
    """Give what was proved, how, and under which assumptions."""
    yield from _part("Proofs", part)
    if part["absent"] is not None:
        return
    rows = (
        [
            mark(p["name"], p["passed"]),
            p["claim"],
            p["method"],
            ", ".join(f"{name} {value}" for name, value in p["parameters"].items()),
            " ".join(p["assumptions"]),
            p["seconds"],
        ]
        for p in part["proofs"]
    )
    yield from table(["proof", "what holds", "method", "parameters", "assumptions", "seconds"], rows)


def waivers(waivers: Sequence[Content] | None) -> Iterator[str]:
    """Give every waiver."""
    if waivers is None:
        return
    yield f"<h2>Waivers ({len(waivers)})</h2>\n"
    keys = ("category", "kind", "bins", "reason", "owner", "expires")
    rows = ([", ".join(w["modules"]), *(w[key] for key in keys)] for w in waivers)
    yield from folded("every waiver with its reason", table(["modules", *keys], rows))
