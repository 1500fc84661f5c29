"""The check of MetamorphicTest: variants of a pair, sent one after the other, are answered alike."""

from collections import deque

import numpy as np
from pyuvm import uvm_component, uvm_subscriber

from triaxis.coverage.core_sample import CoreSample
from triaxis.verif.core.metamorphic import Group, gated_flags_are_zero, groups_agree
from triaxis.verif.testbench.handles import settings_of


class MetamorphicCheck(uvm_subscriber):
    """Takes the answers in order, from the worker's thread; fails in check_phase."""

    def __init__(self, name: str, parent: uvm_component) -> None:
        """Start with nothing expected."""
        super().__init__(name, parent)
        self.gating = settings_of(self).configuration.gating
        self.compared = 0
        self.failed = 0
        # Groups that were sent and are not compared yet, with their numbers of pairs.
        self._due: deque[tuple[Group, int]] = deque()
        self._words = np.zeros(0, np.uint16)

    def expect(self, group: Group, bases: int) -> None:
        """Take note that the variants of so many pairs are about to be sent."""
        self._due.append((group, bases))

    def write(self, tt: CoreSample) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Compare what is complete."""
        self._words = np.concatenate([self._words, tt.words])
        while self._due and len(self._words) >= self._due[0][0].size * self._due[0][1]:
            group, bases = self._due.popleft()
            words, self._words = np.split(self._words, [group.size * bases])
            good = groups_agree(words, group)
            if self.gating:
                good &= gated_flags_are_zero(words).reshape(good.shape)
            self.compared += good.size
            self.failed += int((~good).sum())

    def check_phase(self) -> None:
        """Fail where variants were answered differently, or were not compared."""
        if self.failed:
            raise AssertionError(f"{self.failed} of {self.compared} variants answered unlike their pair")
        if self._due or len(self._words) or not self.compared:
            raise AssertionError(f"{self.compared} variants compared, {len(self._words)} answers left over")
