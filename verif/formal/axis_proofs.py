"""The proofs by algebra: the core, and the combinational wrapper, each elaborated and compared."""

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.configuration import Configuration
from triaxis.sim.packing import COORDINATES
from triaxis.verif.formal.algebra import CLOSED, AxisProof, Core, Inputs
from triaxis.verif.formal.definition import MARGIN, VARIABLES
from triaxis.verif.formal.netlist import Bit, Netlist, NetlistError, Package, elaborate
from triaxis.verif.formal.proof import Finding

_VERDICT_BITS = 9


def prove_core(configuration: Configuration, dut: Path, folder: Path) -> None:
    """Prove a configuration of the core, from its ports to its queue; raise NetlistError where it fails."""
    netlist = elaborate(dut, "triaxis_core", configuration.parameters, CLOSED, folder)
    width, margin = configuration.width, configuration.margin_bits
    data, user = netlist.inputs["s_axis_tdata_i"], netlist.inputs["s_axis_tuser_i"]
    bits = {
        data[number * width + place]: (number, place)
        for number in range(COORDINATES)
        for place in range(width)
    }
    bits |= {bit: (MARGIN, place) for place, bit in enumerate(user[:margin])}
    inputs = Inputs(bits, netlist.nets["accept"][0])
    core = Core(width, margin, configuration.edge_box, configuration.gating)
    proof = AxisProof(netlist, inputs, core, dut)
    age = proof.verdict_age()
    documented = Package(dut).call("datapath_latency", width, margin)
    if age != documented:
        raise NetlistError(f"triaxis_core: verdicts come after {age} clocks instead of {documented}")
    _check_queue(proof, netlist, inputs, user[margin:], age)


def _check_queue(proof: AxisProof, netlist: Netlist, inputs: Inputs, tag: tuple[Bit, ...], age: int) -> None:
    """Prove that the queue takes the verdict, the tag and the push of one pair at one clock."""
    data = netlist.nets["u_results.data_i"]
    verdict = next(cell for cell in netlist.cells if cell.kind == "triaxis_verdict")
    if data[:_VERDICT_BITS] != verdict.ports["verdict_o"]:
        raise NetlistError("triaxis_core: the queue does not take the verdict")
    if [proof.origin(bit) for bit in data[_VERDICT_BITS:]] != [(bit, age) for bit in tag]:
        raise NetlistError("triaxis_core: the queue takes the tag of another pair")
    if proof.origin(netlist.nets["u_results.push_i"][0]) != (inputs.valid, age):
        raise NetlistError("triaxis_core: the queue takes a verdict at another clock than its own")


def prove_detector(width: int, dut: Path, folder: Path) -> None:
    """Prove the wrapper CollisionDetector; raise NetlistError where it fails."""
    netlist = elaborate(dut, "CollisionDetector", {"W": width}, CLOSED, folder)
    names = [f"{triangle}{vertex}_{k}" for triangle in "AB" for vertex in "123" for k in "xyz"]
    bits = {
        bit: (number, place)
        for number, name in zip(range(VARIABLES), names, strict=True)
        for place, bit in enumerate(netlist.inputs[name])
    }
    core = Core(width, 0, edge_box=True, gating=True)
    AxisProof(netlist, Inputs(bits, "1"), core, dut).verdict_age()
    verdict = next(cell for cell in netlist.cells if cell.kind == "triaxis_verdict")
    if netlist.outputs["CollisionOccurs"] != verdict.ports["verdict_o"][:1]:
        raise NetlistError("CollisionDetector: it does not put out whether the two are near")


@dataclass(frozen=True)
class AxesProof:
    """The algebra of the core in some configurations, and of the wrapper in some widths."""

    name: str
    configurations: tuple[Configuration, ...]
    detectors: tuple[int, ...] = ()
    claim: str = (
        "The core tests exactly the 32 axes of the definition on exactly the pair's own vertices, margin and"
        " tag, without overflow, for all coordinates; verdicts come after exactly the documented latency."
    )
    method: str = "polynomial identities on the elaborated netlist"
    assumptions: tuple[str, ...] = (
        "multipliers, thresholds, interval and box tests, flags and claim do what their own proofs say, "
        "which are at the widths of W = 16 or smaller ones (`multiply_wide`: at all)",
    )

    @property
    def parameters(self) -> Mapping[str, int | str]:
        """Return the configurations."""
        names = [configuration.name for configuration in self.configurations]
        names += [f"CollisionDetector w{width}" for width in self.detectors]
        return {"configurations": ", ".join(names)}

    def prove(self, dut: Path, folder: Path) -> Finding:
        """Prove all of them; see `Proof`."""
        if folder.exists():
            shutil.rmtree(folder)
        jobs: list[tuple[str, Callable[[Path], None]]] = [
            (one.name, partial(prove_core, one, dut)) for one in self.configurations
        ]
        jobs += [(f"detector_w{width}", partial(prove_detector, width, dut)) for width in self.detectors]
        problems, undecided = [], []
        for name, job in jobs:
            try:
                job(folder / name)
            except NetlistError as error:
                problems.append(f"{self.name}: {name}: {error}")
            except InputError as error:
                undecided.append(f"{self.name}: {name}: {error}")
        return Finding(tuple(problems), folder, {"netlists": len(jobs)}, tuple(undecided))
