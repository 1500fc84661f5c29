"""The page of a sign-off: the verdict, what falls short, plots, then the details.

It shows what stands in the sign-off's file, and computes no verdict of its own.
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


def write(result: Signoff) -> Path:
    """Write build/signoff/signoff.json and index.html, each whole or not at all; return the page."""
    content = result.content()
    page = signoff_page(content, read_figures())
    write_evidence(RESULT, content, SOURCES)
    return write_whole(PAGE, page)


def signoff_page(content: Content, figures: Sequence[Figure]) -> str:
    """Return the page."""
    return rendered(
        Path(__file__).with_name("page.html"),
        **content,
        title="Triaxis: sign-off",
        stages=STAGES,
        asked=figures,
        glance=[Markup(plot) for plot in _glance(content)],
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
            found[f"  {stage['name']}"] = (begin + stage["begin"], begin + stage["end"], stage["cpu_seconds"])
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
