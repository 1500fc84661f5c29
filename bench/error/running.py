"""The whole benchmark: every method on every workload, step by step, so that an interrupted run goes on."""

import hashlib
import platform
from dataclasses import asdict, dataclass
from typing import Any

from triaxis.bench import harness
from triaxis.bench.error.points import MODES, WIDTHS, CorePoint, Errors, configuration, core_point, on_grid
from triaxis.bench.error.software_points import BulkPoint, PeerPoint, bulk_point, golden_ns, peer_point
from triaxis.bench.error.truth import Truth, exact_truth
from triaxis.bench.error.workloads import Workload, workloads
from triaxis.bench.harness import Progress, StoredSteps
from triaxis.bench.peers import TRIANGLE_PEERS
from triaxis.bench.peers.peer import TrianglePeer, present
from triaxis.fpga.dsp_count import DspCounts
from triaxis.golden.errors import InputError
from triaxis.host.scenes import mesh_data
from triaxis.sim.paths import BUILD, DUT
from triaxis.sim.validity import Provenance

FOLDER = harness.FOLDER / "error-steps"
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

    def __init__(self, seed: int, before: Provenance, count: int = COUNT) -> None:
        """Make the workloads, of ``count`` pairs. ``before``: the checkout's state, to which steps belong."""
        data = mesh_data()
        self.real_meshes = data is not None
        self._seed, self._before = seed, before
        self._workloads = workloads(count, seed, data)
        self._present, packages = present(TRIANGLE_PEERS)
        self._absent = {each.name: each.why_absent for each in packages if each.why_absent is not None}

    @property
    def steps(self) -> int:
        """Return the number of steps."""
        on_each = 1 + len(WIDTHS) + 1 + len(self._present)
        return len(WIDTHS) * len(MODES) + len(self._workloads) * on_each

    def run(self, progress: Progress) -> Measured:
        """Measure everything; ``progress`` is told of each step."""
        steps = StoredSteps(FOLDER, self._key(), progress)
        dsps = _dsps(progress)
        results: list[WorkloadResult] = []
        for workload in self._workloads:
            truth = exact_truth(workload.a, workload.b)
            progress(1)
            results.append(_OnWorkload(workload, truth, steps).result(self._present))
        steps.finish()
        return Measured(self._seed, self.real_meshes, dsps, results, self._absent, steps.taken_up)

    def _key(self) -> str:
        """Return a hash of all that the results depend on."""
        state = [self._before.rtl_hash, self._before.environment_hash, str(self._seed)]
        machine = [platform.platform(), platform.python_version()]
        digest = hashlib.sha256()
        for text in (*state, *machine, *(version for _, version in self._present)):
            digest.update(text.encode() + b"\0")
        for workload in self._workloads:
            digest.update(workload.a.tobytes() + workload.b.tobytes())
        return digest.hexdigest()


def _dsps(progress: Progress) -> dict[tuple[int, str], int]:
    counts = DspCounts(DUT, BUILD / "fpga" / "dsp_counts.json")
    found: dict[tuple[int, str], int] = {}
    for width in WIDTHS:
        for mode in MODES:
            build = configuration(width, mode)
            found[width, mode] = counts.core(build.width, build.margin_bits, build.edge_box).dsps
            progress(1)
    return found


class _OnWorkload:
    """Measures all methods on one workload."""

    def __init__(self, workload: Workload, truth: Truth, steps: StoredSteps) -> None:
        self._workload, self._truth, self._steps = workload, truth, steps

    def result(self, peers: list[tuple[TrianglePeer, str]]) -> WorkloadResult:
        core: list[CorePoint] = []
        bulk: list[BulkPoint] = []
        for width in WIDTHS:
            found_core, found_bulk = self._at_width(width)
            core += found_core
            bulk += found_bulk
        golden = self._steps.once(f"{self._workload.name}-golden", lambda: {"ns": golden_ns(self._workload)})
        return WorkloadResult(
            self._workload,
            int(self._truth.near().sum()),
            core,
            bulk,
            float(golden["ns"]),
            [self._peer(*peer) for peer in peers],
        )

    def _at_width(self, width: int) -> tuple[list[CorePoint], list[BulkPoint]]:
        def measure() -> dict[str, Any]:
            rounded = on_grid(self._workload, width)
            return {
                "core": [asdict(core_point(rounded, self._truth, width, mode)) for mode in MODES],
                "bulk": [asdict(bulk_point(rounded, width, mode)) for mode in MODES],
            }

        found = self._steps.once(f"{self._workload.name}-w{width}", measure)
        core = [CorePoint(**{**point, "errors": Errors(**point["errors"])}) for point in found["core"]]
        return core, [BulkPoint(**point) for point in found["bulk"]]

    def _peer(self, peer: TrianglePeer, version: str) -> PeerPoint:
        def measure() -> dict[str, Any]:
            finest = on_grid(self._workload, WIDTHS[-1])
            try:
                return asdict(peer_point(peer, version, self._workload, finest, self._truth))
            # Of another's making, whatever it is.
            except Exception as error:
                what = f"fails on {self._workload.name}: {type(error).__name__}: {error}"
                raise InputError(
                    f"{peer.name} {version}: {what}; install the version of requirements-peers.lock, or none"
                ) from error

        found = self._steps.once(f"{self._workload.name}-{peer.name}", measure)
        return PeerPoint(**{**found, "errors": Errors(**found["errors"])})
