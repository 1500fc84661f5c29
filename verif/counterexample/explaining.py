"""Failing pairs made small, drawn and kept, and said in a few lines."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.judge import CertificateError
from triaxis.sim.configuration import Configuration
from triaxis.sim.paths import BUILD, DUT, ROOT
from triaxis.verif.core.failing_pairs import FailingPair, read_failing
from triaxis.verif.core.kept_cases import FOUND, REGRESSIONS, RegressionCase, write_case
from triaxis.verif.counterexample.finding import BareCore, Counterexample, find
from triaxis.verif.testbench.failures import Blame
from triaxis.verif.testbench.settings import Block, RunSettings, failure_file
from triaxis.verif.testbench.simulation import RunResult, run

PICTURES = BUILD / "counterexamples"
# Failing pairs of a run that are tried: mostly they all show the same fault.
_TRIED = 3
_AT_ODDS = (
    "the bulk checker and the golden model are at odds: one of them is wrong, and what is called the exact "
    "answer is in doubt; look into golden/ before dut/"
)


@dataclass(frozen=True)
class Explanation:
    """What became of a failing pair; ``counterexample`` is None where it does not fail on the bare core.

    ``seen`` is set where an earlier pair led to the very same counterexample; then nothing is drawn.
    """

    before: FailingPair
    counterexample: Counterexample | None
    seen: bool = False
    picture: Path | None = None
    kept: Path | None = None

    def lines(self) -> Iterator[str]:
        """Yield what to tell the user."""
        yield f"before: {self.before.stream.describe()}"
        found = self.counterexample
        if found is None:
            yield "does not fail on the bare core: it takes stalls, resets, or other pairs before it"
            return
        yield f"after:  {found.stream.describe()}"
        if self.seen:
            yield "        (the same as before)"
            return
        yield f"        {found.configuration.name} {found.symptom.description}"
        yield f"        core said {found.core_said}, right is {found.right_answer}"
        if self.picture:
            yield f"        drawn: {self.picture}"
        if self.kept:
            yield f"        kept:  {self.kept}"
            if self.kept.parent == FOUND:
                place = REGRESSIONS.relative_to(ROOT)
                yield f"               for good: copy it to {place}/ and commit it"


def case_of(counterexample: Counterexample, fault: str = "") -> RegressionCase:
    """Return the case that keeps a counterexample; ``fault`` says what it revealed, where known."""
    symptom = counterexample.symptom
    found = {
        "configuration": counterexample.configuration.name,
        "symptom": symptom.name.lower(),
        "meaning": symptom.description,
        "core_said": counterexample.core_said,
        "right": counterexample.right_answer,
        "fault": fault,
    }
    return RegressionCase(counterexample.stream, found)


def explain(
    core: BareCore,
    failing: Iterable[FailingPair],
    pictures: Path,
    store: Path | None,
    fault: str = "",
    ending: str = ".png",
) -> Iterator[Explanation]:
    """Shrink failing pairs one by one; draw each new counterexample, and keep it in ``store`` if given."""
    # Where only the store is wanted, or nothing fails, Matplotlib need not load.
    from triaxis.verif.counterexample.picture import draw

    names: set[str] = set()
    for one in failing:
        found = find(core, one)
        if found is None:
            yield Explanation(one, None)
            continue
        case = case_of(found, fault)
        if case.name in names:
            yield Explanation(one, found, seen=True)
            continue
        names.add(case.name)
        picture = pictures / f"{found.configuration.name}-{case.name}{ending}"
        draw(found, picture)
        kept = None if store is None else write_case(case, store)
        yield Explanation(one, found, picture=picture, kept=kept)


def explain_failures(
    result_folder: Path, configuration: Configuration, dut: Path = DUT, store: Path | None = None
) -> tuple[str, ...]:
    """Return lines about the failing pairs of a failed run; () where the scoreboard kept none.

    The first few are shrunk on the bare core built from ``dut``, drawn into ``result_folder``, and kept
    in ``store`` if given. Never raises for a shrink that fails: says so in one line.
    """
    archive = failure_file(result_folder)
    if not archive.exists():
        return ()
    lines: list[str] = []
    try:
        failing = read_failing(archive, configuration)[:_TRIED]
        core = BareCore(configuration, dut)
        for explanation in explain(core, failing, result_folder, store):
            lines += explanation.lines()
    except CertificateError as error:
        lines.append(f"{_AT_ODDS} ({error})")
    # Whatever goes wrong here must not hide the failure that it is about.
    except Exception as error:
        reason = error if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
        lines.append(f"not shrunk: {' '.join(str(reason).split())}")
    return tuple(lines)


def run_and_explain(settings: RunSettings, dut: Path = DUT) -> RunResult:
    """Run a test; make the failing pairs of the core small.

    What comes out of the RTL of this checkout is kept in build/, and sent first from then on.
    """
    result = run(settings, dut)
    if result.passed or settings.block is not Block.CORE:
        return result
    store = FOUND if dut == DUT else None
    found = explain_failures(Path(settings.folder), settings.configuration, dut, store)
    blamed = {one["blame"] for one in (result.counts or {}).get("failures", [])}
    doubt = (_AT_ODDS,) if Blame.JUDGES in blamed and not any(_AT_ODDS in line for line in found) else ()
    return replace(result, counterexamples=(*doubt, *found))
