"""Scenes of a real machining centre and of real parts, from files that are not part of the product.

The machine stands as its simulator assembles it, in units of 10 mm: head at z = 4, moving by 0.1 a millimetre
of Z; saddle and table at y = 7 and 8. The parts are put against each other in pairs.
"""

from pathlib import Path

import numpy as np

from triaxis.host.scenes import Scene
from triaxis.host.stl import Facets, read_stl

# Solids that are put against each other, and by how much of their length the first one is lifted.
_PARTS = (
    ("angle_block", "plate_holes", 0.0),
    ("idler_riser", "featuretype", 0.0),
    ("angle_block", "angle_block", 0.3),
)


def machine_solids(data: Path, z_mm: float) -> dict[str, Facets]:
    """Return the machine's solids by name, where they stand, the head at a position of its Z axis in mm."""
    solids = {path.stem: read_stl(path).facets for path in sorted((data / "vmc").glob("*.stl"))}
    places = {"head": (0, 0, 4 + 0.1 * z_mm), "saddle": (0, 7, 0), "table": (0, 8, 0)}
    return {name: facets + np.array(places.get(name, (0, 0, 0))) for name, facets in solids.items()}


def machine_scenes(data: Path) -> list[Scene]:
    """Return close scenes from the folder of real meshes; see `triaxis.host.mesh_data`."""
    machine, lowered = machine_solids(data, -250), machine_solids(data, -200)
    carousel, base, saddle = machine["carousel"], machine["base"], machine["saddle"]
    scenes = [
        Scene("carousel against arm", carousel, machine["arm"], True),
        Scene("carousel against head at Z = -250 mm", carousel, machine["head"], True),
        Scene("head against base at Z = -200 mm", lowered["head"], base, True),
        Scene("table against saddle", machine["table"], saddle, True),
        Scene("saddle against base", saddle, base, True),
    ]
    return scenes + [_parts(data / "parts", *names) for names in _PARTS]


def _parts(folder: Path, a: str, b: str, lift: float) -> Scene:
    """Return two parts with their centres together, the first one lifted along z."""
    first, second = (read_stl(folder / f"{name}.STL").facets for name in (a, b))
    first = first - first.mean((0, 1)) + np.array([0, 0, lift * np.ptp(first.reshape(-1, 3), 0).max()])
    lifted = f", lifted by {lift:.0%}" if lift else ""
    return Scene(f"{a} against {b}{lifted}", first, second - second.mean((0, 1)), True)
