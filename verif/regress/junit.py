"""The outcome of a regression as JUnit XML, which CI systems show: a suite for each configuration."""

import re
from datetime import UTC, datetime
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from triaxis.golden.outputs import write_whole
from triaxis.verif.regress.buckets import bucket_of
from triaxis.verif.regress.outcome import Outcome
from triaxis.verif.regress.run_record import RunRecord

NAME = "junit.xml"
# What XML cannot hold, however it is written.
_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_junit(outcome: Outcome) -> Path:
    """Write junit.xml in the regression's folder, whole or not at all."""
    root = Element("testsuites", name=f"triaxis {outcome.regression.name}")
    _count(root, outcome.records)
    by_config: dict[str, list[RunRecord]] = {}
    for record in outcome.records:
        by_config.setdefault(record.run.config, []).append(record)
    for config, records in by_config.items():
        suite = SubElement(root, "testsuite", name=config)
        _count(suite, records)
        begin = datetime.fromtimestamp(min(r.started for r in records), UTC)
        suite.set("timestamp", begin.strftime("%Y-%m-%dT%H:%M:%S"))
        for record in records:
            _case(suite, record)
    if outcome.shortfalls:
        _goals(root, outcome)
    path = outcome.folder / NAME
    indent(root)
    return write_whole(path, tostring(root, encoding="utf-8", xml_declaration=True))


def _count(element: Element, records: "tuple[RunRecord, ...] | list[RunRecord]") -> None:
    element.set("tests", str(len(records)))
    element.set("failures", str(sum(not record.passed for record in records)))
    element.set("errors", "0")
    element.set("time", f"{sum(record.seconds for record in records):.3f}")


def _case(suite: Element, record: RunRecord) -> None:
    run = record.run
    # The number of pairs too: a test may run at several sizes, and a CI system joins cases of one name.
    name = f"{run.item}[seed={run.seed},pairs={run.pairs}]"
    case = SubElement(suite, "testcase", classname=f"{run.config}.{run.test}", name=name)
    case.set("time", f"{record.seconds:.3f}")
    properties = SubElement(case, "properties")
    facts = {"seed": str(run.seed), "replay": record.replay, "agent": run.agent, "log": record.log}
    for key, value in facts.items():
        SubElement(properties, "property", name=key, value=_text(value))
    if not record.passed:
        failure = SubElement(case, "failure", message=_text(bucket_of(record)), type="failed")
        lines = [*record.errors, *record.counterexamples, f"log: {record.log}", f"replay: {record.replay}"]
        failure.text = _text("\n".join(lines))


def _goals(root: Element, outcome: Outcome) -> None:
    """Add what no single run is to blame for: goals missed, flaky seeds, runs without a result."""
    suite = SubElement(root, "testsuite", name="goals", tests="1", failures="1", errors="0", time="0")
    case = SubElement(suite, "testcase", classname="goals", name=outcome.regression.name, time="0")
    failure = SubElement(case, "failure", message=_text(outcome.shortfalls[0]), type="goal")
    failure.text = _text("\n".join(outcome.shortfalls))
    for key in ("tests", "failures"):
        root.set(key, str(int(root.get(key, "0")) + 1))


def _text(text: str) -> str:
    return _NOT_XML.sub("?", text)
