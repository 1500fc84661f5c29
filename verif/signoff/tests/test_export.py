"""`triaxis coverage export` writes what is stored, and refuses what is absent, of another RTL, not whole."""

import argparse
import json
import os
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import Counts, CoverageDatabase
from triaxis.coverage.testplan import read_testplan
from triaxis.coverage.tests.counter_files import BINS, FIRST, SECOND, SOURCE, write_counters
from triaxis.golden.errors import InputError
from triaxis.sim.configuration import Configuration
from triaxis.verif.commands import coverage

HERE = "1234567890abcdef"
MODELS = [
    core_model(one)
    for one in (Configuration(), Configuration(13, 4), Configuration(edge_box=False, gating=False))
]
FUNCTIONAL, SIGNOFF, CODE = "signoff/coverage.json", "signoff/signoff.json", "code.json"


def export(*arguments: object) -> None:
    parser = argparse.ArgumentParser()
    coverage.add_export(parser)
    options = parser.parse_args([str(argument) for argument in arguments])
    assert options.run(options) == 0


EVIDENCE = {"rtl_hash": HERE, "passed": True, "problems": [], "summary": "", "seconds": 1.0}


def change(path: Path, **changes: object) -> None:
    """Change a result; None takes a key out."""
    content = {**json.loads(path.read_text()), **changes}
    path.write_text(json.dumps({key: value for key, value in content.items() if value is not None}))


def written(checkout: Path) -> set[str]:
    """Return the names of all files that were exported."""
    return {path.name for path in checkout.rglob("*") if "triaxis" in path.name}


def saved(path: Path, rng: np.random.Generator) -> Path:
    """Write counts as a sign-off leaves them; return their file."""
    database = CoverageDatabase(MODELS)
    for model in MODELS:
        hits = {item.name: rng.integers(0, 50, item.size) for item in model.items}
        database.add(Counts(model.name, model.hash, hits))
    path.parent.mkdir()
    database.save(path)
    result = {**EVIDENCE, "passed": False, "command": "triaxis signoff", "seed": 1}
    path.with_name("signoff.json").write_text(json.dumps(result))
    return path


@pytest.fixture
def checkout(tmp_path: Path, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a checkout with a sign-off and a measurement of code coverage."""
    source = tmp_path / "dut" / "leaf.sv"
    source.parent.mkdir()
    source.write_text(SOURCE)
    saved(tmp_path / FUNCTIONAL, rng)
    write_counters(tmp_path / "w16_m0.dat", source, {FIRST: range(len(BINS)), SECOND: range(len(BINS))})
    write_counters(tmp_path / "w8_m8.dat", source, {FIRST: range(len(BINS))})
    runs = [{"model": "w16_m0"}, {"model": "w8_m8"}]
    code = {**EVIDENCE, "command": "triaxis coverage code", "runs": runs}
    (tmp_path / CODE).write_text(json.dumps(code))
    monkeypatch.setattr(coverage, "rtl_hash", lambda: HERE)
    places = {"ROOT": "", "COUNTERS": "", "RESULT": CODE, "LCOV": "triaxis.info", "UCIS": "triaxis.ucis.xml"}
    # The default of the option is that of the definition.
    for name, place in {**places, "COVERAGE": FUNCTIONAL}.items():
        monkeypatch.setattr(coverage, name, tmp_path / place)
    return tmp_path


def names(path: Path) -> list[str | None]:
    root = ElementTree.parse(path).getroot()
    return [one.get("name") for one in root.iter("instanceCoverages") if one.get("parentInstanceId") is None]


def test_both_are_written(checkout: Path) -> None:
    export()
    assert written(checkout) == {"triaxis.info", "triaxis.ucis.xml"}
    info = (checkout / "triaxis.info").read_text()
    # The first way of line 3 is hit once in each of three instances.
    assert "SF:dut/leaf.sv" in info and "BRDA:3,0,0,3" in info
    ucis = checkout / "triaxis.ucis.xml"
    assert names(ucis) == [*(model.name for model in MODELS), "w16_m0", "w8_m8"]
    records = ElementTree.parse(ucis).getroot().iter("historyNodes")
    assert [(r.get("logicalName"), r.get("testStatus"), r.get("cmd")) for r in records] == [
        ("sign-off", "false", "triaxis signoff"),
        ("code coverage", "true", "triaxis coverage code"),
    ]


def test_several_are_added_up_and_written_alone_where_wanted(checkout: Path, rng: Any, capsys: Any) -> None:
    export("--lcov", checkout / "new" / "triaxis_1.info")
    assert written(checkout) == {"triaxis_1.info"}
    files = [checkout / FUNCTIONAL, saved(checkout / "nightly" / "coverage.json", rng)]
    sums = CoverageDatabase(MODELS)
    for path in files:
        sums.add_file(path)
    (checkout / CODE).unlink()
    export("--ucis", checkout / "new" / "triaxis_2.xml", "--from", *files)
    assert "without code coverage" in capsys.readouterr().out
    assert written(checkout) == {"triaxis_1.info", "triaxis_2.xml"}
    assert names(checkout / "new" / "triaxis_2.xml") == [model.name for model in MODELS]
    [answer, *_] = ElementTree.parse(checkout / "new" / "triaxis_2.xml").getroot().iter("coverpoint")
    [(_, counts), *_] = list(sums)
    read = [int(c.attrib["coverageCount"]) for c in answer.iter("contents")]
    assert read == counts.hits["answer"].tolist()


def damage(path: Path) -> None:
    path.write_text("cut")
    os.utime(path, (0, 0))


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda c: (c / CODE).unlink(), r"code\.json: no such file: run `triaxis coverage code`"),
        (lambda c: change(c / CODE, rtl_hash="0" * 64), r"code\.json: is of another RTL \(000000000000"),
        (lambda c: change(c / CODE, rtl_hash=7), r"code\.json: rtl_hash and command must be texts"),
        (lambda c: change(c / CODE, runs=[]), r"code\.json: names no runs"),
        (lambda c: change(c / CODE, runs=7), r"code\.json: names no runs"),
        (lambda c: (c / "w8_m8.dat").unlink(), r"w8_m8\.dat: no such file"),
        (lambda c: os.utime(c / "w8_m8.dat", (9e9, 9e9)), r"w8_m8\.dat: newer than code\.json"),
        (lambda c: damage(c / "w8_m8.dat"), r"w8_m8\.dat: not a coverage file"),
        (lambda c: change(c / SIGNOFF, rtl_hash="x"), r"signoff\.json: is of another RTL"),
        (lambda c: (c / FUNCTIONAL).unlink(), r"coverage\.json: no such file: run `make"),
        (lambda c: (c / FUNCTIONAL).write_text("{}"), r"coverage\.json: not a coverage f"),
        (lambda c: change(c / FUNCTIONAL, models=[]), r"coverage\.json: counts of no model"),
        (lambda c: change(c / FUNCTIONAL, digest="0"), r"coverage\.json: damaged"),
    ],
)
def test_what_is_absent_or_stale_is_refused(checkout: Path, spoil: Any, said: str) -> None:
    spoil(checkout)
    with pytest.raises(InputError, match=said) as caught:
        export()
    assert "\n" not in str(caught.value)
    assert written(checkout) == set()


def test_the_testplan_is_written_whatever_was_measured(checkout):
    change(checkout / CODE, rtl_hash="0" * 64)
    export("--reqif", checkout / "plan.reqif")
    assert (checkout / "plan.reqif").exists()


def test_requirements_and_testpoints_are_reqif_that_another_reader_understands(tmp_path):
    reqif = pytest.importorskip("reqif", reason="reqif is absent: `make .venv/.ready-regress`")
    import xmlschema
    from reqif.parser import ReqIFParser

    file, plan = tmp_path / "plan.reqif", read_testplan()
    export("--reqif", file)
    schema = Path(reqif.__file__).parent / "reqif_schema" / "reqif.xsd"
    xmlschema.XMLSchema(schema, allow="local").validate(file)
    held = ReqIFParser.parse(str(file)).core_content
    assert held and held.req_if_content
    content = held.req_if_content
    assert content.spec_objects and content.spec_relations
    found = {one.identifier: one for one in content.spec_objects}
    assert list(found) == [one.id for one in plan.requirements] + [one.name for one in plan.testpoints]
    text = found["CORE-1"].attribute_map["requirement.ReqIF.Text"].value
    assert text == plan.requirements[0].text
    tests = found["general_pairs"].attribute_map["testpoint.tests"].value
    assert tests == ", ".join(plan.testpoints[0].tests)
    assert {(one.source, one.target) for one in content.spec_relations} == {
        (point.name, name) for point in plan.testpoints for name in point.requirements
    }
    before = file.read_bytes()
    export("--reqif", file)
    assert file.read_bytes() == before
