"""What advice is asked about: meshes of which the first one moves, the volume they work in, what is wanted.

Lengths are in the unit of the files; ``unit`` is millimetres in one of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from triaxis.golden.errors import InputError
from triaxis.host.quantise import NOWHERE, Box, Vector, around, box_of, vector
from triaxis.host.stl import StlMesh

# Bases of the Halton sequence, one for each coordinate.
_BASES = (2, 3, 5)


@dataclass(frozen=True)
class NamedMesh:
    """A mesh and the file it comes from."""

    name: str
    mesh: StlMesh


@dataclass(frozen=True)
class Wanted:
    """What is wanted: no pair within the clearance missed, no false alarm further than the band beyond it."""

    clearance: Fraction
    band: Fraction
    unit: Fraction = Fraction(1)


@dataclass(frozen=True)
class AdviceScene:
    """Meshes in one frame. The first stands at ``move``, and goes from there by any offset within ``travel``.

    The others stay. ``volume`` holds all of them, over the whole travel.
    """

    meshes: tuple[NamedMesh, ...]
    move: Vector
    travel: Box
    volume: Box

    @property
    def moving(self) -> NamedMesh:
        """Return the mesh that moves."""
        return self.meshes[0]

    @property
    def others(self) -> tuple[NamedMesh, ...]:
        """Return those that stay."""
        return self.meshes[1:]

    @property
    def travels(self) -> bool:
        """Return whether the first mesh is moved further, by an offset that is rounded by itself."""
        return self.travel != (NOWHERE, NOWHERE)

    @property
    def rounding(self) -> Fraction:
        """Return what reading moved a coordinate of the first mesh and of another one, together, at most."""
        return self.moving.mesh.rounding + max(other.mesh.rounding for other in self.others)

    def reading(self, resolution: Fraction) -> Fraction:
        """Return what margins must cover besides the rounding of vertices: also that of the translation."""
        return self.rounding + (resolution / 2 if self.travels else 0)

    def positions(self, count: int) -> list[Vector]:
        """Return offsets within the travel: ``count`` points of the Halton sequence, or the only one."""
        if self.travel[0] == self.travel[1]:
            return [self.travel[0]]
        sides = list(zip(*self.travel, _BASES, strict=True))
        return [
            vector(low + (high - low) * _radical_inverse(number, base) for low, high, base in sides)
            for number in range(1, count + 1)
        ]


def _radical_inverse(number: int, base: int) -> Fraction:
    """Return the number with its digits mirrored at the point: the Halton sequence's coordinate."""
    value, place = Fraction(0), Fraction(1, base)
    while number:
        number, digit = divmod(number, base)
        value, place = value + digit * place, place / base
    return value


def advice_scene(
    meshes: Sequence[NamedMesh], move: Vector, travel: Box = (NOWHERE, NOWHERE), volume: Box | None = None
) -> AdviceScene:
    """Return the scene; without a volume, that of the meshes' boxes over the travel.

    Raises InputError where there is nothing to meet, or something stands outside the volume.
    """
    if len(meshes) < 2:
        raise InputError("scene: one mesh: name at least two STL files, the first being the one that moves")
    places = {mesh.name: _swept(mesh.mesh, move, travel) for mesh in meshes[:1]}
    # The same file may stand in it twice.
    boxes = [*places.items(), *((mesh.name, box_of(mesh.mesh.facets)) for mesh in meshes[1:])]
    if volume is None:
        volume = around([box for _, box in boxes])
    for name, box in boxes:
        _check_inside(name, box, volume)
    return AdviceScene(tuple(meshes), move, travel, volume)


def _swept(mesh: StlMesh, move: Vector, travel: Box) -> Box:
    """Return the box of all that a mesh passes; it is loaded where it stands without any offset."""
    low, high = box_of(mesh.facets, move)
    first = vector(a + min(t, Fraction(0)) for a, t in zip(low, travel[0], strict=True))
    return first, vector(b + max(t, Fraction(0)) for b, t in zip(high, travel[1], strict=True))


def _check_inside(name: str, box: Box, volume: Box) -> None:
    for k, axis in enumerate("xyz"):
        if box[0][k] < volume[0][k] or box[1][k] > volume[1][k]:
            raise InputError(
                f"{name}: reaches from {float(box[0][k]):g} to {float(box[1][k]):g} in {axis}, beyond the "
                f"volume's {float(volume[0][k]):g} to {float(volume[1][k]):g} (units of the files); enlarge "
                "--volume, or shorten the travel"
            )
