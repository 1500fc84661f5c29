"""Failures: grouped by what they say, and their seeds kept until they pass on other sources."""

import json
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
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
# What differs from run to run, and its substitute; in this order. dvsim's own buckets, in its report, keep
# paths, verdicts and pairs apart.
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


def buckets(records: Iterable[RunRecord]) -> dict[str, list[RunRecord]]:
    """Return the failed runs by what they say, the most frequent first."""
    found: dict[str, list[RunRecord]] = defaultdict(list)
    for record in records:
        if not record.passed:
            found[bucket_of(record)].append(record)
    return dict(sorted(found.items(), key=lambda bucket: (-len(bucket[1]), bucket[0])))


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
            return [_entry(content) for content in json.loads(self.path.read_text())]
        except FileNotFoundError:
            return []
        except (ValueError, TypeError, KeyError) as error:
            raise InputError(f"{self.path}: damaged: {error!r}; remove it to forget its seeds") from error

    def note(self, record: RunRecord) -> None:
        """Take in a result: what failed is kept, what passed on other sources than it failed on is dropped.

        A run that left no result of its own changes nothing: it is simply run again.
        """
        if record.silent:
            return
        with self._changing() as kept:
            key, before = record.run.key, kept.get(record.run.key)
            known = before if before and before.identity == record.identity else None
            if not record.passed:
                flaky = known is not None and known.flaky
                kept[key] = FailingSeed(record.run, record.identity, bucket_of(record), flaky)
            elif known:
                kept[key] = replace(known, flaky=True)
            else:
                kept.pop(key, None)

    def forget(self) -> list[FailingSeed]:
        """Drop them all, and return what was dropped."""
        with self._changing() as kept:
            forgotten = list(kept.values())
            kept.clear()
        return forgotten

    @contextmanager
    def _changing(self) -> Iterator[dict[str, FailingSeed]]:
        """Give the seeds by the keys of their runs, and write what the block makes of them."""
        make_folder(self.path.parent)
        with FileLock(self.path.with_suffix(".lock")):
            before = {seed.run.key: seed for seed in self.read()}
            after = dict(before)
            yield after
            if after != before:
                write_whole(self.path, json.dumps([asdict(one) for one in after.values()], indent=1) + "\n")


def _entry(content: dict[str, Any]) -> FailingSeed:
    return FailingSeed(**{**content, "run": planned_run(content["run"])})


def few_of_each_bucket(seeds: Iterable[FailingSeed]) -> list[FailingSeed]:
    """Return at most three seeds of each bucket, those of the fewest pairs."""
    found: dict[str, list[FailingSeed]] = defaultdict(list)
    for seed in sorted(seeds, key=lambda seed: seed.run.pairs):
        found[seed.bucket].append(seed)
    return [seed for bucket in found.values() for seed in bucket[:_FEW]]
