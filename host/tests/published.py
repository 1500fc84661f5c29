"""Reports as they are published: docs/reports.schema.json says what is in each."""

import json
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

SCHEMA = Path(__file__).resolve().parents[2] / "docs" / "reports.schema.json"


@cache
def _validator(kind: str) -> Any:
    """Return what validates reports of a kind; None where jsonschema is not installed."""
    if not find_spec("jsonschema"):
        return None
    from jsonschema import Draft202012Validator

    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator({**schema, "$ref": f"#/$defs/{kind}"})


def read_published(path: Path, kind: str) -> dict[str, Any]:
    """Return a report; raise ValidationError where it is not of the schema's ``kind``.

    Where jsonschema is not installed, which `make test` does, it is only read.
    """
    report = json.loads(path.read_text(encoding="utf-8"))
    if validator := _validator(kind):
        validator.validate(report)
    return report
