"""The outcome of a regression: results.json, junit.xml for CI systems, report.html."""

import re
import time
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

from junitparser import Failure
from junitparser.xunit2 import JUnitXml, TestCase, TestSuite

from triaxis.coverage.html import rendered
from triaxis.coverage.report import percent
from triaxis.golden.outputs import write_whole
from triaxis.sim.evidence import write_evidence
from triaxis.sim.validity import provenance
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.regress.failing import bucket_of
from triaxis.verif.regress.one_job import SOURCES
from triaxis.verif.regress.outcome import Outcome
from triaxis.verif.regress.records import RunRecord, as_date

RESULTS, JUNIT, REPORT = "results.json", "junit.xml", "report.html"
# What XML cannot hold, however it is written.
_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_results(outcome: Outcome) -> Path:
    """Write results.json in the regression's folder, whole or not at all."""
    content = {
        "passed": not outcome.problems,
        "problems": outcome.problems,
        "summary": outcome.summary,
        "command": outcome.command,
        "seconds": round(outcome.seconds, 1),
        "begun": as_date(outcome.state.started[0]),
        "finished": as_date(time.time()),
        "regression": outcome.regression.name,
        "seed": outcome.state.seed,
        "seeds_multiplied_by": outcome.state.multiplier,
        "launcher": outcome.launcher,
        "least_pairs": outcome.regression.least_pairs or None,
        "pairs_checked": outcome.checked,
        "pairs_judged_by_golden_model": outcome.judged,
        "runs_kept_from_before": outcome.kept_from_before,
        "runs": [_run(record) for record in outcome.records],
        "buckets": [
            {
                "message": message,
                "runs": len(records),
                "first_replay": records[0].replay,
                "first_waves": records[0].waves,
                "keys": [record.run.key for record in records],
            }
            for message, records in outcome.buckets.items()
        ],
        "replayed_first": [seed.run.key for seed in outcome.replayed],
        "fixed": [seed.run.key for seed in outcome.fixed],
        "flaky": [seed.run.key for seed in outcome.flaky],
        "coverage": {
            "percent": outcome.coverage_percent,
            "models": {
                model.model: {item.name: {"hit": item.hit, "total": item.total} for item in model.items}
                for model in outcome.coverage
            },
        },
    }
    return write_evidence(outcome.folder / RESULTS, content, SOURCES)


def _run(record: RunRecord) -> dict[str, object]:
    return {
        **asdict(record.run),
        "key": record.run.key,
        "passed": record.passed,
        "seconds": round(record.seconds, 1),
        "pairs_checked": record.counts["checked"] if record.counts else None,
        "bucket": None if record.passed else bucket_of(record),
        "silent": record.silent,
        **{key: getattr(record, key) for key in ("errors", "replay", "waves", "log", "host", "job")},
    }


def write_junit(outcome: Outcome) -> Path:
    """Write junit.xml in the regression's folder, whole or not at all: a suite for each configuration."""
    document = JUnitXml(f"triaxis {outcome.regression.name}")
    groups: dict[str, list[RunRecord]] = defaultdict(list)
    for record in outcome.records:
        groups[record.run.config].append(record)
    for config, records in groups.items():
        suite = TestSuite(config)
        suite.timestamp = as_date(min(record.started for record in records)).partition("+")[0]
        suite.add_testcases([_case(record) for record in records])
        document.add_testsuite(suite)
    if outcome.shortfalls:
        # What no single run is to blame for: goals missed, flaky seeds, runs without a result.
        suite = TestSuite("goals")
        case = TestCase(outcome.regression.name, "goals", 0)
        case.result = [_failure(outcome.shortfalls[0], outcome.shortfalls, "goal")]
        suite.add_testcase(case)
        document.add_testsuite(suite)
    document.update_statistics()
    return write_whole(outcome.folder / JUNIT, document.tostring())


def _case(record: RunRecord) -> TestCase:
    run = record.run
    # The number of pairs too: a test may run at several sizes, and a CI system joins cases of one name.
    name = f"{run.item}[seed={run.seed},pairs={run.pairs}]"
    case = TestCase(name, f"{run.config}.{run.test}", round(record.seconds, 3))
    facts = {"seed": str(run.seed), "replay": record.replay, "agent": run.agent, "log": record.log}
    if record.waves:
        facts["waves"] = record.waves
    for key, value in facts.items():
        case.add_property(key, _text(value))
    if not record.passed:
        lines = [*record.errors, *record.counterexamples, f"log: {record.log}"]
        lines += [f"waves: {record.waves}"] if record.waves else []
        lines.append(f"replay: {record.replay}")
        case.result = [_failure(bucket_of(record), lines, "failed")]
    return case


def _failure(message: str, lines: Iterable[str], kind: str) -> Failure:
    failure = Failure(_text(message), kind)
    failure.text = _text("\n".join(lines))
    return failure


def _text(text: str) -> str:
    return _NOT_XML.sub("?", text)


def write_report(outcome: Outcome) -> Path:
    """Write report.html in the regression's folder, whole or not at all; it links what is there already."""
    flaky, fixed = ({seed.run.key for seed in seeds} for seeds in (outcome.flaky, outcome.fixed))
    own = [outcome.folder / name for name in (RESULTS, JUNIT, "coverage.html")]
    pages = [*own, *outcome.folder.glob("dvsim/**/reports/index.html")]
    page = rendered(
        Path(__file__).with_name(REPORT),
        title=f"Triaxis: {outcome.regression.name}",
        outcome=outcome,
        finished=as_date(time.time()),
        stamp=provenance(SOURCES),
        flaky=flaky,
        fixed=fixed,
        covered=lambda config: _covered(outcome, config),
        links=sorted(str(path.relative_to(outcome.folder)) for path in pages if path.exists()),
    )
    return write_whole(outcome.folder / REPORT, page)


def _covered(outcome: Outcome, config: str) -> float | None:
    # Configurations that differ in their tags share a model.
    name = model_of(config).name
    return next((percent([model]) for model in outcome.coverage if model.model == name), None)
