"""The scoreboard: every accepted pair must be answered once, in order, as the golden model says."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pyuvm import uvm_analysis_export, uvm_analysis_port, uvm_component, uvm_scoreboard

from triaxis.verif.batches import PairBatch, ResetSeen, ResultBatch
from triaxis.verif.failing_pairs import write_failing_pairs
from triaxis.verif.handles import settings_of
from triaxis.verif.matching import Matcher
from triaxis.verif.settings import failure_file, result_file


class _Export(uvm_analysis_export):
    """An analysis export that hands transactions to a function: a scoreboard needs two of them."""

    def __init__(self, name: str, parent: uvm_component, write: Callable[[Any], None]) -> None:
        super().__init__(name, parent)
        self._write = write

    def write(self, datum: Any) -> None:
        """Hand the transaction on."""
        self._write(datum)


class Scoreboard(uvm_scoreboard):
    """Compares; fails the test in check_phase, writing what failed and how to replay it."""

    def build_phase(self) -> None:
        """Make the exports, the port for what was checked, and the matcher."""
        self.settings = settings_of(self)
        self.pairs_export = _Export("pairs_export", self, self._write_pairs)
        self.results_export = _Export("results_export", self, self._write_results)
        self.checked_port = uvm_analysis_port("checked_port", self)
        self.matcher = Matcher(self.settings.configuration, self.checked_port.write)

    def _write_pairs(self, datum: PairBatch | ResetSeen) -> None:
        if isinstance(datum, ResetSeen):
            self.matcher.reset_pairs()
        else:
            self.matcher.feed_pairs(datum)

    def _write_results(self, datum: ResultBatch | ResetSeen) -> None:
        if isinstance(datum, ResetSeen):
            self.matcher.reset_results()
        else:
            self.matcher.feed_results(datum)

    def extract_phase(self) -> None:
        """Close the run."""
        self.matcher.finish()

    def check_phase(self) -> None:
        """Write the counts, and fail where anything did."""
        matcher, folder = self.matcher, Path(self.settings.folder)
        counts = {
            "accepted": matcher.accepted,
            "returned": matcher.returned,
            "checked": matcher.checked,
            "clear_claims_rechecked": matcher.clear_claims,
            "discarded_by_reset": matcher.discarded,
            "resets": matcher.resets,
            "failed": matcher.failed,
        }
        result_file(folder).write_text(json.dumps(counts, indent=2) + "\n")
        if not matcher.failed:
            return
        for failure in matcher.failures:
            at = "" if failure.pair is None else f": margin {failure.margin}, {failure.pair.tolist()}"
            self.logger.error(f"{failure.message}{at}")
        pairs = [failure for failure in matcher.failures if failure.pair is not None]
        if pairs:
            write_failing_pairs(
                failure_file(folder),
                [failure.pair for failure in pairs if failure.pair is not None],
                [failure.margin for failure in pairs],
            )
        raise AssertionError(f"{matcher.failed} failures, first: {matcher.failures[0].message}")
