"""Where real meshes are, which are no part of the product."""

import os
from pathlib import Path

from triaxis.sim.paths import ROOT


def mesh_data() -> Path | None:
    """Return the folder of real meshes: $TRIAXIS_DATA, or ../shared/data; None where absent."""
    folder = Path(os.environ.get("TRIAXIS_DATA", ROOT.parent / "shared" / "data"))
    return folder if (folder / "vmc").is_dir() else None
