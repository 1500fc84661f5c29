"""HTML pages that need no other file: from templates that extend base.html; and the page of coverage."""

from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from triaxis.coverage.counts import Counts, CoverageDatabase
from triaxis.coverage.cover_model import CoverModel
from triaxis.coverage.report import percent, report
from triaxis.golden.outputs import write_whole


def rendered(template: Path, **values: object) -> str:
    """Return a page: the template with these values, all text escaped."""
    environment = Environment(
        loader=FileSystemLoader([template.parent, Path(__file__).parent]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["shown"] = _shown
    return environment.get_template(template.name).render(**values)


def _shown(value: object) -> object:
    """Return a value as tables show it."""
    if value is None:
        return "not measured"
    return f"{value:,}" if isinstance(value, int | float) else value


def write_page(path: Path, database: CoverageDatabase) -> None:
    """Write every bin with its count, goal and exclusion, or nothing; InputError where that fails."""
    models = [_model(model, counts) for model, counts in database]
    found = [model["found"] for model in models]
    hit, total = sum(one.hit for one in found), sum(one.total for one in found)
    summary = f"{hit} of {total} bins in {len(found)} models, {percent(found):.2f} %"
    template = Path(__file__).with_name("page.html")
    write_whole(path, rendered(template, title="Functional coverage", summary=summary, models=models))


def _model(model: CoverModel[Any], counts: Counts) -> dict[str, Any]:
    found = report(model, counts)
    tables = zip(model.items, found.items, strict=True)
    return {
        "name": model.name,
        "definition": model.hash[:16],
        "found": found,
        "percent": percent([found]),
        "illegal": sum(len(item.illegal_hits) for item in found.items),
        "tables": [
            {"found": one, "bins": list(zip(item.bins, counts.hits[item.name].tolist(), strict=True))}
            for item, one in tables
        ],
    }
