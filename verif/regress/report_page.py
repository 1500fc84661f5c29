"""The outcome of a regression as one HTML page that needs nothing else."""

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from triaxis.coverage.html import Marked, code, folded, mark, page, table
from triaxis.coverage.report import percent
from triaxis.golden.outputs import write_whole
from triaxis.sim.provenance import provenance
from triaxis.sim.toolchain import verilator
from triaxis.verif.regress.buckets import Bucket
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.regress.history import now
from triaxis.verif.regress.junit import NAME as JUNIT
from triaxis.verif.regress.outcome import Outcome
from triaxis.verif.regress.results_file import NAME as RESULTS
from triaxis.verif.regress.run_record import RunRecord

NAME = "report.html"


def write_report(outcome: Outcome) -> Path:
    """Write report.html in the regression's folder, whole or not at all."""
    path = outcome.folder / NAME
    write_whole(path, page(f"Triaxis: {outcome.regression.name}", _body(outcome)))
    return path


def _body(outcome: Outcome) -> Iterator[str]:
    yield f"<h1>Regression {outcome.regression.name}</h1>\n"
    verdict = mark("FAILED" if outcome.problems else "PASSED", not outcome.problems)
    yield f"<p class=verdict><b>{verdict}</b> {mark(outcome.summary, None)}</p>\n"
    yield f"<p>{code(outcome.command)}, finished {now()}</p>\n"
    yield from _stamp()
    if outcome.buckets:
        yield "<h2>Failure buckets</h2>\n"
        for bucket in outcome.buckets:
            yield from _bucket(bucket)
    if outcome.shortfalls:
        yield "<h2>Other problems</h2>\n<ul>"
        yield "".join(f"<li>{mark(problem, None)}\n" for problem in outcome.shortfalls)
        yield "</ul>\n"
    yield from _kept(outcome)
    yield "<h2>Configurations</h2>\n"
    yield from _configurations(outcome)
    yield "<h2>Runs</h2>\n"
    yield from _runs(outcome)
    yield from _links(outcome)


def _stamp() -> Iterator[str]:
    stamp = provenance()
    changed = {True: "", False: ", with changes", None: ""}[stamp.git_clean]
    commit = f"{stamp.git_commit or 'unknown'}{changed}"
    tool = mark(str(verilator()), None)
    yield f"<p>commit {code(commit)}, RTL {code(stamp.rtl_hash)}, Verilator {tool}</p>\n"


def _runs_in_words(count: int) -> str:
    return f"{count} run" if count == 1 else f"{count} runs"


def _bucket(bucket: Bucket) -> Iterator[str]:
    """Give what the first run said, and under it, folded, all of them."""
    first = bucket.records[0]
    said = (*first.errors[:1], *first.counterexamples[:1])
    yield f"<h3>{len(bucket.records)} x {mark(bucket.message, None)}</h3>\n<ul>"
    yield "".join(f"<li>{mark(line, None)}\n" for line in said)
    yield f"<li>{code(first.replay)}\n</ul>\n"
    shown = (
        (
            record.run.item,
            str(record.run.seed),
            Marked("<br>".join(mark(line, None) for line in (*record.errors, *record.counterexamples))),
            code(record.replay),
        )
        for record in bucket.records
    )
    rows = table(("test", "seed", "said", "replay"), shown)
    yield from folded(_runs_in_words(len(bucket.records)), rows)


def _kept(outcome: Outcome) -> Iterator[str]:
    if not outcome.replayed:
        return
    fixed, flaky = ({seed.run.key for seed in seeds} for seeds in (outcome.fixed, outcome.flaky))
    yield "<h2>Seeds that failed before, replayed first</h2>\n"
    rows: list[tuple[str, str, str, Marked]] = []
    for seed in outcome.replayed:
        key = seed.run.key
        now = "passes: fixed" if key in fixed else "flaky" if key in flaky else "still fails"
        rows.append((seed.run.item, str(seed.run.seed), seed.bucket, mark(now, key in fixed)))
    yield from table(("test", "seed", "failed with", "now"), rows)


def _configurations(outcome: Outcome) -> Iterator[str]:
    groups: dict[str, list[RunRecord]] = defaultdict(list)
    for record in outcome.records:
        groups[record.run.config].append(record)
    covered = {model.model: percent([model]) for model in outcome.coverage}
    rows = (
        (
            config,
            len(group),
            mark(sum(not r.passed for r in group), all(r.passed for r in group)),
            sum(r.checked for r in group),
            sum(r.judged for r in group),
            # Configurations that differ in their tags share a model.
            covered.get(model_of(config).name),
        )
        for config, group in groups.items()
    )
    yield from table(("configuration", "runs", "failed", "pairs checked", "judged", "coverage, %"), rows)


def _runs(outcome: Outcome) -> Iterator[str]:
    groups: dict[str, list[RunRecord]] = defaultdict(list)
    for record in outcome.records:
        groups[record.run.item].append(record)
    for item, group in groups.items():
        failed = sum(not record.passed for record in group)
        rows = (
            (
                str(record.run.seed),
                mark("passed" if record.passed else "FAILED", record.passed),
                record.checked if record.counts else None,
                round(record.seconds, 1),
                record.host + (f", job {record.job}" if record.job else ""),
                code(record.replay),
            )
            for record in sorted(group, key=lambda record: record.passed)
        )
        summary = f"{item}: {_runs_in_words(len(group))}" + (f", {failed} failed" if failed else "")
        headings = ("seed", "", "pairs checked", "seconds", "where", "replay")
        yield from folded(summary, table(headings, rows))


def _links(outcome: Outcome) -> Iterator[str]:
    own = [outcome.folder / name for name in (RESULTS, JUNIT, "coverage.html")]
    pages = [*own, *outcome.folder.glob("dvsim/**/reports/index.html")]
    found = sorted(str(path.relative_to(outcome.folder)) for path in pages if path.exists())
    if found:
        yield "<h2>More</h2>\n<ul>"
        yield "".join(f"<li><a href='{link}'>{link}</a>\n" for link in found)
        yield "</ul>\n"
