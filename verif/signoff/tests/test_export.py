"""`triaxis coverage export` writes what is stored, and refuses what is absent, of another RTL, not whole."""

import argparse
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import Counts, CoverageDatabase
from triaxis.coverage.tests.counter_files import BINS, FIRST, SECOND, SOURCE, write_counters
from triaxis.golden.errors import InputError
from triaxis.verif.commands import coverage

HERE = "1234567890abcdef"
MODELS = [core_model(16, 0), core_model(13, 4), core_model(16, 0, False, False)]


@dataclass
class Checkout:
    """A checkout with a sign-off and a measurement of code coverage, and the command line in it."""

    folder: Path
    said: pytest.CaptureFixture[str]

    def export(self, *arguments: str) -> str:
        """Run the command; return what it prints."""
        parser = argparse.ArgumentParser()
        coverage.add_export(parser)
        options = parser.parse_args(arguments)
        assert options.run(options) == 0
        return self.said.readouterr().out

    def change(self, name: str, **changes: Any) -> None:
        """Change a result; None takes a key out."""
        path = self.folder / name
        content = {**json.loads(path.read_text()), **changes}
        path.write_text(json.dumps({k: v for k, v in content.items() if v is not None}))

    def files(self) -> set[str]:
        """Return the names of all that was written."""
        return {path.name for path in self.folder.rglob("*") if "triaxis" in path.name}


def saved(path: Path, rng: np.random.Generator) -> CoverageDatabase:
    database = CoverageDatabase(MODELS)
    for model in MODELS:
        hits = {item.name: rng.integers(0, 50, item.size) for item in model.items}
        database.add(Counts(model.name, model.hash, hits))
    path.parent.mkdir(exist_ok=True)
    database.save(path)
    result = {"rtl_hash": HERE, "passed": False, "command": "triaxis signoff", "seed": 1}
    path.with_name("signoff.json").write_text(json.dumps(result))
    return database


@pytest.fixture
def checkout(
    tmp_path: Path,
    rng: np.random.Generator,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Checkout:
    source = tmp_path / "dut" / "leaf.sv"
    source.parent.mkdir()
    source.write_text(SOURCE)
    saved(tmp_path / "signoff" / "coverage.json", rng)
    write_counters(tmp_path / "w16_m0.dat", source, {FIRST: range(len(BINS)), SECOND: range(len(BINS))})
    write_counters(tmp_path / "w8_m8.dat", source, {FIRST: range(len(BINS))})
    code = {"rtl_hash": HERE, "passed": True, "command": "triaxis coverage code", "runs": []}
    (tmp_path / "code.json").write_text(json.dumps(code))
    found = Checkout(tmp_path, capsys)
    found.change("code.json", runs=[{"model": "w16_m0"}, {"model": "w8_m8"}])
    monkeypatch.setattr(coverage, "rtl_hash", lambda: HERE)
    monkeypatch.setattr(coverage, "ROOT", tmp_path)
    monkeypatch.setattr(coverage, "COUNTERS", tmp_path)
    monkeypatch.setattr(coverage, "RESULT", tmp_path / "code.json")
    monkeypatch.setattr(coverage, "LCOV", tmp_path / "triaxis.info")
    monkeypatch.setattr(coverage, "UCIS", tmp_path / "triaxis.ucis.xml")
    # The default of the option is that of the definition.
    monkeypatch.setattr(coverage, "COVERAGE", tmp_path / "signoff" / "coverage.json")
    return found


def names(path: Path) -> list[str | None]:
    root = ElementTree.parse(path).getroot()
    return [one.get("name") for one in root.iter("instanceCoverages") if one.get("parentInstanceId") is None]


def test_both_are_written(checkout: Checkout) -> None:
    said = checkout.export()
    assert checkout.files() == {"triaxis.info", "triaxis.ucis.xml"}
    assert said.count("written to") == 2
    info = (checkout.folder / "triaxis.info").read_text()
    # The first way of line 3 is hit once in each of three instances.
    assert "SF:dut/leaf.sv" in info and "BRDA:3,0,0,3" in info
    every = [model.name for model in MODELS] + ["w16_m0", "w8_m8"]
    assert names(checkout.folder / "triaxis.ucis.xml") == every
    root = ElementTree.parse(checkout.folder / "triaxis.ucis.xml").getroot()
    records = [(r.get("logicalName"), r.get("testStatus"), r.get("cmd")) for r in root.iter("historyNodes")]
    assert records == [
        ("sign-off", "false", "triaxis signoff"),
        ("code coverage", "true", "triaxis coverage code"),
    ]


def test_one_alone_is_written_where_it_is_wanted(checkout: Checkout, tmp_path: Path) -> None:
    checkout.export("--lcov", str(tmp_path / "new" / "triaxis_1.info"))
    assert checkout.files() == {"triaxis_1.info"}
    checkout.export("--ucis", str(tmp_path / "new" / "triaxis_2.xml"))
    assert checkout.files() == {"triaxis_1.info", "triaxis_2.xml"}


def test_without_code_coverage_it_says_so(checkout: Checkout) -> None:
    (checkout.folder / "code.json").unlink()
    said = checkout.export("--ucis", str(checkout.folder / "triaxis.xml"))
    assert "without code coverage" in said
    assert names(checkout.folder / "triaxis.xml") == [model.name for model in MODELS]


def test_several_are_added_up(checkout: Checkout, rng: np.random.Generator) -> None:
    first = checkout.folder / "signoff" / "coverage.json"
    second = checkout.folder / "nightly" / "coverage.json"
    saved(second, rng)
    sums = CoverageDatabase(MODELS)
    for path in (first, second):
        sums.add_file(path)
    ucis = checkout.folder / "triaxis.xml"
    checkout.export("--ucis", str(ucis), "--from", str(first), str(second))
    root = ElementTree.parse(ucis).getroot()
    [answer, *_] = root.iter("coverpoint")
    [(_, counts), *_] = list(sums)
    read = [int(c.attrib["coverageCount"]) for c in answer.iter("contents")]
    assert read == counts.hits["answer"].tolist()


def damage(path: Path) -> None:
    path.write_text("cut")
    os.utime(path, (0, 0))


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (
            lambda c: (c.folder / "code.json").unlink(),
            r"code\.json: no such file: run `triaxis coverage code`",
        ),
        (lambda c: (c.folder / "code.json").write_text("{"), r"code\.json: not readable"),
        (lambda c: c.change("code.json", command=None), r"code\.json: does not say"),
        (lambda c: c.change("code.json", rtl_hash="0" * 64), r"code\.json: is of another RTL \(000000000000"),
        (lambda c: c.change("code.json", runs=[]), r"code\.json: names no runs"),
        (lambda c: (c.folder / "w8_m8.dat").unlink(), r"w8_m8\.dat: no such file"),
        (lambda c: os.utime(c.folder / "w8_m8.dat", (9e9, 9e9)), r"w8_m8\.dat: newer than code\.json"),
        (lambda c: damage(c.folder / "w8_m8.dat"), r"w8_m8\.dat: not a coverage file"),
        (
            lambda c: (c.folder / "signoff" / "signoff.json").unlink(),
            r"signoff\.json: no such file: run `make si",
        ),
        (
            lambda c: (c.folder / "signoff" / "coverage.json").unlink(),
            r"coverage\.json: no such file: run `make",
        ),
        (lambda c: c.change("signoff/signoff.json", rtl_hash="x"), r"signoff\.json: is of another RTL"),
        (
            lambda c: (c.folder / "signoff" / "coverage.json").write_text("{}"),
            r"coverage\.json: not a coverage f",
        ),
        (lambda c: c.change("signoff/coverage.json", models=[]), r"coverage\.json: counts of no model"),
        (lambda c: c.change("signoff/coverage.json", digest="0"), r"coverage\.json: damaged"),
    ],
)
def test_what_is_absent_or_stale_is_refused(checkout: Checkout, spoil: Any, said: str) -> None:
    spoil(checkout)
    with pytest.raises(InputError, match=said) as caught:
        checkout.export()
    assert "\n" not in str(caught.value)
    assert checkout.files() == set()
