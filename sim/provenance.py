"""What was signed off, and by what: the RTL, its environment, the commit."""

import subprocess
from dataclasses import dataclass

from triaxis.sim.build import content_hash, rtl_hash
from triaxis.sim.paths import ROOT

_CHECKING = ("golden", "sim", "coverage", "host", "verif")
# A result, which checks nothing.
_RESULT = ROOT / "verif" / "mutation" / "result.json"
_SOURCES = (".py", ".cpp", ".h", ".sv", ".vlt", ".toml", ".json", ".hjson", ".csv", ".mk", ".patch", ".sh")


@dataclass(frozen=True)
class Provenance:
    """What was signed off: taken before the first run, and compared after the last."""

    rtl_hash: str
    environment_hash: str
    git_commit: str | None
    git_clean: bool | None


def provenance() -> Provenance:
    """Return what stands in the checkout now."""
    changed = _git("status", "--porcelain")
    return Provenance(
        rtl_hash(),
        _environment_hash(),
        _git("rev-parse", "HEAD"),
        None if changed is None else not changed,
    )


def _environment_hash() -> str:
    """Return the hash of everything that checks: a checkout that is not clean may change and stay so."""
    files = {path for folder in _CHECKING for path in (ROOT / folder).rglob("*") if path.suffix in _SOURCES}
    return content_hash(sorted(files - {_RESULT}))


def _git(*arguments: str) -> str | None:
    """Return what git answers, or None where this is no checkout."""
    try:
        answer = subprocess.run(
            ["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        return None
    return answer.stdout.strip() if answer.returncode == 0 else None
