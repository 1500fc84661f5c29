"""All proofs, by name: of the core, the mesh engine and the board, by assertions, algebra and Coq."""

from functools import cache

from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.sim.configuration import Configuration
from triaxis.verif.formal.axis_proofs import axes_proof
from triaxis.verif.formal.board_proofs import board_proofs
from triaxis.verif.formal.certifier_proof import certificate
from triaxis.verif.formal.coq import theorem
from triaxis.verif.formal.core_proofs import core_proofs
from triaxis.verif.formal.engine_proofs import engine_proofs
from triaxis.verif.formal.pieces import multiply_wide
from triaxis.verif.formal.proof import Proof
from triaxis.verif.formal.widths import widths

# What algebra proves, of the core as of the certifier: every width with its largest margin, some without.
_WITH_MARGINS = tuple(Configuration(width, width) for width in range(MIN_WIDTH, MAX_WIDTH + 1))
_WITHOUT = tuple(Configuration(width, 0) for width in (8, 13, 16, 24, 32))
_OTHER_CORES = (
    *_WITHOUT,
    Configuration(13, 4),
    Configuration(16, 8),
    Configuration(24, 10),
    # Margins by additions, and on the wider port of a multiplier.
    Configuration(32, 3),
    Configuration(32, 20),
    Configuration(16, 0, edge_box=False),
    Configuration(16, 0, gating=False),
)
# With margins on a narrower multiplier.
_CERTIFIERS = (*_WITH_MARGINS, *_WITHOUT, Configuration(16, 8), Configuration(32, 3))


@cache
def proofs() -> tuple[Proof, ...]:
    """Return all proofs, the longest of each kind first, so that two at a time end together."""
    return (
        *core_proofs(),
        *engine_proofs(),
        *board_proofs(),
        certificate(_CERTIFIERS),
        axes_proof("axes_margins", _WITH_MARGINS),
        axes_proof("axes_other", _OTHER_CORES, detectors=(8, 16, 32)),
        theorem(),
        multiply_wide(),
        widths(),
    )
