"""The widths of triaxis_pkg hold what they must, by enumeration of the corners of the coordinates.

That the enumeration sees a width that is too small or too large is shown with the other proofs.
"""

from triaxis.sim.paths import DUT
from triaxis.verif.formal.widths import WidthsProof


def test_widths_hold(tmp_path):
    finding = WidthsProof().prove(DUT, tmp_path)
    assert not finding.problems
    assert "orientation of four vertices: at most 2 L^3" in (tmp_path / "bounds.txt").read_text()
