"""Failures: grouped by what they say, and their seeds kept until they pass on other sources."""

import json
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from filelock import FileLock

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder, write_whole
from triaxis.verif.regress.records import PlannedRun, RunRecord, planned_run

NAME = "failing.json"
# Seeds of a bucket that a short regression replays.
_FEW = 3
_LONGEST = 160
# A bracket that the cut left open.
_OPEN = re.compile(r"\s*[(\[][^)\]]*$")
# What differs from run to run, and what stands for it; in this order.
_GENERAL = (
    # The simulator's time, and the level and place that its log puts before a message.
    (re.compile(r"^\s*[-\d.]+\s*[munpf]?s\s+"), ""),
    # Of a path its last name, however much of the rest the log shows.
    (re.compile(r"[\w.@+~-]*/(?:[\w.@+~-]+/)*"), ""),
    (re.compile(r"\b0[xX][0-9a-fA-F]+\b"), "HEX"),
    (re.compile(r"\b(?=[0-9a-f]*\d)(?=\d*[a-f])[0-9a-f]{8,}\b"), "HEX"),
    # Verdicts, and the pair itself: one fault answers many pairs wrongly, each in its own way.
    (re.compile(r"\((?=[^()]*\b(?:True|False)\b)[^()]*\)"), "(..)"),
    (re.compile(r": margin -?\d.*", re.DOTALL), ""),
    (re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"), "N"),
    # Arrays of any length look the same.
    (re.compile(r"\[+N[\[\]N,.\s]*"), "[..] "),
    (re.compile(r"\s+"), " "),
)


@dataclass(frozen=True)
class Bucket:
    """Failed runs that say the same."""

    message: str
    records: tuple[RunRecord, ...]


def general(message: str) -> str:
    """Return a message without what differs from run to run."""
    for pattern, substitute in _GENERAL:
        message = pattern.sub(substitute, message)
    message = message.strip()
    return message if len(message) <= _LONGEST else _OPEN.sub("", message[:_LONGEST])


def bucket_of(record: RunRecord) -> str:
    """Return the name of the bucket of a failed run: its first error line, made general."""
    said = general(record.errors[0]) if record.errors else "no error line"
    return f"ended without a result: {said.removeprefix('ERROR ')}" if record.silent else said


def buckets(records: Iterable[RunRecord]) -> list[Bucket]:
    """Return the failed runs in buckets, the fullest first."""
    found: dict[str, list[RunRecord]] = defaultdict(list)
    for record in records:
        if not record.passed:
            found[bucket_of(record)].append(record)
    grouped = [Bucket(message, tuple(group)) for message, group in found.items()]
    return sorted(grouped, key=lambda bucket: (-len(bucket.records), bucket.message))


@dataclass(frozen=True)
class FailingSeed:
    """A run that failed. ``identity``: the sources on which it last did; ``flaky``: it passed on them too."""

    run: PlannedRun
    identity: str
    bucket: str
    flaky: bool = False


class FailingSeeds:
    """The file in which they are kept. Several regressions may work on it at a time."""

    def __init__(self, path: Path) -> None:
        """Keep them in ``path``, which need not exist."""
        self.path = path

    def read(self) -> list[FailingSeed]:
        """Return them, the oldest first; raise InputError where the file is damaged."""
        try:
            text = self.path.read_text()
        except FileNotFoundError:
            return []
        try:
            return [_entry(content) for content in json.loads(text)]
        except (ValueError, TypeError, KeyError) as error:
            raise InputError(f"{self.path}: damaged: {error!r}; remove it to forget its seeds") from error

    def note(self, records: Iterable[RunRecord]) -> None:
        """Take in results: what failed is kept, what passed on other sources than it failed on is dropped.

        A run that left no result of its own changes nothing: it is simply run again.
        """
        new = {record.run.key: record for record in records if not record.silent}

        def change(entries: list[FailingSeed]) -> list[FailingSeed]:
            known = {entry.run.key for entry in entries}
            kept = [after for entry in entries if (after := _after(entry, new.get(entry.run.key)))]
            added = [_failing(r) for key, r in new.items() if not r.passed and key not in known]
            return kept + added

        self._change(change)

    def forget(self) -> list[FailingSeed]:
        """Drop them all, and return what was dropped."""
        forgotten: list[FailingSeed] = []

        def change(entries: list[FailingSeed]) -> list[FailingSeed]:
            forgotten.extend(entries)
            return []

        self._change(change)
        return forgotten

    def _change(self, change: Callable[[list[FailingSeed]], list[FailingSeed]]) -> None:
        make_folder(self.path.parent)
        with FileLock(self.path.with_suffix(".lock")):
            before = self.read()
            after = change(before)
            if after != before:
                write_whole(self.path, json.dumps([asdict(entry) for entry in after], indent=1) + "\n")


def few_of_each_bucket(seeds: Iterable[FailingSeed]) -> list[FailingSeed]:
    """Return at most three seeds of each bucket, those of the fewest pairs, in the order given."""
    every = list(seeds)
    taken: set[str] = set()
    counts: Counter[str] = Counter()
    for seed in sorted(every, key=lambda seed: seed.run.pairs):
        counts[seed.bucket] += 1
        if counts[seed.bucket] <= _FEW:
            taken.add(seed.run.key)
    return [seed for seed in every if seed.run.key in taken]


def _entry(content: dict[str, Any]) -> FailingSeed:
    return FailingSeed(**{**content, "run": planned_run(content["run"])})


def _failing(record: RunRecord) -> FailingSeed:
    return FailingSeed(record.run, record.identity, bucket_of(record))


def _after(entry: FailingSeed, record: RunRecord | None) -> FailingSeed | None:
    """Return what is left of an entry after a result of its run, None: nothing."""
    if record is None:
        return entry
    if not record.passed:
        same = record.identity == entry.identity
        return replace(_failing(record), flaky=entry.flaky and same)
    return replace(entry, flaky=True) if record.identity == entry.identity else None
