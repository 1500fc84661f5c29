"""Pairs and the results of a faultless core, for tests of the scoreboard's parts."""

import numpy as np

from triaxis.golden.bulk import bulk_facts
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.stimulus.families import mixed
from triaxis.verif.testbench.batches import PairBatch, ResultBatch


class Traffic:
    """Mixed pairs of a configuration, and their result words."""

    def __init__(self, rng, configuration, count):
        made = mixed(rng, count, configuration.width, configuration.max_margin)
        self.pairs, self.margins = made.pairs, made.margins
        self.tags = np.arange(count)
        self.words = expected_words(bulk_facts(self.pairs, self.margins), configuration)

    def sent(self, part=slice(None)):
        zeros = np.zeros(len(self.tags[part]), np.int64)
        return PairBatch(self.pairs[part], self.margins[part], self.tags[part], zeros)

    def returned(self, part=slice(None), words=None, tags=None):
        words = self.words if words is None else words
        tags = self.tags if tags is None else tags
        return ResultBatch(words[part], tags[part], np.zeros(len(tags[part]), np.int64))
