"""Runs a sign-off: first what fails soonest, part by part, then what takes longest, two parts at a time.

A part by itself leaves a processor idle wherever it waits for the last of its builds or its trials.

What is built has the name of what it is built of, which is read after that was hashed. So a file that was
edited meanwhile, and back, leaves what it never was: nothing is taken that was built before, and nothing that
goes in may be written to from then on.
"""

import os
import re
import shutil
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from threading import Event

from filelock import FileLock

from triaxis.coverage.report import ModelReport
from triaxis.golden.native import BUILD as NATIVE
from triaxis.sim.evidence import Timeline
from triaxis.sim.paths import BUILD, ROOT
from triaxis.sim.simulators import ICARUS
from triaxis.sim.validity import standing
from triaxis.verif.code_coverage.run import STEPS as CODE_COVERAGE_STEPS
from triaxis.verif.faults.catching import signed_off_names
from triaxis.verif.formal.proving import proof_names
from triaxis.verif.mutation.catalogue import mutant_names
from triaxis.verif.signoff import simulation
from triaxis.verif.signoff.gate import SOURCES
from triaxis.verif.signoff.parts import (
    Evidence,
    Part,
    attempt,
    beside_steps,
    code_coverage_part,
    exhaustive_part,
    faults_part,
    lint_part,
    make_beside,
    mutation_part,
    proofs_part,
    results_beside,
)
from triaxis.verif.signoff.plan import VOLUME
from triaxis.verif.signoff.result import Signoff
from triaxis.verif.signoff.testplan import testplan_part
from triaxis.verif.signoff.verify import PARTS

# Folders of what is built, a folder each with a lock beside it.
_BUILT = (
    "library", "simulation", "elaborated", "runtime", "mutation", "faults", "coverage", ICARUS, "netlist",
    "netlist/synthesis",
)  # fmt: skip
# Named by a hash of what they are of; outcomes of mutants, which lie beside them, are not.
_OF_A_BUILD = re.compile(r"-[0-9a-f]{12}$")
# By which Python, the loader, the compiler, cocotb or Coq take other files than those that are installed, or
# bytecode that was there before; by which cocotb takes what is unknown for a number.
_VARIABLES = (
    "PYTHONPATH", "PYTHONHOME", "PYTHONUSERBASE", "PYTHONPYCACHEPREFIX", "LD_PRELOAD", "LD_AUDIT",
    "LD_LIBRARY_PATH", "CPATH", "CPLUS_INCLUDE_PATH", "LIBRARY_PATH", "COMPILER_PATH", "GCC_EXEC_PREFIX",
    "CXXFLAGS", "CPPFLAGS", "LDFLAGS", "GPI_EXTRA", "GPI_USERS", "PYGPI_USERS", "PYGPI_PYTHON_BIN",
    "COCOTB_RESOLVE_X", "COCOTB_TRUST_INERTIAL_WRITES", "COQPATH", "COQLIB",
)  # fmt: skip
_PACKAGES = ("golden", "sim", "coverage", "fpga", "host", "verif", "bench")


def step_count(seed: int, volume: int, whole: bool = False) -> int:
    """Return how many steps a sign-off has."""
    return (
        simulation.step_count(seed, volume)
        + CODE_COVERAGE_STEPS
        + len(signed_off_names())
        + len(proof_names())
        + len(mutant_names())
        + (beside_steps(seed) if whole else 0)
    )


def signoff(
    seed: int,
    progress: Callable[[int], None],
    volume: int = VOLUME,
    whole: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> Signoff:
    """Run everything; ``progress`` is told of each step done, ``say`` of each part that begins or ends.

    ``whole``: four states and the netlist too, first; then nothing may be absent, nor taken from a record.
    """
    start, timeline = time.monotonic(), Timeline()
    variables = tuple(name for name in _VARIABLES if os.environ.get(name))
    # First: to forget waits for whoever builds, and what is loaded here is of before.
    before = standing(SOURCES)
    _forget_builds()
    parts: dict[str, Part] = {}
    coverage: list[ModelReport] = []

    def simulated() -> Evidence:
        found = simulation.simulate(seed, progress, volume)
        coverage.extend(found.coverage)
        return simulation.as_evidence(found, seed, volume)

    def run_parts(makers: Mapping[str, Callable[[], Evidence | None]]) -> None:
        for name, make in makers.items():
            title, began = name.replace("_", " "), time.monotonic()
            say(f"{title} begins")
            with timeline.span(name):
                parts[name] = attempt(make)
            say(f"{title}: {parts[name].state}, {time.monotonic() - began:.0f} s")

    ended = Event()

    def until_ended(steps: int) -> None:
        if ended.is_set():
            raise KeyboardInterrupt
        progress(steps)

    beside: dict[str, Part] | None = None
    if whole:
        say("four states and netlist begin")
        with timeline.span("four_states_and_netlist"):
            beside = make_beside(seed, progress)
    run_parts({
        "lint": lint_part,
        "simulation": simulated,
        "exhaustive": lambda: exhaustive_part(seed),
    })  # fmt: skip
    with ThreadPoolExecutor(1) as second:
        others = second.submit(run_parts, {
            "code_coverage": lambda: code_coverage_part(seed, until_ended),
            "proofs": lambda: proofs_part(until_ended),
        })  # fmt: skip
        try:
            # Both in the main thread: they draw, and interrupts come here.
            run_parts({
                "faults": lambda: faults_part(seed, progress),
                "mutation": lambda: mutation_part(seed, progress, whole),
            })  # fmt: skip
            others.result()
        except BaseException:
            ended.set()
            raise
    run_parts({"testplan": lambda: testplan_part(parts, coverage or None)})
    ordered = {name: parts[name] for name in PARTS}
    seconds = time.monotonic() - start
    beside = results_beside() if beside is None else beside
    spans = tuple(sorted(timeline.spans, key=lambda span: span.begin))
    touched = not before.stands
    return Signoff(ordered, beside, before.valid_for, seed, volume, seconds, spans, whole, touched, variables)


def _forget_builds() -> None:
    for folder in (folder for name in _BUILT for folder in (BUILD / name).glob("*") if folder.is_dir()):
        if _OF_A_BUILD.search(folder.name):
            with FileLock(folder.with_name(folder.name + ".lock")):
                shutil.rmtree(folder, ignore_errors=True)
    # What Python keeps of our modules is in no hash, and simulators would run it. This process has.
    for kept in [kept for name in _PACKAGES for kept in (ROOT / name).rglob("__pycache__")]:
        shutil.rmtree(kept, ignore_errors=True)
    for library in NATIVE.glob("*.so"):
        library.unlink(missing_ok=True)
