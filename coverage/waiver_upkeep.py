"""Upkeep of waivers and of exclusions: what no longer holds, and what a sign-off records of each.

Code coverage itself finds what only counters show: a waived bin that is hit, and a waiver that covers no
bin. Here is what shows without running again, so that the gate sees it too on a later day: a waiver whose
modules have changed, that is not well formed, or that is not the one that code coverage was measured with;
and patterns of a waiver that fit nothing any more.

Exclusions of functional coverage are proofs, see `triaxis.coverage.core_exclusions`: they do not expire,
because each run tries them again. A hit of an excluded bin is a problem of its `ModelReport`.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from triaxis.coverage.report import ModelReport
from triaxis.coverage.waivers import WAIVERS, Waiver, fit, module_code, read_waivers
from triaxis.golden.errors import InputError

Record = dict[str, Any]

_AGAIN = "run `triaxis coverage code` again"


@dataclass(frozen=True)
class WaivedPlace:
    """Where a waiver covers bins: the signal, for toggles, else the bin, and the line of the source."""

    model: str
    module: str
    instance: str
    what: str
    at: str = ""


def stale_patterns(waiver: Waiver, places: Iterable[WaivedPlace]) -> list[str]:
    """Return, where a waiver covers bins, a reason for each of its patterns that fits no place."""
    seen = set(places)
    texts: dict[str, set[str]] = {
        "modules": {place.module for place in seen},
        "instances": {place.instance for place in seen},
        "models": {place.model for place in seen},
        "what": {place.what for place in seen},
        "at": {place.at for place in seen},
        "signals": {place.what for place in seen},
    }
    return [
        f"{name}: {pattern}: fits no bin that it covers"
        for name, found in texts.items()
        if seen
        for pattern in getattr(waiver, name)
        if all(fit((pattern,), text) is None for text in found)
    ]


def waiver_records(waivers: Iterable[Waiver], bins: Mapping[int, int]) -> list[Record]:
    """Return what is recorded of each waiver: all of its fields, as JSON has them, and its bins.

    ``bins``: how many it covers, by its number.
    """
    return [{**_fields(waiver), "bins": bins.get(waiver.number, 0)} for waiver in waivers]


def _fields(waiver: Waiver) -> Record:
    """Return the fields by their names in the file."""
    fields = asdict(waiver)
    fields["range"] = fields.pop("values")
    fields |= {name: list(value) for name, value in fields.items() if isinstance(value, tuple)}
    return {**fields, "reason": waiver.reason.strip()}


def exclusion_records(reports: Iterable[ModelReport]) -> list[Record]:
    """Return what is recorded of each exclusion of functional coverage, by model and item."""
    return [
        {
            "model": one.model,
            "item": item.name,
            "category": group.exclusion.category,
            "kind": group.exclusion.kind.value,
            "reason": group.exclusion.reason,
            "owner": group.exclusion.owner,
            "proof": group.exclusion.test,
            "bins": group.bins,
            "hits": group.hits,
        }
        for one in reports
        for item in one.items
        for group in item.excluded
    ]


def other_rtl(waiver: Waiver, code: Mapping[str, str]) -> str | None:
    """Return that a waiver's modules are not those that its reason was read against; None: they are.

    ``code``: the RTL, as `module_code` gives it. What drives the modules may have changed too: where that
    matters a waived bin is hit, which fails the run.
    """
    if unknown := sorted({*waiver.rests_on} - {"*"} - code.keys()):
        return f"{', '.join(unknown)}: no such module: correct its name"
    if waiver.reviewed == waiver.hashes(code):
        return None
    return "its modules changed: read its reason again, then `triaxis coverage code --confirm-waivers`"


def waiver_problems(recorded: Sequence[Record] | None, path: Path = WAIVERS) -> list[str]:
    """Return what is wrong with the waivers as they stand, a line each.

    ``recorded``: those of the last measurement, as `waiver_records` gives them; None where there is none,
    which is no problem of the waivers.
    """
    try:
        waivers = read_waivers(path)
    except InputError as error:
        return [str(error)]
    code = module_code()
    found = [f"{waiver.name}: {said}" for waiver in waivers if (said := other_rtl(waiver, code))]
    return found if recorded is None else [*found, *_unlike(waivers, recorded)]


def _unlike(waivers: Sequence[Waiver], recorded: Sequence[Record]) -> Iterator[str]:
    """Give the waivers that are not as they were measured, and those that covered nothing."""
    if len(waivers) != len(recorded):
        yield f"{len(waivers)} waivers, measured with {len(recorded)}: {_AGAIN}"
        return
    for waiver, record in zip(waivers, recorded, strict=True):
        # From a file, so it may be anything.
        then: Any = record if isinstance(record, dict) else {}
        now = _fields(waiver)
        missing = [key for key in (*now, "bins") if key not in then]
        changed = [key for key, value in now.items() if key in then and then[key] != value]
        if missing:
            yield f"{waiver.name}: recorded without {', '.join(missing)}: {_AGAIN}"
        elif changed:
            yield f"{waiver.name}: {', '.join(changed)} changed since it was measured: {_AGAIN}"
        elif not then["bins"]:
            yield f"{waiver.name}: covers no bin"
