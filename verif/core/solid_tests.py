"""The tests of the core that send facets of real solids, which the host software reads."""

from triaxis.host.scenes import mesh_pairs
from triaxis.verif.core.base_test import CoreTest
from triaxis.verif.core.sequences import ArraySequence
from triaxis.verif.core.stimulus.margins import at_any_margin
from triaxis.verif.core.uvm_tests import USUAL
from triaxis.verif.testbench.table import Runs, listed


@listed(
    "V2",
    Runs(USUAL, 20_000, 1000, seeds=2, smoke=("w16_m0",)),
    why_seeds="Two: the second hits one more bin, the third none.",
)
class SolidsTest(CoreTest):
    """Facet pairs of real solids that come close: tool holder and end mill, vise and workpiece."""

    async def stimulus(self) -> None:
        """Send facet pairs, the near ones first, at margins of every kind."""
        configuration = self.settings.configuration
        pairs = mesh_pairs(self.rng, self.settings.pairs, configuration.width)
        margins = at_any_margin(self.rng, pairs, configuration.max_margin)
        await self.send(ArraySequence(self.settings, pairs, margins))
