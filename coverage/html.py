"""HTML pages of one file, from templates that extend base.html and use the macros of pieces.html."""

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined


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
