"""The page of a sign-off: the verdict, the problems, plots, then the details and the trends.

It shows what stands in the sign-off's file and in the history of nightly runs, and computes no verdict of
its own.
"""

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any

from triaxis.coverage.html import Cell, Marked, code, folded, mark, page, table
from triaxis.coverage.stages import STAGES, Figure, share
from triaxis.verif.signoff import page_details as details
from triaxis.verif.signoff import plots

Content = Mapping[str, Any]

_TITLE = "Triaxis: sign-off"


def signoff_page(content: Content, figures: Sequence[Figure], nights: Sequence[Content]) -> str:
    """Return the page; ``nights``: records of nightly runs, oldest first."""
    parts = content["parts"]
    body = [
        *_verdict(content),
        *_shortfalls(content["problems"]),
        *_figures(figures, content["figures"]),
        *_plots(content, parts),
        *_trends(nights),
        *details.testplan(parts["testplan"]),
        *details.simulation(parts["simulation"]),
        *details.exhaustive(parts["exhaustive"]),
        *details.code_coverage(parts["code_coverage"]),
        *details.faults(parts["faults"]),
        *details.mutation(parts["mutation"]),
        *details.proofs(parts["proofs"]),
        *details.waivers(content["waivers"]),
        *_provenance(content),
    ]
    return page(_TITLE, body)


def _verdict(content: Content) -> Iterator[str]:
    passed = content["passed"]
    commit = content["git_commit"] or "no commit"
    state = "" if content["git_clean"] else ", with uncommitted changes"
    yield f"<h1>{_TITLE}</h1><div class='verdict {'good' if passed else 'bad'}'>"
    yield f"<b>{'PASSED' if passed else 'FAILED'}</b>: stage {content['stage'] or 'none'} reached"
    yield f", {STAGES[-1]} is wanted<br>" if not passed else "<br>"
    yield f"RTL <code>{content['rtl_hash'][:16]}</code>, commit <code>{escape(commit[:12])}</code>{state}; "
    yield f"{escape(content['date'])}; {content['seconds']:.0f} s</div>\n"


def _shortfalls(problems: Sequence[str]) -> Iterator[str]:
    if problems:
        yield "<h2>Problems</h2><ul>"
        yield from (f"<li>{escape(problem)}" for problem in problems)
        yield "</ul>\n"


def _figures(figures: Sequence[Figure], values: Mapping[str, Any]) -> Iterator[str]:
    yield "<h2>Figures and stages</h2>\n"

    def rows() -> Iterator[list[Cell]]:
        for figure in figures:
            value = values[figure.name]
            bounds = [_bound(figure, value, stage) for stage in STAGES]
            yield [figure.meaning, mark(figure.text(value), figure.is_met(value, STAGES[-1])), *bounds]

    yield from table(["figure", "measured", *STAGES], rows())


def _bound(figure: Figure, value: float | None, stage: str) -> Marked:
    if stage not in figure.bounds:
        return Marked("")
    wanted = f"{'at most' if figure.is_most else 'at least'} {figure.text(figure.bounds[stage])}"
    return mark(wanted, figure.is_met(value, stage))


def _plots(content: Content, parts: Mapping[str, Content]) -> Iterator[str]:
    yield "<h2>At a glance</h2><div class=plots>\n"
    shares = _coverage_shares(parts)
    if shares:
        yield plots.coverage_bars(shares)
    if parts["mutation"]["absent"] is None:
        files = parts["mutation"]["files"]
        yield plots.mutants_by_file(
            {name: (f["killed"], f["equivalent"], f["surviving"]) for name, f in files.items()}
        )
    if parts["faults"]["absent"] is None:
        # Those that a rule or a refusal catches need no wrong answer, and so no number of pairs.
        caught = {
            f["name"]: f["pairs"] if f["caught"] else None
            for f in parts["faults"]["faults"]
            if f["pairs"] is not None or not f["caught"]
        }
        yield plots.pairs_until_caught(caught)
    took = {name.replace("_", " "): part.get("seconds") for name, part in parts.items()}
    seconds = {name: value for name, value in took.items() if value is not None}
    yield plots.time_by_part(seconds)
    yield "</div>\n"


def _coverage_shares(parts: Mapping[str, Content]) -> dict[str, float]:
    found: dict[str, float] = {}
    if parts["simulation"]["absent"] is None:
        for model, items in parts["simulation"]["coverage"].items():
            hit, total = (sum(item[key] for item in items.values()) for key in ("hit", "total"))
            found[f"functional, {model.removeprefix('core_')}"] = share(hit, total) or 0.0
    if parts["code_coverage"]["absent"] is None:
        for kind, total in parts["code_coverage"]["totals"].items():
            found[kind] = share(total["hit"] + total["waived"], total["total"]) or 0.0
    return found


def _trends(nights: Sequence[Content]) -> Iterator[str]:
    yield f"<h2>Trends over nightly runs ({len(nights)})</h2>\n"
    if not nights:
        yield "<p>No nightly run has been recorded here yet: <code>make nightly</code> records one.</p>\n"
        return
    dates = [str(night["date"])[:16].replace("T", " ") for night in nights]
    yield "<div class=plots>\n"
    for title, label, key, scale in (
        ("Pairs checked", "millions", "pairs", 1e-6),
        ("Speed", "million pairs per second", "pairs_per_second", 1e-6),
        ("Functional coverage", "percent", "coverage_percent", 1.0),
        ("Failing runs", "runs", "failures", 1.0),
    ):
        values = [None if night[key] is None else night[key] * scale for night in nights]
        yield plots.trend(title, label, dates, values, from_zero=label != "percent")
    yield "</div>\n"
    keys = ("commit", "seed", "pairs", "failures", "seconds")
    rows = ([date, *(night[key] for key in keys)] for date, night in zip(dates, nights, strict=True))
    yield from folded("nightly runs", table(["date", *keys], rows))


def _provenance(content: Content) -> Iterator[str]:
    yield "<h2>RTL, environment and tools</h2>\n"
    keys = ("rtl_hash", "environment_hash", "git_commit", "command", "seed", "date")
    yield from table(["", ""], ([key.replace("_", " "), code(str(content[key]))] for key in keys))
    yield from table(["tool", "version"], sorted(content["tools"].items()))
