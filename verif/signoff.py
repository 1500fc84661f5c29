"""The sign-off run: every test in every configuration, scenes end to end, one result."""

import json
import os
import platform
import subprocess
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.coverage.core_model import CORE_MODEL
from triaxis.coverage.covergroup import PointReport, load, merge, report
from triaxis.golden.judge import judge_pairs
from triaxis.golden.pairs import Pairs, Verdicts, coordinate_range
from triaxis.golden.stl import read_stl
from triaxis.verif.build import library, rtl_hash, simulation
from triaxis.verif.configuration import Configuration
from triaxis.verif.detector import WIDTH, detect
from triaxis.verif.engine import RtlEngine, configuration_for
from triaxis.verif.meshcheck import check_meshes, prepare
from triaxis.verif.paths import BUILD, ROOT
from triaxis.verif.scenes import write_scenes, write_stl
from triaxis.verif.sequences.families import mixed_pairs
from triaxis.verif.sequences.seed_vectors import seed_normals, seed_vectors
from triaxis.verif.settings import RunSettings
from triaxis.verif.simulation import RunResult, run, run_settings
from triaxis.verif.toolchain import verilator

FOLDER = BUILD / "signoff"
RESULT = FOLDER / "signoff.json"
# A result is only worth its name with this many pairs checked.
LEAST_PAIRS = 200_000
SEED_VECTORS = 15
_DETECTOR_PAIRS = 3_000
_JOBS = min(2, os.cpu_count() or 1)

# Pairs of each test, in the builds with margins at every width. The counts follow what each family
# has to find: many shapes in few combinations for degenerate and coplanar pairs, protocol rather
# than geometry for stalls and resets.
_FULL = {
    "RandomTest": 8_000,
    "DegenerateTest": 8_000,
    "CoplanarTest": 8_000,
    "TouchingTest": 7_000,
    "ExtremesTest": 3_500,
    "OrdersTest": 4_320,
    "TinyTest": 3_000,
    "MeshTest": 3_000,
    "StallsTest": 2_500,
    "ResetsTest": 2_000,
    "FarTest": 1_500,
}
# The other builds share all arithmetic with one of those: they need what differs.
_OTHER = {
    "RandomTest": 2_000,
    "DegenerateTest": 2_000,
    "CoplanarTest": 2_000,
    "TouchingTest": 1_000,
    "StallsTest": 500,
    "ResetsTest": 500,
    "FarTest": 500,
}


@dataclass(frozen=True)
class SceneResult:
    """Two meshes, checked end to end through the RTL.

    ``agrees``: the golden model says the same of every tested pair.
    """

    name: str
    expected: str
    found: str
    agrees: bool
    pairs: int
    skipped: int
    tested: int
    near: int

    @property
    def passed(self) -> bool:
        """Return whether it came out as expected, and as the golden model says."""
        return self.agrees and self.found == self.expected


@dataclass(frozen=True)
class DetectorResult:
    """The combinational wrapper: seed vectors that it finds clear, and random pairs it gets wrong."""

    seed_vectors_clear: int
    pairs: int
    wrong: int


@dataclass(frozen=True)
class Provenance:
    """What was signed off: taken before the first run, and compared after the last."""

    rtl_hash: str
    git_commit: str | None
    git_clean: bool | None


@dataclass(frozen=True)
class SignoffResult:
    """Everything that the sign-off found; ``real_meshes`` is None where none were there."""

    runs: list[RunResult]
    scenes: list[SceneResult]
    real_meshes: list[SceneResult] | None
    detector: DetectorResult
    coverage: list[PointReport]
    provenance: Provenance
    seconds: float

    @property
    def checked(self) -> int:
        """Return how many pairs were compared with the golden model."""
        return sum(result.counts["checked"] for result in self.runs if result.counts)

    @property
    def problems(self) -> list[str]:
        """Return what stands against a pass, one line each."""
        found = [f"{r.settings.test} in {r.settings.config} failed" for r in self.runs if not r.passed]
        found += [
            f"scene {s.name}: {s.found}, expected {s.expected}"
            + ("" if s.agrees else "; the golden model disagrees")
            for s in self.scenes + (self.real_meshes or [])
            if not s.passed
        ]
        if not self.scenes:
            found.append("no scene was checked")
        if self.checked < LEAST_PAIRS:
            found.append(f"{self.checked} pairs checked, at least {LEAST_PAIRS} are wanted")
        if self.detector.seed_vectors_clear != SEED_VECTORS:
            found.append(f"{self.detector.seed_vectors_clear} of {SEED_VECTORS} seed vectors clear")
        if self.detector.wrong or not self.detector.pairs:
            found.append(f"CollisionDetector: {self.detector.wrong} of {self.detector.pairs} pairs wrong")
        found += [
            f"coverpoint {point.name}: {point.hit} of {point.total} bins hit"
            for point in self.coverage
            if point.missing
        ]
        if not self.coverage:
            found.append("no coverage was collected")
        if provenance() != self.provenance:
            found.append("the RTL or the checkout changed during the run")
        return found


def _settings(test: str, configuration: Configuration, seed: int, pairs: int) -> RunSettings:
    """Return a run in a folder of the sign-off's own, so that no other run disturbs it."""
    folder = FOLDER / "runs" / f"{test}-{configuration.name}"
    return run_settings(test, configuration, seed, pairs, folder=folder)


def plan(seed: int) -> list[RunSettings]:
    """Return every run of the sign-off."""
    runs: list[RunSettings] = []
    for width in (8, 16, 24, 32):
        configuration = Configuration(width, width)
        runs += [_settings(t, configuration, seed, n) for t, n in _FULL.items()]
        if width >= 16:
            runs.append(_settings("SeedVectorsTest", configuration, seed, SEED_VECTORS))
    runs.append(_settings("SeedVectorsTest", Configuration(16, 0), seed, SEED_VECTORS))
    for configuration in (
        Configuration(16, 0),
        Configuration(16, 0, edge_box=False),
        Configuration(16, 0, gating=False),
        Configuration(13, 4, tag_bits=1),
    ):
        runs += [_settings(t, configuration, seed, n) for t, n in _OTHER.items()]
    return runs


def signoff(seed: int, progress: Callable[[int], None], steps: Callable[[int], None]) -> SignoffResult:
    """Run everything; ``steps`` is told how many steps there are, ``progress`` of each done."""
    start = time.monotonic()
    # An old result must not outlive a run that ends early.
    RESULT.unlink(missing_ok=True)
    before = provenance()
    runs = plan(seed)
    configurations = list({r.config: r.configuration for r in runs}.values())
    libraries = [configuration_for(24, 1)]
    steps(len(configurations) + len(libraries) + len(runs) + 2)

    def one_build(build: Callable[[Configuration], Path], configuration: Configuration) -> None:
        build(configuration)
        progress(1)

    def one_run(settings: RunSettings) -> RunResult:
        result = run(settings)
        progress(1)
        return result

    with ThreadPoolExecutor(_JOBS) as pool:
        # The widest builds take longest: first.
        widest = sorted(configurations, key=lambda c: (-c.width, -c.margin_bits))
        builds = [pool.submit(one_build, simulation, c) for c in widest]
        builds += [pool.submit(one_build, library, c) for c in libraries]
        for build in builds:
            build.result()
        run_results = list(pool.map(one_run, runs))
    made, real = _scenes(), _real_meshes()
    progress(1)
    detector = _detector(seed)
    progress(1)
    # A run that passed has written its coverage: a missing file is an error here.
    counts = merge(CORE_MODEL, (load(r.coverage, CORE_MODEL) for r in run_results if r.passed))
    seconds = time.monotonic() - start
    return SignoffResult(run_results, made, real, detector, report(CORE_MODEL, counts), before, seconds)


def provenance() -> Provenance:
    """Return what stands in the checkout now."""
    changed = _git("status", "--porcelain")
    return Provenance(rtl_hash(), _git("rev-parse", "HEAD"), None if changed is None else not changed)


def _detector(seed: int) -> DetectorResult:
    """Check the wrapper on the seed vectors and on random pairs with random normals handed in."""
    clear = int((~detect(seed_vectors(WIDTH), seed_normals())).sum())
    rng = np.random.default_rng([seed, WIDTH])
    low, high = coordinate_range(WIDTH)
    pairs = mixed_pairs(rng, _DETECTOR_PAIRS, WIDTH)
    normals = rng.integers(low, high + 1, (_DETECTOR_PAIRS, 2, 3))
    near = judge_pairs(pairs, np.zeros(_DETECTOR_PAIRS, np.int64))["near"]
    return DetectorResult(clear, len(pairs), int((detect(pairs, normals) != near).sum()))


def _check_files(name: str, a: Path, b: Path, expected: bool, clearance: Fraction) -> SceneResult:
    """Check two STL files by the core, and compare every tested pair with the golden model."""
    meshes = prepare(read_stl(a), read_stl(b), (str(a), str(b)), Fraction(1, 1000), clearance, width=24)
    engine = RtlEngine(configuration_for(meshes.grid.width, meshes.margin))
    agrees = True

    def decide(pairs: Pairs, margins: npt.NDArray[np.int64]) -> Verdicts:
        nonlocal agrees
        verdicts = engine.verdicts(pairs, margins)
        agrees &= bool((verdicts == judge_pairs(pairs, margins)).all())
        return verdicts

    result = check_meshes(meshes, decide, listed=0)
    word = {True: "near", False: "clear"}
    return SceneResult(
        name,
        word[expected],
        word[result.near_count > 0],
        agrees,
        result.pairs,
        result.skipped,
        result.tested,
        result.near_count,
    )


def _scenes() -> list[SceneResult]:
    """Check the scenes that the project makes itself, written as STL files."""
    return [
        _check_files(scene.name, a, b, scene.near, Fraction(1, 2))
        for scene, a, b in write_scenes(FOLDER / "scenes")
    ]


def mesh_data() -> Path | None:
    """Return the folder of real meshes: $TRIAXIS_DATA, or ../shared/data; None where absent."""
    folder = Path(os.environ.get("TRIAXIS_DATA", ROOT.parent / "shared" / "data"))
    return folder if (folder / "vmc").is_dir() else None


def _real_meshes() -> list[SceneResult] | None:
    """Check parts of a real machine as its simulator assembles them; None where they are absent.

    Lengths in units of 10 mm. The head stands at z = 4 and moves down by 0.1 per millimetre.
    """
    data = mesh_data()
    if data is None:
        return None
    folder = FOLDER / "scenes"
    results = [
        _check_files(
            "carousel against arm",
            data / "vmc/carousel.stl",
            data / "vmc/arm.stl",
            True,
            Fraction(0),
        )
    ]
    for z_mm, near in ((0, False), (-250, True)):
        name = f"carousel against head at Z = {z_mm} mm"
        head = read_stl(data / "vmc/head.stl").facets + np.array([0, 0, 4 + 0.1 * z_mm])
        moved = folder / f"head_{abs(z_mm)}.stl"
        write_stl(moved, head.astype(np.float32))
        results.append(_check_files(name, data / "vmc/carousel.stl", moved, near, Fraction(1, 20)))
    return results


def _git(*arguments: str) -> str | None:
    """Return what git answers, or None where this is no checkout."""
    try:
        answer = subprocess.run(
            ["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        return None
    return answer.stdout.strip() if answer.returncode == 0 else None


def write_json(result: SignoffResult, seed: int) -> Path:
    """Write the result as build/signoff/signoff.json, whole or not at all."""
    content = {
        "passed": not result.problems,
        "problems": result.problems,
        "seed": seed,
        "seconds": round(result.seconds, 1),
        **asdict(result.provenance),
        "verilator": str(verilator()),
        "python": platform.python_version(),
        "command": f"triaxis signoff --seed {seed}",
        "pairs_checked": result.checked,
        "runs": [
            {
                "test": r.settings.test,
                "config": r.settings.config,
                "seed": r.settings.seed,
                "passed": r.passed,
                "seconds": round(r.seconds, 1),
                "counts": r.counts,
                "replay": r.settings.replay_command,
            }
            for r in result.runs
        ],
        "scenes": [asdict(s) for s in result.scenes],
        "real_meshes": None if result.real_meshes is None else [asdict(s) for s in result.real_meshes],
        "detector": asdict(result.detector),
        "coverage": {p.name: {"hit": p.hit, "total": p.total} for p in result.coverage},
    }
    FOLDER.mkdir(parents=True, exist_ok=True)
    partial = RESULT.with_suffix(".partial")
    partial.write_text(json.dumps(content, indent=2) + "\n")
    partial.replace(RESULT)
    return RESULT
