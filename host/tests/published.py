"""Reports as they are published: docs/reports.schema.json says what is in each."""

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any

SCHEMA = Path(__file__).resolve().parents[2] / "docs" / "reports.schema.json"


def read_published(path: Path, kind: str) -> dict[str, Any]:
    """Return a report; raise ValidationError where it is not of the schema's ``kind``.

    Where jsonschema is not installed, which `make test` does, it is only read.
    """
    report = json.loads(path.read_text(encoding="utf-8"))
    if find_spec("jsonschema"):
        from jsonschema import Draft202012Validator

        schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
        Draft202012Validator.check_schema(schema)
        Draft202012Validator({**schema, "$ref": f"#/$defs/{kind}"}).validate(report)
    return report
