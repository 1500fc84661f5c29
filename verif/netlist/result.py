"""What comes of the netlists: runs on them, proofs of modules, and the file that keeps both."""

import re
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass
from pathlib import Path

from triaxis.golden.outputs import make_folder
from triaxis.golden.processes import threads
from triaxis.sim.board_parameters import is_board_configuration
from triaxis.sim.build import rtl_files
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import DUT
from triaxis.sim.programs import yosys_version
from triaxis.sim.validity import Sources, Validity, standing
from triaxis.verif.formal.proof import Outcome, require_tools
from triaxis.verif.formal.proving import outcome_of
from triaxis.verif.netlist.gates import FOLDER, NOT_SIMULATED, SCOPES, Scope, run_on_gates
from triaxis.verif.netlist.module_proofs import NOT_PROVED, PROOFS
from triaxis.verif.testbench.settings import BOARD_TESTS, CORE_TESTS, ENTRY, MESH_TESTS, TEST_DATA
from triaxis.verif.testbench.simulation import RunResult
from triaxis.verif.testbench.table import table

RESULT = FOLDER / "netlist.json"
_MODULE = re.compile(r"^module (\w+)", re.MULTILINE)
# The tests are loaded by name.
SOURCES = Sources(
    ("triaxis.verif.netlist.result", ENTRY, *CORE_TESTS, *MESH_TESTS, *BOARD_TESTS),
    ("verif/netlist/*.vh", *TEST_DATA),
)


@dataclass(frozen=True)
class GateRun:
    """What came of a test on a netlist; None: it came to no count. ``told``: what speaks against it.

    ``pairs``: of the board, replies.
    """

    test: str
    config: str
    pairs: int | None
    differences: int | None
    told: tuple[str, ...]


def left_out(proved: Iterable[str], simulated: Iterable[str]) -> list[str]:
    """Return the modules of dut/, and the configurations of a sign-off, that are neither checked nor named
    with the reason why not, a line each.
    """
    texts = [path.read_text(encoding="utf-8") for path in rtl_files()]
    modules = {name for text in texts for name in _MODULE.findall(text)}
    signed = {
        config
        for entry in table().values()
        for configs in (*(runs.configs for runs in entry.runs if runs.signoff), entry.volume)
        for config in configs
    }
    silent = {
        "proved": modules.difference(proved, NOT_PROVED),
        "simulated as a netlist": signed.difference(simulated, NOT_SIMULATED),
    }
    return [
        f"{name}: neither {what}, nor named with the reason why not"
        for what, names in silent.items()
        for name in sorted(names)
    ]


def _of_board(run: GateRun) -> bool:
    return is_board_configuration(run.config)


def gate_run(scope: Scope, result: RunResult) -> GateRun:
    """Return what came of a run of ``scope``: a run on less than it asks for counts as failed."""
    counts = result.counts or {}
    pairs, failed = counts.get("checked"), counts.get("failed")
    told = () if result.passed else tuple(result.explain().splitlines())
    if result.passed and (pairs is None or pairs < scope.pairs):
        told = (f"{scope.config}: {pairs} pairs checked of {scope.pairs}",)
    return GateRun(scope.test, scope.config, pairs, failed, told)


@dataclass(frozen=True)
class NetlistResult:
    """What came of all runs and proofs.

    ``silent``: what is neither checked nor named with the reason why not, as `left_out` tells it.
    """

    runs: tuple[GateRun, ...]
    outcomes: tuple[Outcome, ...]
    seed: int
    seconds: float
    valid_for: Validity
    changed: bool = False
    silent: Sequence[str] = ()

    @property
    def problems(self) -> list[str]:
        """Return what speaks against the netlists, one line each."""
        found = [f"{run.config}: {line.strip()}" for run in self.runs for line in run.told]
        for outcome in self.outcomes:
            found += [
                *outcome.finding.problems,
                *(f"not decided: {why}" for why in outcome.finding.undecided),
            ]
        found += self.silent
        return [*found, "the RTL or its environment changed meanwhile"] if self.changed else found

    @property
    def passed(self) -> bool:
        """Return whether there were runs and proofs, and nothing speaks against any."""
        return bool(self.runs and self.outcomes) and not self.problems

    @property
    def pairs(self) -> int:
        """Return how many pairs were checked on netlists of the core and of the engine."""
        return sum(run.pairs or 0 for run in self.runs if not _of_board(run))

    @property
    def replies(self) -> int:
        """Return how many replies were checked on netlists of the board."""
        return sum(run.pairs or 0 for run in self.runs if _of_board(run))

    @property
    def differences(self) -> int | None:
        """Return how many answers were wrong; None where a run came to no count."""
        counted = [run.differences for run in self.runs if run.differences is not None]
        return sum(counted) if len(counted) == len(self.runs) else None

    @property
    def modules_proved(self) -> int:
        """Return how many modules were proved equal to their netlists."""
        return sum(outcome.passed for outcome in self.outcomes)

    @property
    def summary(self) -> str:
        """Return the result in a line."""
        differences = "unknown" if self.differences is None else self.differences
        proved = self.modules_proved
        others = len(NOT_PROVED)
        return (
            f"{self.pairs:,} pairs and {self.replies} replies of the board on {len(self.runs)} netlists, "
            f"{differences} differences; {proved} of {len(self.outcomes) + others} modules proved equal, "
            f"{others} named with the reason why not; so are {len(NOT_SIMULATED)} signed configurations "
            "of which no netlist is simulated"
        )


def check_all(seed: int, progress: Callable[[int], None], jobs: int = 2) -> NetlistResult:
    """Run the tests on the netlists, and prove modules equal to theirs: ``jobs`` of these at a time."""
    require_tools()
    modules = FOLDER / "modules"
    make_folder(modules)
    before, start = standing(SOURCES), time.monotonic()
    with threads(jobs) as pool:
        # What takes longest first.
        running = [pool.submit(run_on_gates, scope, seed) for scope in reversed(SCOPES)]
        proving = [pool.submit(outcome_of, proof, DUT, modules / proof.name) for proof in PROOFS]
        for done in as_completed([*running, *proving]):
            done.result()
            progress(1)
    results = [one.result() for one in reversed(running)]
    return NetlistResult(
        tuple(map(gate_run, SCOPES, results)), tuple(one.result() for one in proving), seed,
        time.monotonic() - start, before.valid_for, not before.stands,
        silent=left_out((proof.name for proof in PROOFS), (scope.config for scope in SCOPES)),
    )  # fmt: skip


def write_result(result: NetlistResult, command: str, path: Path = RESULT) -> Path:
    """Write the result of everything."""
    content = {
        "passed": result.passed,
        "problems": result.problems,
        "summary": result.summary,
        "command": command,
        "seconds": round(result.seconds, 1),
        "rtl_hash": result.valid_for.rtl_hash,
        "environment_hash": result.valid_for.environment_hash,
        "seed": result.seed,
        "synthesiser": yosys_version(),
        "pairs": result.pairs,
        "replies": result.replies,
        "differences": result.differences,
        "runs": [asdict(run) for run in result.runs],
        "not_simulated": NOT_SIMULATED,
        "modules_proved": result.modules_proved,
        "modules": [
            {
                "name": outcome.proof.name,
                "parameters": dict(outcome.proof.parameters),
                "claim": outcome.proof.claim,
                "assumptions": list(outcome.proof.assumptions),
                "method": str(outcome.proof.method),
                "proved": outcome.passed,
                "facts": dict(outcome.finding.facts),
                "seconds": round(outcome.seconds, 1),
            }
            for outcome in result.outcomes
        ],
        "not_proved": NOT_PROVED,
    }
    return write_evidence(path, content, SOURCES)
