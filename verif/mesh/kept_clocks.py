"""The clocks that fixed scenes take, as they are kept by configuration in kept_clocks.json beside this.

An engine that became slower still answers right: this is what notices it. New figures are kept by
`python -m triaxis.verif.mesh.kept_clocks CONFIGURATION ..`.
"""

import json
import sys
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.verif.testbench.failures import report_failure

KEPT = Path(__file__).with_suffix(".json")
TEST = "MeshClocksTest"
# By configuration and scene: clocks of loading A and B, and of each run.
Clocks = dict[str, list[int]]


def kept() -> dict[str, Clocks]:
    """Return what is kept."""
    return json.loads(KEPT.read_text()) if KEPT.exists() else {}


class FoundClocks:
    """The clocks of a run of the test, which are left in its folder whatever they are."""

    def __init__(self, config: str, folder: Path) -> None:
        """Begin with none."""
        self._config, self._file = config, _file(folder)
        self._kept = kept().get(config, {})
        self._found: Clocks = {}
        self._wrong = ""

    def add(self, scene: str, clocks: list[int]) -> None:
        """Take those of a scene."""
        self._found[scene] = clocks
        due = self._kept.get(scene)
        if clocks != due and not self._wrong:
            self._wrong = (
                f"{scene}: {clocks} clocks of loads and runs, {due or 'none'} are kept; if that is as it "
                f"should be: .venv/bin/python -m {__spec__.name} {self._config}"
            )
            report_failure(self._wrong)

    def check(self, left_out: str = "") -> None:
        """Raise AssertionError where any differ, or are missing, but for those whose names begin so."""
        self._file.write_text(json.dumps(self._found))
        missing = self._kept.keys() - self._found.keys()
        missing = {name for name in missing if not (left_out and name.startswith(left_out))}
        assert not self._wrong, self._wrong
        assert not missing, f"clocks are kept of scenes that there are not: {', '.join(sorted(missing))}"


def _file(folder: Path) -> Path:
    return folder / "clocks.json"


def main(configs: list[str]) -> None:
    """Run the test in some configurations, and keep what it finds."""
    # The simulator's process, which needs the rest, has no use for what starts it.
    from triaxis.verif.testbench.settings import BURST
    from triaxis.verif.testbench.simulation import run, run_settings

    known = kept()
    for config in configs:
        result = run(run_settings(TEST, config, 1, 1, agent=BURST))
        file = _file(Path(result.settings.folder))
        if not file.exists():
            raise InputError(f"{config}: no clocks were found: see {result.log}")
        known[config] = json.loads(file.read_text())
        _write(known)


def _write(known: dict[str, Clocks]) -> None:
    """Write a scene a line."""
    blocks = [
        f'  "{config}": {{\n' + ",\n".join(f'    "{name}": {at}' for name, at in clocks.items()) + "\n  }"
        for config, clocks in sorted(known.items())
    ]
    write_whole(KEPT, "{\n" + ",\n".join(blocks) + "\n}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
