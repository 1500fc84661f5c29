"""The page of a sign-off: the verdict, what falls short, plots, then the details and the trends.

It shows what stands in the sign-off's file and in the history of nightly runs, and computes no verdict of
its own.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from triaxis.coverage.html import rendered
from triaxis.coverage.stages import STAGES, Figure, read_figures, share
from triaxis.golden.outputs import write_whole
from triaxis.sim.evidence import write_evidence
from triaxis.verif.signoff import plots
from triaxis.verif.signoff.gate import SOURCES
from triaxis.verif.signoff.plan import PAGE, RESULT
from triaxis.verif.signoff.result import Signoff

Content = Mapping[str, Any]

_NIGHT_KEYS = ["commit", "seed", "pairs", "failures", "seconds"]


def write(result: Signoff, nights: Sequence[Content]) -> Path:
    """Write build/signoff/signoff.json and index.html, each whole or not at all; return the page.

    ``nights``: records of nightly runs, oldest first.
    """
    content = result.content()
    page = signoff_page(content, read_figures(), nights)
    write_evidence(RESULT, content, SOURCES)
    return write_whole(PAGE, page)


def signoff_page(content: Content, figures: Sequence[Figure], nights: Sequence[Content]) -> str:
    """Return the page."""
    dates = [str(night["date"])[:16].replace("T", " ") for night in nights]
    return rendered(
        Path(__file__).with_name("page.html"),
        **content,
        title="Triaxis: sign-off",
        stages=STAGES,
        asked=figures,
        glance=[Markup(plot) for plot in _glance(content)],
        nights=nights,
        trends=[Markup(plot) for plot in _trends(nights, dates)],
        night_keys=_NIGHT_KEYS,
        night_rows=[
            [date, *(night[key] for key in _NIGHT_KEYS)] for date, night in zip(dates, nights, strict=True)
        ],
    )


def _glance(content: Content) -> Iterator[str]:
    """Yield the plots of what was measured."""
    parts = content["parts"]
    if shares := _coverage_shares(parts):
        yield plots.coverage_bars(shares)
    if parts["mutation"]["absent"] is None:
        files = parts["mutation"]["files"]
        counts = {name: (f["killed"], f["equivalent"], f["surviving"]) for name, f in files.items()}
        yield plots.mutants_by_file(counts)
    if parts["faults"]["absent"] is None:
        # Those that a rule or a refusal catches need no wrong answer, and so no number of pairs.
        yield plots.pairs_until_caught(
            {
                f["name"]: f["pairs"] if f["caught"] else None
                for f in parts["faults"]["faults"]
                if f["pairs"] is not None or not f["caught"]
            }
        )
    yield plots.time_by_part(_pieces(content))


def _pieces(content: Content) -> dict[str, tuple[float, float, float]]:
    """Return begin, end and seconds of the processor of each part, and of the stages of mutation below it."""
    found: dict[str, tuple[float, float, float]] = {}
    for part in content["timeline"]:
        begin, name = part["begin"], part["name"]
        found[name.replace("_", " ")] = begin, part["end"], part["cpu_seconds"]
        for stage in content["parts"].get(name, {}).get("stages", ()):
            found[f"  {stage['name']}"] = (
                begin + stage["begin"],
                begin + stage["end"],
                stage["cpu_seconds"],
            )
    return found


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


def _trends(nights: Sequence[Content], dates: Sequence[str]) -> Iterator[str]:
    for title, label, key, scale in (
        ("Pairs checked", "millions", "pairs", 1e-6),
        ("Speed", "million pairs per second", "pairs_per_second", 1e-6),
        ("Functional coverage", "percent", "coverage_percent", 1.0),
        ("Failing runs", "runs", "failures", 1.0),
    ):
        if nights:
            values = [None if night[key] is None else night[key] * scale for night in nights]
            yield plots.trend(title, label, dates, values, from_zero=label != "percent")
