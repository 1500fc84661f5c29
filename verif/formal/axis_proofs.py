"""Proves, on the elaborated netlist, that the core tests the 32 axes of the definition, for all coordinates.

Words are read as `triaxis.verif.formal.algebra` says. Then, with the ports of the modules left closed:

- the interval test of axis n compares exactly the projections, by definition, of the six vertices on the
  axis, and its threshold is made of the components of that axis, up to signs, and of the margin;
- flags come from the normals and all orientations of four vertices;
- axis n arrives at bit n of the verdict, all 32 at one age, and the verdict at the queue at the age
  that the package documents, with the tag of its own pair;
- operands are taken exactly where the pair is valid and (with gating) its boxes do not decide it, and the
  flags are masked exactly where they do.

The closed modules (products of two numbers, thresholds, interval and box tests, flags, claim) have proofs of
their own, at the latencies that are used here.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

from triaxis.golden.axes import BOX_AXES
from triaxis.sim.configuration import Configuration
from triaxis.sim.packing import COORDINATES
from triaxis.verif.formal.algebra import DataPath, Inputs, Word
from triaxis.verif.formal.cone import Register, of_cells
from triaxis.verif.formal.definition import (
    FIRST_PLANE_AXIS,
    MARGIN,
    VARIABLES,
    ZERO,
    Axis,
    axes,
    extremes,
    is_test_of,
    missing_of_plane,
    normals,
    same_up_to_signs,
    variable,
)
from triaxis.verif.formal.netlist import Bit, Cell, Netlist, NetlistError, elaborate
from triaxis.verif.formal.proof import Finding, Proof, prove_each
from triaxis.verif.testbench.rtl_package import Package

_CLOSED = (
    "triaxis_mul", "triaxis_threshold", "triaxis_interval", "triaxis_box", "triaxis_flags", "triaxis_verdict",
)  # fmt: skip

_VERDICT_BITS = 9


class _AxisProof:
    """Compares the closed modules' inputs with the definition. Raises NetlistError where they differ."""

    def __init__(self, netlist: Netlist, inputs: Inputs, core: Configuration, dut: Path) -> None:
        """Take an elaborated core."""
        self._netlist, self._inputs, self._core = netlist, inputs, core
        self._dut = dut
        self._path = DataPath(netlist, inputs, Package(dut), core.width, core.margin_bits)

    def origin(self, bit: Bit) -> tuple[Bit, int]:
        """Return the net that a bit comes from through registers, and the clocks since."""
        return self._path.origin(bit)

    def registers(self) -> frozenset[Register]:
        """Return the registers that values, conditions and tags were followed through."""
        return of_cells(self._path.registers(), self._netlist.top, self._dut)

    def verdict_age(self) -> int:
        """Prove everything up to the verdict; return its age."""
        self._parameters()
        cell = self._only("triaxis_verdict")
        bits = cell.ports["separated_i"]
        last = len(axes()) if self._core.edge_box else FIRST_PLANE_AXIS
        ages = {self._axis(number, bits[number]) for number in range(last)}
        if set(bits[last:]) - {"0"}:
            raise NetlistError("the edge x box axes are left out, and yet arrive")
        ages.add(self._flags(cell))
        ages |= self._mask(cell)
        self._gates()
        if len(ages) != 1:
            raise NetlistError(f"{cell.name}: axes and flags of several clocks meet, {sorted(ages)}")
        return ages.pop() + self._path.latency("VerdictLatency")

    def _parameters(self) -> None:
        """Prove that the closed modules are built for the core's width and margin, registered all or none."""
        wanted = {"W": self._core.width, "M": self._core.margin_bits}
        closed = [cell for cell in self._netlist.cells if cell.kind in _CLOSED]
        for cell in closed:
            for name, value in wanted.items():
                if cell.parameters.get(name, value) != value:
                    raise NetlistError(f"{cell.name}: its {name} is not the core's, {value}")
        if len({cell.parameters["Comb"] for cell in closed if "Comb" in cell.parameters}) != 1:
            raise NetlistError(f"{self._netlist.top}: modules with registers and without")

    def _only(self, kind: str) -> Cell:
        found = [cell for cell in self._netlist.cells if cell.kind == kind]
        if len(found) != 1:
            raise NetlistError(f"{self._netlist.top}: {len(found)} modules {kind} instead of one")
        return found[0]

    # --- Axes ---------------------------------------------------------------------------------------

    def _axis(self, number: int, bit: Bit) -> int:
        """Prove that a bit tests the axis of that number; return its age."""
        source, age = self._path.origin(bit)
        driver = self._netlist.drivers.get(source)
        kind = "triaxis_box" if number < BOX_AXES else "triaxis_interval"
        if driver is None or driver[0].kind != kind:
            raise NetlistError(f"axis {number}: its bit comes from no {kind}")
        test = self._box if number < BOX_AXES else self._interval
        return age + test(driver[0], axes()[number])

    def _box(self, cell: Cell, axis: Axis) -> int:
        points = [self._path.elements(cell, port, 3) for port in ("a_i", "b_i")]
        for found, wanted in zip(points, (axis.on_a, axis.on_b), strict=True):
            if {word.polynomial for word in found} != set(wanted):
                raise NetlistError(f"{cell.name}: not the coordinates of its axis")
        margin = self._margin(cell.ports["margin_i"], cell.name)
        age = self._path.common_age(cell.name, *points[0], *points[1], margin)
        return age + self._path.latency("BoxLatency")

    def _interval(self, cell: Cell, axis: Axis) -> int:
        own = self._path.exact(cell.ports["own_i"], cell.name)
        points = self._path.elements(cell, "points_i", cell.parameters["Points"])
        if not is_test_of(axis, own.polynomial, [word.polynomial for word in points]):
            raise NetlistError(f"{cell.name}: what it compares are not the projections on its axis")
        age = self._path.common_age(cell.name, own, *points)
        self._threshold(cell, axis, own, points, age)
        return age + self._path.latency("interval_latency", self._core.margin_bits)

    def _margin(self, bits: Sequence[Bit], where: str) -> Word:
        found = self._path.word(bits, where)
        wanted = variable(MARGIN) if self._core.margin_bits else ZERO
        if found.polynomial != wanted or found.bits != max(1, self._core.margin_bits):
            raise NetlistError(f"{where}: not the margin")
        return found

    def _threshold(self, cell: Cell, axis: Axis, own: Word, points: Sequence[Word], age: int) -> None:
        """Prove that a threshold is margin * |axis|1, due when it is needed, and that nothing overflows."""
        bits = cell.ports["threshold_i"]
        if not self._core.margin_bits:
            if set(bits) - {"0", "x"}:
                raise NetlistError(f"{cell.name}: a threshold without margins")
            return
        found = self._path.output(bits, "triaxis_threshold", "threshold_o")
        if found is None:
            raise NetlistError(f"{cell.name}: its threshold is not one of triaxis_threshold")
        source, late = found
        components = self._path.elements(source, "axis_i", source.parameters["Components"])
        margin = self._margin(source.ports["margin_i"], source.name)
        if not same_up_to_signs([word.polynomial for word in components], axis.vector):
            raise NetlistError(f"{source.name}: not the components of the axis of {cell.name}")
        size = source.parameters["CWidth"]
        start = self._path.common_age(source.name, *components, margin)
        due = start + self._path.latency("threshold_latency", len(components), size, self._core.margin_bits)
        if due + late != age:
            raise NetlistError(f"{cell.name}: its threshold comes at another clock than its points")
        self._room(cell, source, own, points, axis)

    def _room(self, cell: Cell, source: Cell, own: Word, points: Sequence[Word], axis: Axis) -> None:
        """Prove that the sum of absolutes and the moved bounds fit, by their largest values at corners."""
        side = (1 << self._core.width) - 1
        margin = (1 << self._core.margin_bits) - 1
        norm, reach, degree = extremes(axis, (own.polynomial, *(word.polynomial for word in points)))
        if norm * side ** (degree - 1) >= 1 << source.parameters["CWidth"]:
            raise NetlistError(f"{source.name}: the sum of absolutes does not fit")
        if reach * side ** (degree - 1) * max(side, margin) >= 1 << (cell.parameters["Width"] - 1):
            raise NetlistError(f"{cell.name}: a bound moved by its threshold does not fit")

    # --- Flags and gates ------------------------------------------------------------------------------

    def _flags(self, verdict: Cell) -> int:
        cell = self._only("triaxis_flags")
        for name in ("degenerate_a", "degenerate_b", "coplanar"):
            if verdict.ports[f"{name}_i"] != cell.ports[f"{name}_o"]:
                raise NetlistError(f"{verdict.name}: {name} is not that of {cell.name}")
        found = [self._path.elements(cell, f"normal_{name}_i", 3) for name in ("a", "b")]
        for words, normal in zip(found, normals(), strict=True):
            if not same_up_to_signs([word.polynomial for word in words], normal):
                raise NetlistError(f"{cell.name}: not the normal")
        flat = self._path.elements(cell, "flat_a_i", 3) + self._path.elements(cell, "flat_b_i", 3)
        flat += self._path.elements(cell, "flat_edges_i", 9)
        if missing := missing_of_plane([word.polynomial for word in flat]):
            raise NetlistError(f"{cell.name}: {missing}")
        waits = [cell.parameters[name] for name in ("NormalWait", "DetWait")]
        ages = {
            self._path.common_age(cell.name, *found[0], *found[1]) + waits[0],
            self._path.common_age(cell.name, *flat) + waits[1],
        }
        if len(ages) != 1:
            raise NetlistError(f"{cell.name}: flags of several clocks")
        return ages.pop()

    def _box_bits(self, leaves: Iterable[Bit]) -> dict[Bit, tuple[str, int]]:
        """Return what each net of a condition is, and its age: a box axis by name, or "valid"."""
        known: dict[Bit, tuple[str, int]] = {}
        boxes = self._only("triaxis_verdict").ports["separated_i"][:BOX_AXES]
        names = {self._path.origin(bit)[0]: f"box {number}" for number, bit in enumerate(boxes)}
        names[self._inputs.valid] = "valid"
        for leaf in leaves:
            source, age = self._path.origin(leaf)
            if source not in names:
                raise NetlistError(f"{self._netlist.top}: net {leaf} decides on operands or flags")
            driver = self._netlist.drivers.get(source)
            if driver is not None and driver[0].kind == "triaxis_box":
                number = int(names[source].split()[1])
                age += self._box(driver[0], axes()[number])
            known[leaf] = names[source], age
        return known

    def _mask(self, verdict: Cell) -> set[int]:
        """Prove that flags are masked where the boxes decide; return the ages of what says so."""
        bit = verdict.ports["gated_i"][0]
        if not self._core.gating or self._path.latency("VerdictLatency") == 0:
            if bit != "0":
                raise NetlistError(f"{verdict.name}: flags are masked without operand gating")
            return set()
        return self._condition(bit, {"box 0", "box 1", "box 2"}, lambda on: any(on.values()))

    def _gates(self) -> None:
        """Prove that operands are taken where they are wanted, and at the pair's own clock."""
        names = {"valid"} | ({"box 0", "box 1", "box 2"} if self._core.gating else set())

        def wanted(on: Mapping[str, bool]) -> bool:
            return on["valid"] and not any(value for name, value in on.items() if name != "valid")

        for bit, age in sorted(self._path.gates, key=str):
            if self._condition(bit, names, wanted) != {age}:
                raise NetlistError(f"{self._netlist.top}: operands are gated at another clock than their own")
        if self._path.latency("GateLatency") and not self._path.gates:
            raise NetlistError(f"{self._netlist.top}: no operand gate")

    def _condition(self, bit: Bit, names: set[str], wanted: Callable[[Mapping[str, bool]], bool]) -> set[int]:
        """Prove that a condition is the wanted function of those names; return its ages."""
        leaves, function = self._path.condition(bit)
        known = self._box_bits(leaves)
        if {name for name, _ in known.values()} != names:
            raise NetlistError(f"{self._netlist.top}: a gate depends on {sorted(known.values())}")
        for values in product((False, True), repeat=len(names)):
            on = dict(zip(sorted(names), values, strict=True))
            if function({leaf: on[name] for leaf, (name, _) in known.items()}) != wanted(on):
                raise NetlistError(f"{self._netlist.top}: a gate opens wrongly at {on}")
        return {age for _, age in known.values()}


def prove_core(configuration: Configuration, dut: Path, folder: Path) -> frozenset[Register]:
    """Prove a configuration of the core, from its ports to its queue; return the registers on the way.

    Raises NetlistError where it fails.
    """
    netlist = elaborate(dut, "triaxis_core", configuration.parameters, _CLOSED, folder)
    width, margin = configuration.width, configuration.margin_bits
    data, user = netlist.inputs["s_axis_tdata_i"], netlist.inputs["s_axis_tuser_i"]
    bits = {
        data[number * width + place]: (number, place)
        for number in range(COORDINATES)
        for place in range(width)
    }
    bits |= {bit: (MARGIN, place) for place, bit in enumerate(user[:margin])}
    inputs = Inputs(bits, netlist.nets["accept"][0])
    proof = _AxisProof(netlist, inputs, configuration, dut)
    age = proof.verdict_age()
    documented = Package(dut).call("datapath_latency", width, margin)
    if age != documented:
        raise NetlistError(f"triaxis_core: verdicts come after {age} clocks instead of {documented}")
    _check_queue(proof, netlist, inputs, user[margin:], age)
    return proof.registers()


def _check_queue(proof: _AxisProof, netlist: Netlist, inputs: Inputs, tag: tuple[Bit, ...], age: int) -> None:
    """Prove that the queue takes the verdict, the tag and the push of one pair at one clock."""
    data = netlist.nets["u_results.data_i"]
    verdict = next(cell for cell in netlist.cells if cell.kind == "triaxis_verdict")
    if data[:_VERDICT_BITS] != verdict.ports["verdict_o"]:
        raise NetlistError("triaxis_core: the queue does not take the verdict")
    if [proof.origin(bit) for bit in data[_VERDICT_BITS:]] != [(bit, age) for bit in tag]:
        raise NetlistError("triaxis_core: the queue takes the tag of another pair")
    if proof.origin(netlist.nets["u_results.push_i"][0]) != (inputs.valid, age):
        raise NetlistError("triaxis_core: the queue takes a verdict at another clock than its own")


def prove_detector(width: int, dut: Path, folder: Path) -> frozenset[Register]:
    """Prove the wrapper CollisionDetector; return as `prove_core`, raise NetlistError where it fails."""
    netlist = elaborate(dut, "CollisionDetector", {"W": width}, _CLOSED, folder)
    names = [f"{triangle}{vertex}_{k}" for triangle in "AB" for vertex in "123" for k in "xyz"]
    bits = {
        bit: (number, place)
        for number, name in zip(range(VARIABLES), names, strict=True)
        for place, bit in enumerate(netlist.inputs[name])
    }
    proof = _AxisProof(netlist, Inputs(bits, "1"), Configuration(width), dut)
    proof.verdict_age()
    verdict = next(cell for cell in netlist.cells if cell.kind == "triaxis_verdict")
    if netlist.outputs["CollisionOccurs"] != verdict.ports["verdict_o"][:1]:
        raise NetlistError("CollisionDetector: it does not put out whether the two are near")
    return proof.registers()


@dataclass(frozen=True)
class AxesProof(Proof):
    """The algebra of the core in some configurations, and of the wrapper in some widths."""

    configurations: tuple[Configuration, ...]
    detectors: tuple[int, ...]

    def attempt(self, dut: Path, folder: Path) -> Finding:
        """Prove all of them; see `Proof`."""
        jobs: dict[str, Callable[[Path], frozenset[Register]]] = {
            one.name: partial(prove_core, one, dut) for one in self.configurations
        }
        jobs |= {f"detector_w{width}": partial(prove_detector, width, dut) for width in self.detectors}
        return prove_each(self.name, jobs, folder)


def axes_proof(
    name: str, configurations: tuple[Configuration, ...], detectors: tuple[int, ...] = ()
) -> Proof:
    """Return the proof for these configurations of the core, and for the wrapper at these widths."""
    names = [configuration.name for configuration in configurations]
    names += [f"CollisionDetector w{width}" for width in detectors]
    return AxesProof(
        name,
        "The core tests exactly the 32 axes of the definition on exactly the pair's own vertices, margin and"
        " tag, without overflow, for all coordinates; verdicts come after exactly the documented latency.",
        "polynomial identities on the elaborated netlist",
        {"configurations": ", ".join(names)},
        (
            "multipliers, thresholds, interval and box tests, flags and claim do what their own proofs say, "
            "which are at the widths of W = 16 or smaller ones (`multiply_wide`: at all)",
        ),
        configurations,
        detectors,
    )
