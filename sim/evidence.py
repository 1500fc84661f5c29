"""Evidence: the JSON files in which each part of a sign-off leaves its result, with what it is valid for.

Every file says ``passed``, ``problems`` (one line each), ``summary`` (one line), ``command`` and ``seconds``,
and carries the stamp; what else it holds is the part's own. What was not measured is null, never 0.
"""

import json
import os
import platform
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.validity import Sources, provenance

# What to do about a file that is none.
_AGAIN = "remove it, and run what wrote it again"
_REQUIRED = ("passed", "problems", "summary", "command", "seconds", "rtl_hash")


@dataclass(frozen=True)
class Span:
    """A piece of a run: its begin and its end in seconds since the run began, and the processor's seconds.

    Those of processes that ended meanwhile are among them, of other pieces too where several go on at a time.
    """

    name: str
    begin: float
    end: float
    cpu_seconds: float


class Timeline:
    """What the pieces of a run took, which begins here; no verdict is made of it."""

    def __init__(self) -> None:
        """Begin."""
        self._start = time.monotonic()
        self.spans: list[Span] = []

    @contextmanager
    def span(self, name: str) -> Iterator[None]:
        """Measure a piece, whatever ends it."""
        begin, before = time.monotonic() - self._start, sum(os.times()[:4])
        try:
            yield
        finally:
            end, after = time.monotonic() - self._start, sum(os.times()[:4])
            self.spans.append(Span(name, round(begin, 1), round(end, 1), round(after - before, 1)))


def write_evidence(path: Path, content: Mapping[str, Any], sources: Sources) -> Path:
    """Write a result of ``sources`` with its stamp (RTL, environment, commit, tools), whole or not at all.

    What ``content`` says of the RTL and the commit stands: a run that takes minutes must take them before it
    starts, or it would be evidence of what was edited meanwhile.
    """
    stamped = {**asdict(provenance(sources)), "python": platform.python_version(), **content}
    missing = [key for key in _REQUIRED if key not in stamped]
    if missing:
        raise ValueError(f"{path.name}: evidence without {', '.join(missing)}")
    return write_whole(path, json.dumps(stamped, indent=2) + "\n")


def read_evidence(path: Path) -> dict[str, Any] | None:
    """Return a result, None where there is none; raise InputError where it is damaged."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: not readable as evidence: {error}: {_AGAIN}") from error
    if not isinstance(content, dict) or any(key not in content for key in _REQUIRED):
        raise InputError(f"{path}: not evidence: it needs {', '.join(_REQUIRED)}: {_AGAIN}")
    return content
