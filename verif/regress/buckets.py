"""Failures grouped by what they say, numbers and paths aside."""

import re
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from triaxis.verif.regress.run_record import RunRecord

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
