"""The seeds that failed, kept until they pass on other sources: what a regression replays first."""

import json
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.file_lock import locked
from triaxis.verif.regress.buckets import bucket_of
from triaxis.verif.regress.planned_run import PlannedRun, from_dict
from triaxis.verif.regress.run_record import RunRecord

NAME = "failing.json"
_FEW = 3


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
        with locked(self.path.with_suffix(".lock")):
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
    return FailingSeed(**{**content, "run": from_dict(content["run"])})


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
