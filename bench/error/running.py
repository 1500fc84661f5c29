"""The whole benchmark: every method on every workload, step by step, so that an interrupted run goes on."""

import hashlib
import platform
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from triaxis.bench import harness
from triaxis.bench.error.points import (
    MODES,
    WIDTHS,
    BulkPoint,
    CorePoint,
    Errors,
    OnGrid,
    PeerPoint,
    bulk_point,
    configuration,
    core_point,
    golden_ns,
    on_grid,
    peer_point,
)
from triaxis.bench.error.truth import Truth, exact_truth
from triaxis.bench.error.workloads import Workload, workloads
from triaxis.bench.harness import SOURCES, Progress, StoredSteps
from triaxis.bench.peers import TRIANGLE_PEERS
from triaxis.bench.peers.peer import Peer, present
from triaxis.fpga.dsp_count import DspCounts
from triaxis.golden.errors import InputError
from triaxis.host.scenes import mesh_data
from triaxis.sim.paths import BUILD, DUT
from triaxis.sim.validity import provenance

COUNT = 20_000


@dataclass(frozen=True)
class WorkloadResult:
    """All points of a workload, of whose pairs so many collide. ``peers``: those that are installed."""

    workload: Workload
    colliding: int
    core: list[CorePoint]
    bulk: list[BulkPoint]
    golden_ns: float
    peers: list[PeerPoint]


@dataclass(frozen=True)
class Measured:
    """Everything that was measured.

    ``dsps``: DSP48E1 of the core by width and mode. ``absent``: peers that are not there, and why.
    ``taken_up``: steps that an interrupted run had left.
    """

    seed: int
    real_meshes: bool
    dsps: dict[tuple[int, str], int]
    results: list[WorkloadResult]
    absent: dict[str, str]
    taken_up: int


class Benchmark:
    """A benchmark with its workloads, ready to be measured."""

    def __init__(self, seed: int) -> None:
        """Make the workloads."""
        data = mesh_data()
        self.real_meshes = data is not None
        self._seed = seed
        self._workloads = workloads(COUNT, seed, data)
        self._present, packages = present(TRIANGLE_PEERS)
        self._absent = {each.name: each.why_absent for each in packages if each.why_absent is not None}

    @property
    def steps(self) -> int:
        """Return the number of steps."""
        on_each = 1 + len(WIDTHS) + 1 + len(self._present)
        return len(WIDTHS) * len(MODES) + len(self._workloads) * on_each

    def run(self, progress: Progress) -> Measured:
        """Measure everything; ``progress`` is told of each step."""
        steps = StoredSteps(harness.FOLDER / "error-steps", self._key(), progress)
        dsps = _dsps(progress)
        results: list[WorkloadResult] = []
        for workload in self._workloads:
            truth = exact_truth(workload.a, workload.b)
            progress(1)
            results.append(self._on_workload(workload, truth, steps))
        steps.finish()
        return Measured(self._seed, self.real_meshes, dsps, results, self._absent, steps.taken_up)

    def _key(self) -> str:
        """Return a hash of all that the results depend on."""
        state = provenance(SOURCES)
        texts = [state.rtl_hash, state.environment_hash, str(self._seed)]
        texts += [platform.platform(), platform.python_version(), *(version for _, version in self._present)]
        digest = hashlib.sha256("\0".join(texts).encode())
        for workload in self._workloads:
            digest.update(workload.a.tobytes() + workload.b.tobytes())
        return digest.hexdigest()

    def _on_workload(self, workload: Workload, truth: Truth, steps: StoredSteps) -> WorkloadResult:
        """Measure all methods on one workload."""

        def once(step: str, measure: partial[Any]) -> Any:
            return steps.once(f"{workload.name}-{step}", measure)

        found = [once(f"w{width}", partial(_at_width, workload, truth, width)) for width in WIDTHS]
        golden = once("golden", partial(golden_ns, workload))
        finest = on_grid(workload, WIDTHS[-1])
        peers = [
            once(peer.name, partial(_peer, peer, version, workload, finest, truth))
            for peer, version in self._present
        ]
        return WorkloadResult(
            workload,
            int(truth.near().sum()),
            [CorePoint(**_with_errors(point)) for points in found for point in points["core"]],
            [BulkPoint(**point) for points in found for point in points["bulk"]],
            float(golden),
            [PeerPoint(**_with_errors(point)) for point in peers],
        )


def _with_errors(stored: dict[str, Any]) -> dict[str, Any]:
    return {**stored, "errors": Errors(**stored["errors"])}


def _dsps(progress: Progress) -> dict[tuple[int, str], int]:
    counts = DspCounts(DUT, BUILD / "fpga" / "dsp_counts.json")
    found: dict[tuple[int, str], int] = {}
    for width in WIDTHS:
        for mode in MODES:
            build = configuration(width, mode)
            found[width, mode] = counts.core(build.width, build.margin_bits, build.edge_box).dsps
            progress(1)
    return found


def _at_width(workload: Workload, truth: Truth, width: int) -> dict[str, Any]:
    rounded = on_grid(workload, width)
    return {
        "core": [asdict(core_point(rounded, truth, width, mode)) for mode in MODES],
        "bulk": [asdict(bulk_point(rounded, width, mode)) for mode in MODES],
    }


def _peer(peer: Peer, version: str, workload: Workload, finest: OnGrid, truth: Truth) -> dict[str, Any]:
    try:
        return asdict(peer_point(peer, version, workload, finest, truth))
    # Of another's making, whatever it is.
    except Exception as error:
        what = f"fails on {workload.name}: {type(error).__name__}: {error}"
        raise InputError(
            f"{peer.name} {version}: {what}; install the version of requirements-peers.lock, or none"
        ) from error
