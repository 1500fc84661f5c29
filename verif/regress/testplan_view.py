"""The testplan as dvsim wants it: the tests of a testpoint by the names that they have in the Hjson file."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.paths import ROOT
from triaxis.verif.regress.definition import Item

TESTPLAN = ROOT / "coverage" / "testplan.hjson"
# dvsim's word for a testpoint that no simulation is mapped to.
_NO_SIMULATION = ["N/A"]


def write_view(path: Path, items: Sequence[Item], testplan: Path = TESTPLAN) -> bool:
    """Write the view, and return whether there is a testplan to make it of."""
    path.unlink(missing_ok=True)
    if not testplan.exists():
        return False
    import hjson

    try:
        content = hjson.loads(testplan.read_text(encoding="utf-8"))
        points = [_testpoint(point, items) for point in content["testpoints"]]
    except (hjson.HjsonDecodeError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{testplan}: not a testplan: {error!r}") from error
    write_whole(path, json.dumps({"name": "triaxis", "testpoints": points}, indent=1) + "\n")
    return True


def _testpoint(point: Mapping[str, Any], items: Sequence[Item]) -> dict[str, Any]:
    wanted = set(point.get("tests", []))
    names = [item.name for item in items if item.test in wanted]
    return {
        "name": point["name"],
        "desc": point["desc"],
        "stage": point["stage"],
        "tests": names or _NO_SIMULATION,
    }
