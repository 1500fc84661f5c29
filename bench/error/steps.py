"""Steps of a long measurement that survive an interruption: each leaves its result for the next run.

Results are valid for one state of everything that they depend on, named by a key; others are measured anew.
Once all is done they are removed: a run that nobody interrupted takes up nothing.
"""

import json
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from triaxis.golden.outputs import write_whole

Result = dict[str, Any]


class Steps:
    """The results of one measurement in a folder."""

    def __init__(self, folder: Path, key: str, progress: Callable[[int], None]) -> None:
        """Take up what is there under ``key``; ``progress`` is told of each step."""
        self._folder, self._key, self._progress = folder, key, progress
        self.taken_up = 0

    def once(self, name: str, make: Callable[[], Mapping[str, Any]]) -> Result:
        """Return the result of a step, made where it is not there; as JSON gives it back."""
        path = self._folder / f"{name}.json"
        result = self._stored(path)
        if result is None:
            write_whole(path, json.dumps({"key": self._key, "result": make()}) + "\n")
            result = self._stored(path)
            assert result is not None
        else:
            self.taken_up += 1
        self._progress(1)
        return result

    def _stored(self, path: Path) -> Result | None:
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        fits = isinstance(content, dict) and content.get("key") == self._key
        return content.get("result") if fits else None

    def finish(self) -> None:
        """Remove the results."""
        shutil.rmtree(self._folder, ignore_errors=True)
