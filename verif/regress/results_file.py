"""The outcome of a regression as JSON, and its line in the history."""

from dataclasses import asdict
from pathlib import Path

from triaxis.sim.evidence import write_evidence
from triaxis.sim.provenance import provenance
from triaxis.verif.regress.buckets import bucket_of
from triaxis.verif.regress.history import NightlyRecord, now
from triaxis.verif.regress.outcome import Outcome
from triaxis.verif.regress.run_record import RunRecord

NAME = "results.json"


def write_results(outcome: Outcome) -> Path:
    """Write results.json in the regression's folder, whole or not at all."""
    content = {
        "passed": not outcome.problems,
        "problems": outcome.problems,
        "summary": outcome.summary,
        "command": outcome.command,
        "seconds": round(outcome.seconds, 1),
        "finished": now(),
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
                "message": bucket.message,
                "runs": len(bucket.records),
                "first_replay": bucket.records[0].replay,
                "keys": [record.run.key for record in bucket.records],
            }
            for bucket in outcome.buckets
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
    return write_evidence(outcome.folder / NAME, content)


def _run(record: RunRecord) -> dict[str, object]:
    return {
        **asdict(record.run),
        "key": record.run.key,
        "passed": record.passed,
        "seconds": round(record.seconds, 1),
        "pairs_checked": record.counts["checked"] if record.counts else None,
        "bucket": None if record.passed else bucket_of(record),
        "errors": record.errors,
        "replay": record.replay,
        "log": record.log,
        "host": record.host,
        "job": record.job,
    }


def history_record(outcome: Outcome) -> NightlyRecord:
    """Return the line that the history keeps of a regression."""
    stamp = provenance()
    return NightlyRecord(
        date=now(),
        kind=outcome.regression.name,
        commit=stamp.git_commit,
        rtl_hash=stamp.rtl_hash,
        seed=outcome.state.seed,
        passed=not outcome.problems,
        pairs=outcome.checked,
        failures=len(outcome.failed),
        coverage_percent=outcome.coverage_percent,
        seconds=round(outcome.seconds, 1),
        pairs_per_second=round(outcome.checked / outcome.seconds, 1) if outcome.seconds else None,
    )
