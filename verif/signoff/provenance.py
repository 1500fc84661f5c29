"""What was signed off: the RTL and the commit."""

import subprocess
from dataclasses import dataclass

from triaxis.verif.build import rtl_hash
from triaxis.verif.paths import ROOT


@dataclass(frozen=True)
class Provenance:
    """What was signed off: taken before the first run, and compared after the last."""

    rtl_hash: str
    git_commit: str | None
    git_clean: bool | None


def provenance() -> Provenance:
    """Return what stands in the checkout now."""
    changed = _git("status", "--porcelain")
    return Provenance(rtl_hash(), _git("rev-parse", "HEAD"), None if changed is None else not changed)


def _git(*arguments: str) -> str | None:
    """Return what git answers, or None where this is no checkout."""
    try:
        answer = subprocess.run(
            ["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        return None
    return answer.stdout.strip() if answer.returncode == 0 else None
