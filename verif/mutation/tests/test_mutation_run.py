"""Runs over a few mutants: a weak stimulus leaves survivors, a list of equivalents is not believed."""

import json
import os
import shutil
import subprocess
import threading
import time
from contextlib import nullcontext
from dataclasses import asdict, replace
from functools import cache, partial
from importlib.metadata import PackageNotFoundError
from itertools import permutations, product
from pathlib import Path
from types import SimpleNamespace

import pytest

from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.sim import programs, verilate
from triaxis.sim.build import content_hash, rtl_files
from triaxis.sim.evidence import Timeline
from triaxis.sim.paths import DUT, ROOT
from triaxis.sim.player import ASSERTION
from triaxis.verif.commands import inject
from triaxis.verif.mutation import builds, equivalence, killers, killing, outcomes, record, result, targets
from triaxis.verif.mutation import run as run_module
from triaxis.verif.mutation.catalogue import catalogue as parsed
from triaxis.verif.mutation.equivalence import (
    CONTRACT,
    CORNERS,
    EXHAUSTIVE,
    NOTICED,
    PROOF,
    REGISTERS,
    TWINS,
    Equivalent,
    check_equivalents,
    keep_contract,
    prove,
    prove_twins,
    read_equivalents,
)
from triaxis.verif.mutation.judging import judge
from triaxis.verif.mutation.killing import _ORIGINAL as ORIGINAL
from triaxis.verif.mutation.killing import Hunt
from triaxis.verif.mutation.result import EQUIVALENT, KILLED, SURVIVING
from triaxis.verif.mutation.run import CHANGED, mutate
from triaxis.verif.mutation.schema import mutated
from triaxis.verif.mutation.targets import ENGINE, ENGINE_SINGLE, ENGINE_WORD, MAIN
from triaxis.verif.testbench.simulation import run_trials
from triaxis.verif.testbench.trials import Model, Trials, Verdict

pytest.importorskip("pyslang", reason="mutants need pyslang: make setup")
# Each run asks which yosys there is, as its evidence hangs on that.
pytestmark = pytest.mark.prover

EXTENT = {"W": 3, "Comb": 1}


@cache
def _parsed(dut, _contents):
    return parsed(dut)


def catalogue(dut=DUT):
    """Return all mutants; it takes seconds, so once for sources that are the same."""
    return _parsed(dut, content_hash(rtl_files(dut)))


@pytest.fixture(autouse=True)
def nothing_known(tmp_path, monkeypatch):
    """Let these runs know nothing that the checkout's own runs found out or recorded, nor add to it."""
    monkeypatch.setattr(run_module, "catalogue", catalogue)
    monkeypatch.setattr(outcomes, "FOLDER", tmp_path / "known")
    monkeypatch.setattr(equivalence, "FOLDER", tmp_path / "known")
    monkeypatch.setattr("triaxis.verif.mutation.run.read_record", lambda: record.Record({}, {}))


def of(place, operator, changed):
    """Return the mutant of a module by operator and changed text."""
    return next(
        m for m in catalogue().mutants if (m.module, m.operator) == (place, operator) and changed in m.changed
    )


def empty(folder: Path) -> Path:
    path = folder / "equivalents.toml"
    path.write_text("")
    return path


def listed(folder: Path, *names: str, **changes: object) -> Path:
    entry = {
        "mutants": list(names), "reason": "It is said to be so.", "evidence": PROOF,
        "module": "triaxis_extent", "proves": "nothing changes",
    } | changes  # fmt: skip
    lines = [f"{key} = {json.dumps(value)}" for key, value in entry.items()]
    path = folder / "equivalents.toml"
    path.write_text("\n".join(["[[equivalent]]", *lines, "parameters = { W = 3, Comb = 1 }"]))
    return path


def few(*mutants):
    """Return a catalogue of these mutants."""
    found = catalogue()
    names = {mutant.id for mutant in mutants}
    return replace(found, mutants=tuple(m for m in found.mutants if m.id in names))


def run(folder, chosen, seed, equivalents=None, dut=DUT):
    """Run without what earlier runs know, on one target, without volume."""
    return mutate(
        seed, targets=(MAIN,), fresh=True, with_volume=False, chosen=chosen, dut=dut,
        equivalents=equivalents or empty(folder),
    )  # fmt: skip


@pytest.mark.regress
@pytest.mark.simulator
def test_a_mutant_is_killed_by_a_test_that_ran_and_survives_one_that_does_not_see_it(
    tmp_path, seed, monkeypatch
):
    overflowing = of("triaxis_fifo", "condition", "if (1'b1)")
    found = run(tmp_path, few(overflowing), seed)
    assert found.passed
    fate = found.fates[0]
    assert (fate.fate, fate.by) == (KILLED, "run")
    assert fate.test in ("StallsTest", "ResetsTest") and fate.pairs is not None
    # At full speed the queue never fills.
    real = targets._runs
    monkeypatch.setattr(targets, "_runs", lambda *a: (replace(real(*a)[0], test="RandomTest", pairs=100),))
    found = run(tmp_path, few(overflowing), seed)
    assert not found.passed
    assert found.fates[0].fate == SURVIVING
    assert overflowing.place in found.problems[0]
    assert f"triaxis prove mutate --mutant {overflowing.id}" in found.problems[0]


@pytest.mark.regress
@pytest.mark.simulator
def test_rtl_that_no_mutant_made_wrong_ends_the_run(tmp_path, seed):
    touching = of("triaxis_interval", "relational", "points[i] >= ceiling")
    other = of("triaxis_extent", "relational", "points_i[i] <= points_i")
    with mutated(DUT, touching) as broken, pytest.raises(InputError, match="the RTL is wrong"):
        run(tmp_path, few(other), seed, dut=broken)


@pytest.mark.simulator
def test_a_trial_that_fails_for_another_reason_gives_no_verdict(tmp_path):
    place = tmp_path / "trials"
    place.mkdir()
    crashing = tmp_path / "libcrash.so"
    source = 'extern "C" void* triaxis_open(unsigned) { __builtin_trap(); }'
    compile_it = ["c++", "-shared", "-fPIC", "-x", "c++", "-", "-o", str(crashing)]
    subprocess.run(compile_it, input=source, text=True, check=True)
    settings = tuple(replace(one, folder=str(place)) for one in MAIN.tests(1)[:1])
    trials = Trials(settings, (Model("m", str(crashing)),), place)
    with pytest.raises(InputError, match=r"m: no verdict of ExtremesTest: .*triaxis_close"):
        run_trials(trials)


@pytest.mark.regress
@pytest.mark.simulator
def test_what_is_killed_cannot_be_listed_as_equivalent(tmp_path, seed, monkeypatch):
    touching = of("triaxis_interval", "relational", "points[i] >= ceiling")
    # The evidence is believed here, wrongly: the run must not be.
    monkeypatch.setattr("triaxis.verif.mutation.equivalence._kept", lambda *_: None)
    found = run(tmp_path, few(touching), seed, listed(tmp_path, touching.id))
    assert any("listed as equivalent, but" in problem for problem in found.problems)


STATES = {"core": "one", "mesh": "two", "board": "three"}
EMPTY = result.MutationResult((), (), 1, 1.0, "", "", evidence_hash="state")
PLACE = record.Place("w8_m8, assertions", "MixedTest")


def noticed(symptom="wrong", trial=7):
    return outcomes.Killed(PLACE.test, "w8_m8", symptom, 7, PLACE.stage, trial)


def as_recorded(folder, played, equivalent=(), before=None, every=None, states=STATES):
    """Return the record after a run, as it is read from its file."""
    before = before or record.Record({}, {})
    every = catalogue().mutants if every is None else every
    written = record.recorded(before, every, played, equivalent, states)
    return record.read_record(record.write_record(written, folder / "record.json"))


def test_a_block_is_recorded_of_its_state_where_none_of_its_mutants_is_left(tmp_path):
    every = [next(m for m in catalogue().mutants if m.block == block) for block in ("core", "core", "mesh")]
    every[1] = next(m for m in catalogue().mutants if m.block == "core" and m.id != every[0].id)
    first, second, third = (one.id for one in every)
    # One survives; nothing is left of another block; none of the third is there.
    found = as_recorded(tmp_path, {first: noticed(), second: None, third: noticed(ASSERTION)}, every=every)
    assert found.states == {"mesh": "two", "board": "three"}
    assert found.places(every) == {first: PLACE, third: PLACE}
    assert {name: how.symptom for name, how in found.killed(every, STATES).items()} == {third: ASSERTION}
    assert not found.killed(every, STATES | {"mesh": "another"})
    # It is shown to be equivalent: what was not played again keeps what is known.
    whole = as_recorded(tmp_path, {second: None}, {second}, found, every)
    assert whole.states == {"mesh": "two", "board": "three"}
    played = {first: noticed(), second: None}
    whole = as_recorded(tmp_path, played, {second}, found, every)
    assert whole.states == STATES and whole.killed(every, STATES).keys() == {first, third}
    # It survives now, or a mutant is new and was not played, or the RTL is another.
    assert "core" not in as_recorded(tmp_path, {second: None}, (), whole, every).states
    assert as_recorded(tmp_path, {}, (), whole, every, STATES | {"core": "new"}).states == {
        "mesh": "two", "board": "three",
    }  # fmt: skip
    assert as_recorded(tmp_path, {}, (), whole, every[:1]).kills.keys() == {every[0].short}


@pytest.fixture
def recorded(monkeypatch):
    """Return 200 mutants that are recorded as killed, of this state."""
    chosen = [one for one in catalogue().mutants if one.block == "core"][:200]
    kills = {one.short: noticed(trial=0) for one in chosen}
    held = record.Record(killers.states(DUT), kills)
    monkeypatch.setattr("triaxis.verif.mutation.run.read_record", lambda: held)
    return chosen


def judging(monkeypatch, lives=()):
    """Stand in for what plays mutants; return the list of those that are played."""
    played: list[str] = []

    def judged(found, seed, jobs, timeline, excused, dut, targets, fresh, *rest):
        *_, settled = rest
        store = outcomes.Store(found, dut, seed, fresh)
        # In the order of `judge`: what is settled goes before all else.
        known = dict.fromkeys(store.surviving) | store.killed | settled
        played[:] = [one.id for one in found.mutants if one.id not in known]
        fates = known | {name: None if name in lives else noticed() for name in played}
        return [outcomes.Outcome(one, fates[one.id], ("w8_m8",)) for one in found.mutants]

    monkeypatch.setattr("triaxis.verif.mutation.run.judge", judged)
    return played


def test_what_is_recorded_is_taken_but_for_a_sample(tmp_path, seed, monkeypatch, recorded):
    played = judging(monkeypatch)
    ask = partial(mutate, record.SEED, chosen=few(*recorded), equivalents=empty(tmp_path))
    found = ask(sample=seed)
    first, names = set(played), {one.id for one in recorded}
    assert 0 < len(first) < 40 and found.sampled == len(first) and found.passed
    assert f"{200 - len(first)} as recorded" in found.summary
    # Another seed, another sample; all where nothing is to be taken, or all is of another state.
    ask(sample=seed + 1)
    assert set(played) != first
    assert ask().passed and set(played) == names
    monkeypatch.setattr("triaxis.verif.mutation.run.states", lambda _: STATES)
    ask(sample=seed)
    assert set(played) == names


def test_evidence_is_taken_as_recorded_but_for_a_sample(tmp_path, seed, monkeypatch):
    # Whatever is said: what decides is whether it is asked.
    checked: list[str] = []

    def check(entry, *_):
        checked.append(entry.mutants[0])

    monkeypatch.setitem(equivalence._CHECKS, PROOF, check)
    chosen = [one for one in catalogue().mutants if one.block == "core"][:200]
    names = [one.id for one in chosen]
    judging(monkeypatch, names)
    texts = [listed(tmp_path, name).read_text() for name in names]
    entries = tmp_path / "equivalents.toml"
    entries.write_text("\n".join(texts))
    now = {run_module.EVIDENCE: equivalence.evidence_hash(DUT)}
    monkeypatch.setattr("triaxis.verif.mutation.run.read_record", lambda: record.Record(now, {}))
    ask = partial(mutate, record.SEED, chosen=few(*chosen), equivalents=entries, dut=DUT)

    def asked(**options):
        checked.clear()
        found = ask(**options)
        assert found.evidence_holds and found.entries == 200
        assert {fate.id for fate in found.fates if fate.fate == EQUIVALENT} == set(names)
        return set(checked), found.entries_recorded

    first, taken = asked(sample=seed)
    assert 0 < len(first) < 40 and taken == 200 - len(first)
    # Once more, though what was proved is kept; by another seed others; all where the record is not asked.
    assert asked(sample=seed) == (first, taken)
    assert asked(sample=seed + 1)[0] != first
    assert asked(fresh=True) == (set(names), 0)
    now[run_module.EVIDENCE] = "another"
    assert asked(sample=seed)[1] == 0
    # What failed here is checked by every seed, until it holds; and no such run is to be recorded.
    now[run_module.EVIDENCE] = equivalence.evidence_hash(DUT)
    monkeypatch.setitem(equivalence._CHECKS, PROOF, lambda entry, *_: f"{entry.mutants[0]}: is none")
    found = ask(sample=seed)
    assert not found.evidence_holds
    assert {line.partition(":")[0] for line in found.problems if line.endswith("is none")} == first
    monkeypatch.setitem(equivalence._CHECKS, PROOF, check)
    drawn = {name for name in names if record.drawn(name, seed + 1)}
    assert asked(sample=seed + 1)[0] == first | drawn
    assert asked(sample=seed + 1)[0] == drawn


def test_a_proof_of_what_was_edited_meanwhile_is_kept_by_nobody(tmp_path, seed, monkeypatch):
    dut = tmp_path / "dut"
    shutil.copytree(DUT, dut)
    one = of("triaxis_extent", "relational", "points_i[i] <= points_i")
    checked: list[str] = []

    def edit(entry, *_):
        """As long as the last proof may: it ends when all trials have."""
        checked.append(entry.mutants[0])
        file = dut / "core" / "triaxis_extent.sv"
        text = file.read_text()
        file.write_text("")
        file.write_text(text)

    monkeypatch.setitem(equivalence._CHECKS, PROOF, edit)
    judging(monkeypatch, {one.id})
    time.sleep(0.01)
    for _ in range(2):
        found = mutate(
            record.SEED, chosen=few(one), equivalents=listed(tmp_path, one.id), dut=dut, sample=seed
        )
        assert CHANGED in found.problems
    assert len(checked) == 2


def test_solvers_and_what_proves_decide_evidence_and_no_test_does(monkeypatch):
    def missing(name):
        raise PackageNotFoundError(name)

    before = equivalence.evidence_hash(DUT)
    monkeypatch.setattr(equivalence, "version", lambda _: "another")
    other = equivalence.evidence_hash(DUT)
    monkeypatch.setattr(equivalence, "version", missing)
    assert len({before, other, equivalence.evidence_hash(DUT)}) == 3
    names = {path.name for path in equivalence.PROVERS.files()}
    assert {"triaxis_formal.svh", "triaxis_go_formal.sv", "operators.py", "algebra.py", "twins.py"} <= names
    assert "uvm_tests.py" not in names


@pytest.mark.parametrize("kind", [PROOF, EXHAUSTIVE])
def test_of_those_that_evidence_shows_to_be_equivalent_a_sample_has_what_volume_is_part_of(
    tmp_path, seed, monkeypatch, kind
):
    monkeypatch.setitem(equivalence._CHECKS, kind, lambda *_: None)
    chosen = [one for one in catalogue().mutants if one.block == "core"][:200]
    names = {one.id for one in chosen}
    entries = listed(tmp_path, *sorted(names), evidence=kind)
    played = judging(monkeypatch, names)
    states = killers.states(DUT) | {run_module.EVIDENCE: equivalence.evidence_hash(DUT)}
    monkeypatch.setattr("triaxis.verif.mutation.run.read_record", lambda: record.Record(states, {}))
    ask = partial(mutate, record.SEED, equivalents=entries, sample=seed)
    found = ask(chosen=few(*chosen))
    drawn = {name for name in names if record.drawn(name, seed)}
    assert set(played) == (drawn if kind == EXHAUSTIVE else set())
    assert found.passed and found.evidence_holds and found.sampled == len(played)
    # Evidence of which volume is a part is none of another list's, until all of that was played.
    states[run_module.EVIDENCE] = "another"
    assert ask(chosen=few(*chosen)).evidence_holds
    assert set(played) == (names if kind == EXHAUSTIVE else set())
    assert ask(chosen=few(*chosen[1:])).evidence_holds is (kind == PROOF)


def test_a_sample_is_of_one_at_least(seed):
    names = [f"mutant {number}" for number in range(200)]
    found = run_module.sample_of(names, seed)
    assert found == {name for name in names if record.drawn(name, seed)} and 0 < len(found) < 40
    assert all(run_module.sample_of(["one"], number) == {"one"} for number in range(40))
    assert not run_module.sample_of([], seed)


@pytest.mark.parametrize("holds", [True, False])
@pytest.mark.parametrize("words", [(), ("--file", "core/*")])
def test_a_run_that_records_checks_all_evidence_and_records_where_it_holds(
    tmp_path, monkeypatch, holds, words
):
    asked: list[bool] = []

    def mutate(*_, all_evidence, **__):
        asked.append(all_evidence)
        return replace(EMPTY, evidence_holds=holds)

    monkeypatch.setattr(inject, "mutate", mutate)
    monkeypatch.setattr(inject, "keep", lambda _: None)
    monkeypatch.setattr(inject.mutation_result, "write_result", lambda *_: tmp_path)
    monkeypatch.setattr(inject, "read_record", lambda: record.Record({}, {}))
    written: list[record.Record] = []
    monkeypatch.setattr(inject, "write_record", lambda now: written.append(now) or tmp_path)
    main(["prove", "mutate", "--record", *words])
    assert (run_module.EVIDENCE in written[0].states) is holds and asked == [True]


def test_all_evidence_is_that_of_mutants_that_are_not_played_too(tmp_path, monkeypatch):
    checked: list[str] = []
    monkeypatch.setitem(equivalence._CHECKS, PROOF, lambda entry, *_: checked.append(entry.mutants[0]))
    one, other = [mutant for mutant in catalogue().mutants if mutant.block == "core"][:2]
    judging(monkeypatch)
    for everything, due in ((False, []), (True, [other.id])):
        mutate(record.SEED, chosen=few(one), equivalents=listed(tmp_path, other.id), all_evidence=everything)
        assert checked == due


def test_a_record_that_is_wrong_is_told(tmp_path, seed, monkeypatch, recorded):
    lost = next(one for one in recorded if record.drawn(one.id, seed))
    judging(monkeypatch, {lost.id})
    for sample in (seed, None):
        found = mutate(record.SEED, chosen=few(*recorded), equivalents=empty(tmp_path), sample=sample)
        told = [line for line in found.problems if "the record is wrong" in line]
        assert len(told) == 1 and told[0].startswith(f"{lost.id}: MixedTest noticed it")


def test_what_is_known_here_goes_before_the_record_and_a_sample_before_that(
    tmp_path, seed, monkeypatch, recorded
):
    played = judging(monkeypatch)
    drawn, other = (
        next(one.id for one in recorded if record.drawn(one.id, seed) is wanted) for wanted in (True, False)
    )
    store = outcomes.Store(few(*recorded), DUT, record.SEED, False)
    store.killed[drawn] = noticed()
    store.surviving.add(other)
    store.save()
    found = mutate(record.SEED, chosen=few(*recorded), equivalents=empty(tmp_path), sample=seed)
    assert drawn in played and other not in played
    assert next(fate for fate in found.fates if fate.id == other).fate == SURVIVING and not found.passed


def test_what_was_written_during_a_run_is_noticed_though_it_is_as_before(
    tmp_path, seed, monkeypatch, recorded
):
    dut = tmp_path / "dut"
    shutil.copytree(DUT, dut)

    def judged(found, *_):
        store = outcomes.Store(found, dut, record.SEED, False)
        store.killed |= {one.id: noticed() for one in found.mutants}
        store.save()
        file = dut / "mesh" / "triaxis_walk.sv"
        text = file.read_text()
        file.write_text("")
        file.write_text(text)
        return [outcomes.Outcome(one, noticed(), ("w8_m8",)) for one in found.mutants]

    monkeypatch.setattr("triaxis.verif.mutation.run.judge", judged)
    # One of each block: what becomes of the core's does not hang on the mesh engine.
    chosen = [next(one for one in catalogue().mutants if one.block == block) for block in killers.BLOCKS]
    found = mutate(record.SEED, chosen=few(*chosen), equivalents=empty(tmp_path), dut=dut)
    assert any("changed during the run" in line for line in found.problems)
    left = outcomes.Store(few(*chosen), dut, record.SEED, False)
    assert left.killed.keys() == {chosen[0].id}


def test_where_a_mutant_was_noticed_is_where_it_is_tried_first(tmp_path, seed, monkeypatch):
    """One in vain: it is left to all the others."""
    early, late, vain = [m for m in catalogue().mutants if m.module == "triaxis_box"][:3]
    order = {late.id: PLACE, vain.id: PLACE}
    tried: list[tuple[str, str]] = []

    def simulate(trials):
        for test, models in trials.turns:
            for model in trials.unnoticed(models):
                tried.append((model.name, test.test))
                symptom = "wrong" if (model.name, test.test) == (late.id, PLACE.test) else ""
                with trials.results.open("a") as told:
                    told.write(json.dumps(asdict(Verdict(model.name, test.test, symptom, 1))) + "\n")

    monkeypatch.setattr(killing, "run_trials", simulate)
    monkeypatch.setattr(Hunt, "_library", lambda *_: tmp_path)
    monkeypatch.setattr(Hunt, "built", lambda *_: None)
    monkeypatch.setattr("triaxis.verif.mutation.judging._FEW", 0)
    judged = judge(few(early, late, vain), seed, 1, Timeline(), targets=(MAIN,), fresh=True, order=order)
    tests = [test.test for test in MAIN.tests(seed)]
    of = {name: [test for mutant, test in tried if mutant == name] for name in order}
    assert of[late.id] == ["MixedTest"]
    once = ["MixedTest", *(test for test in tests if test != "MixedTest")]
    assert of[vain.id] == [*once, *tests, "VolumeTest"]
    assert {one.mutant.id: one.killed.trial for one in judged if one.killed} == {late.id: 1}


def test_what_is_listed_as_equivalent_and_was_tried_once_is_known(tmp_path, seed, monkeypatch):
    tried: list[str] = []

    def simulate(trials):
        for test, models in trials.turns:
            tried.extend(model.name for model in models)
            with trials.results.open("a") as told:
                for model in models:
                    told.write(json.dumps(asdict(Verdict(model.name, test.test, "", 1))) + "\n")

    monkeypatch.setattr(killing, "run_trials", simulate)
    monkeypatch.setattr(Hunt, "_library", lambda *_: tmp_path)
    monkeypatch.setattr(Hunt, "built", lambda *_: None)
    monkeypatch.setattr("triaxis.verif.mutation.judging._FEW", 0)
    one, other = [m for m in catalogue().mutants if m.module == "triaxis_box"][:2]
    ask = partial(judge, few(one, other), seed, 1, Timeline(), targets=(MAIN,))
    ask(frozenset({one.id}))
    assert {one.id, other.id} <= set(tried)
    tried.clear()
    ask(frozenset({one.id}))
    assert not {one.id, other.id} & set(tried)
    # Listed no more: it is tried by all.
    ask()
    assert one.id in tried and other.id not in tried


TWICE = '{"states": {}, "noticed": {"a": {"T": {"run": ["0123abcd"]}}, "b": {"T": {"run": ["0123abcd"]}}}}'


@pytest.mark.parametrize("text", ["[1]", '{"states": {}, "noticed": {"a stage": {"a test": 5}}}', "{", TWICE])
def test_a_damaged_record_is_refused(tmp_path, text):
    (tmp_path / "record.json").write_text(text)
    with pytest.raises(InputError, match=r"record.json: damaged: .* write \{.*\} into it"):
        record.read_record(tmp_path / "record.json")


@pytest.mark.prover
def test_evidence_refuses_a_mutant_that_is_not_equivalent():
    wrong = of("triaxis_extent", "relational", "points_i[i] > points_i")
    right = of("triaxis_extent", "relational", "points_i[i] <= points_i")
    entry = Equivalent((), "reason", PROOF, "triaxis_extent", EXTENT, "nothing changes")
    assert prove(entry, [right]) is None
    message = prove(entry, [right, wrong])
    assert message is not None
    assert wrong.id in message
    assert "not proved equivalent in triaxis_extent (W = 3, Comb = 1)" in message
    # Of registers: what is between them may differ, no reset, and no register.
    of_board = {mutant.id: mutant for mutant in catalogue().mutants}
    entry = Equivalent((), "reason", REGISTERS, "triaxis_command", {}, "nothing changes")
    assert prove(entry, [of_board["triaxis_session/operand/39ea9226"]]) is None
    entry = replace(entry, module="triaxis_safety")
    for wrong in ("triaxis_safety/deletion/133ee2a2", "triaxis_safety/identifier/047deaee"):
        assert "not proved equivalent in triaxis_safety" in (prove(entry, [of_board[wrong]]) or "")
    # Nor does a contract hold for what breaks it.
    wrong = of("triaxis_stream_fifo", "equality", "held_d == count_t'(Depth)")
    entry = Equivalent((wrong.id,), "reason", CONTRACT, "triaxis_stream_fifo", {}, "nothing is lost")
    for module, said in (
        ("triaxis_stream_fifo", "not equivalent by its contract"),
        ("triaxis_display", "there is no proof of triaxis_display"),
        ("triaxis_pick", "are not of mesh/triaxis_stream_fifo.sv"),
        ("triaxis_go", "are not of mesh/triaxis_stream_fifo.sv"),
    ):
        assert said in (keep_contract(replace(entry, module=module), [wrong]) or "")


@pytest.mark.prover
def test_of_twins_either_may_be_taken_but_not_the_same_twice_in_a_comparison():
    sizes = {"W": 8, "Depth": 16, "Group": 4, "Lanes": 2}
    entry = Equivalent((), "reason", TWINS, "triaxis_mesh_store", sizes, "nothing changes")
    assert prove_twins(entry, [of("triaxis_mesh_store", "index", "count_o = counts[next(0)]")]) is None
    for changed in ("second = seen[next(1)]", "differ_o = seen[next(0)]", "boxes[0][next(c)]"):
        wrong = of("triaxis_mesh_store", "index", changed)
        assert f"{wrong.id}: not proved equivalent" in (prove_twins(entry, [wrong]) or "")
    single = of("triaxis_stream_fifo", "equality", "held_d == count_t'(Depth)")
    with pytest.raises(InputError, match="twins: no two instances that the same bits reach"):
        prove_twins(replace(entry, module="triaxis_mesh_intake"), [single])


@pytest.mark.prover
def test_a_proof_notices_a_mutant_only_where_it_fails():
    wrong = of("triaxis_stream_fifo", "equality", "held_d == count_t'(Depth)")
    entry = Equivalent((wrong.id,), "reason", NOTICED, "triaxis_stream_fifo", {}, "it is full")
    assert keep_contract(entry, [wrong]) is None
    right = next(one for one in read_equivalents() if one.module == "triaxis_stream_fifo")
    harmless = catalogue().by_id[right.mutants[0]]
    assert f"{harmless.id}: not noticed" in (keep_contract(entry, [harmless]) or "")


def test_corners_refuse_a_bit_that_is_needed():
    near = of("triaxis_space_axes", "cast", "$signed({(points[i][j][0]) <<< 1}")
    far = of("triaxis_space_axes", "cast", "$signed({(points[i][j][1]) <<< 1}")
    entry = Equivalent(
        (near.id,), "reason", CORNERS, "triaxis_space_axes", {"span": 0, "slope": 3, "offset": 3}, "x"
    )
    held = check_equivalents([entry], {near.id: near}, [near.id])
    assert set(held.equivalent) == {near.id}
    needed = replace(entry, mutants=(far.id,), parameters={"span": 2, "slope": 3, "offset": 3})
    refused = check_equivalents([needed], {far.id: far}, [far.id])
    assert not refused.equivalent
    assert "does not fit" in refused.problems[0]


@pytest.mark.parametrize(
    ("names", "change", "message"),
    [
        (["a/b/c"], {"evidence": "belief"}, "evidence 'belief'"),
        (["a/b/c"], {"reason": " "}, "must not be empty"),
        (["a/b/c"], {"extra": 1}, "extra"),
        (["a/b/c", "a/b/c"], {}, "listed twice"),
    ],
)
def test_an_entry_that_is_not_whole_is_refused(tmp_path, names, change, message):
    with pytest.raises(InputError, match=message):
        read_equivalents(listed(tmp_path, *names, **change))
    gone = Equivalent(("triaxis_extent/relational/00000000",), "r", EXHAUSTIVE, "triaxis_core", {}, "p")
    assert "there is no such mutant now" in check_equivalents([gone], {}, []).problems[0]


@cache
def first():
    """Return a mutant."""
    return catalogue().mutants[0]


def one(killed=None):
    """Return the result of a run over one mutant, equivalent unless it was killed."""
    outcome = outcomes.Outcome(first(), killed, ("w8_m8",))
    fates = (result.fate_of(outcome, True),)
    states = result.rtl_hash(), result.killers_hash()
    evidence = equivalence.evidence_hash(DUT)
    return result.MutationResult(fates, (), 1, 1.0, *states, evidence_hash=evidence)


@pytest.mark.parametrize("what", ["rtl_hash", "killers_hash", "evidence_hash"])
def test_a_result_of_another_state_is_not_taken(tmp_path, monkeypatch, what):
    found = one()
    assert found.fates[0].fate == EQUIVALENT
    path = result.write_result(found, "test", tmp_path / "mutation.json")
    assert result.known_result(None, path) is not None
    monkeypatch.setattr(result, what, lambda *_: "another")
    assert result.known_result(None, path) is None
    assert result.known_result(None, tmp_path / "none.json") is None


def test_a_result_that_rests_on_a_record_is_taken_with_that_record_and_sample_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(result, "RECORD", tmp_path / "record.json")
    (tmp_path / "record.json").write_text("one")
    found = replace(one(), sample=7, record_hash=content_hash([tmp_path / "record.json"]))
    path = result.write_result(found, "test", tmp_path / "mutation.json")
    assert result.known_result(7, path) is not None
    assert result.known_result(8, path) is None and result.known_result(None, path) is None
    (tmp_path / "record.json").write_text("another")
    assert result.known_result(7, path) is None
    (tmp_path / "record.json").write_text("one")
    monkeypatch.setattr(result, "evidence_hash", lambda _: "another")
    assert result.known_result(7, path) is None


def test_a_change_during_the_run_is_a_problem(tmp_path, seed, monkeypatch):
    states = iter(("before", "after"))
    monkeypatch.setattr("triaxis.verif.mutation.run.killers_hash", lambda: next(states))
    monkeypatch.setattr("triaxis.verif.mutation.run.judge", lambda *_: [])
    found = run(tmp_path, few(first()), seed)
    assert found.killers_hash == "before"
    assert any("changed during the run" in problem for problem in found.problems)
    assert [stage.name for stage in found.stages] == ["evidence of equivalence"]
    assert found.stages[0].begin <= found.stages[0].end <= round(found.seconds, 1)


def test_what_is_shown_equivalent_is_tried_once_in_each_configuration(seed, monkeypatch):
    stages: list[str] = []
    monkeypatch.setattr(Hunt, "_build", lambda _, stage, alive: stages.append(stage.name))
    folded = of("triaxis_mesh", "parameter", "")
    chosen = few(folded)
    for excused, without in ((frozenset({folded.id}), True), (frozenset[str](), False)):
        judge(chosen, seed, 1, Timeline(), excused, fresh=True, with_volume=False)
        names = [engine.name for engine in (ENGINE, ENGINE_SINGLE, ENGINE_WORD)]
        assert stages[:3] == [f"{name}, exact core" for name in names]
        assert stages[3:] == ([] if without else [*names, *(f"{name}, assertions" for name in names)])
        stages.clear()


def test_what_volume_notices_in_one_engine_is_not_asked_of_the_next(seed, monkeypatch):
    folded, volumes = of("triaxis_mesh", "parameter", ""), []
    alone = threading.Lock()

    def build(hunting, stage, alive):
        if not stage.name.endswith("volume"):
            return
        assert alone.acquire(blocking=False), "volume of two engines at a time"
        # Time for the next to begin, were it not made to wait.
        time.sleep(0.1)
        volumes.append(stage.target)
        if stage.target == ENGINE_SINGLE:
            hunting._notice(
                folded.id, outcomes.Killed("MeshResetsTest", stage.target.name, "wrong", 1), stage
            )
        alone.release()

    monkeypatch.setattr(Hunt, "_build", build)
    judge(few(folded), seed, 2, Timeline(), fresh=True)
    assert volumes == [ENGINE, ENGINE_SINGLE]


def test_volume_is_of_about_as_many_scenes_whatever_a_mesh_holds():
    of_engine = {test.test: test.pairs for test in ENGINE.volume(1)}
    assert of_engine["MeshResetsTest"] >= 2_000_000
    for engine in (ENGINE_SINGLE, ENGINE_WORD):
        full = (ENGINE.configuration.depth // engine.configuration.depth) ** 2
        assert {test.test: test.pairs for test in engine.volume(1)} == {
            test: pairs // full for test, pairs in of_engine.items()
        }


def hunt(seed, progress=lambda _: None):
    """Return a hunt that knows of no mutant."""
    store = outcomes.Store(few(), DUT, seed, True)
    return Hunt(few(), {}, DUT, seed, 2, store, frozenset(), {}, progress, Timeline())


@pytest.mark.parametrize(
    ("original", "error", "killed"),
    [
        ("", None, {"m/1": "TouchingTest", "m/2": "MixedTest"}),
        ("wrong", InputError, {"m/1": "TouchingTest"}),
        (None, KeyboardInterrupt, {"m/1": "TouchingTest"}),
    ],
)
@pytest.mark.parametrize("beside", [False, True])
def test_what_a_test_notices_counts_where_the_original_passes_it(
    seed, monkeypatch, beside, original, error, killed
):
    """Of two tests the original passes one; asked about the other, it says this, or never does."""
    known, other = (replace(MAIN.tests(seed)[0], test=name) for name in ("TouchingTest", "MixedTest"))
    symptoms = {("m/1", known.test): "wrong", ("m/2", other.test): "wrong", (ORIGINAL, other.test): original}

    def simulate(trials):
        for model, test in product(trials.models, trials.tests):
            symptom = symptoms.get((model.name, test.test), "")
            if symptom is None:
                raise KeyboardInterrupt
            with trials.results.open("a") as file:
                file.write(json.dumps(asdict(Verdict(model.name, test.test, symptom, 1))) + "\n")

    monkeypatch.setattr(killing, "run_trials", simulate)
    hunting, stage = hunt(seed), killing.Stage(MAIN, (known, other))
    models, passed = [Model("m/1", ""), Model("m/2", "")], set() if beside else {known.test}
    with pytest.raises(error) if error else nullcontext():
        hunting._try(stage, models, Model(ORIGINAL, ""), passed, beside)
    assert {name: how.test for name, how in hunting.killed.items()} == killed
    assert passed == ({known.test} if error else {known.test, other.test})


def test_stages_side_by_side_simulate_no_more_at_a_time_than_there_are_jobs(seed, monkeypatch):
    hunting, going, most = hunt(seed), [], []

    def simulate(trials):
        going.append(trials)
        most.append(len(going))
        time.sleep(0.02)
        going.remove(trials)

    monkeypatch.setattr(killing, "run_trials", simulate)
    lanes = [[partial(hunting._run, Trials((), (), Path(str(number))))] * 2 for number in range(6)]
    hunting.beside(lanes, len(lanes))
    assert len(most) == 12 and max(most) == hunting.jobs


def test_stages_side_by_side_credit_a_mutant_once_and_always_the_same_of_them(seed):
    kills = [outcomes.Killed(f"Test{number}", "w8_m8", "wrong", 1) for number in range(3)]
    stages = [killing.Stage(MAIN, (), number=number) for number in range(3)]
    for numbers in permutations(range(3)):
        told: list[int] = []
        hunting = hunt(seed, told.append)
        for number in numbers:
            hunting.beside([[partial(hunting._notice, "m", kills[number], stages[number])]], 2)
        assert (hunting.killed, sum(told)) == ({"m": replace(kills[0], stage=stages[0].name)}, 1)


def test_where_a_stage_fails_those_beside_it_begin_nothing_more(seed):
    hunting, done = hunt(seed), []

    def fail():
        raise InputError("no space")

    def wait():
        assert hunting._ended.wait(60)

    with pytest.raises(InputError, match="no space"):
        hunting.beside([[fail], [wait, lambda: done.append("more")]], 2)
    assert done == []


def test_the_killers_are_all_of_them_and_nothing_else():
    files = killers.KILLERS.files()
    names = {path.name for path in files}
    assert {"equivalents.toml", "core_player.cpp", "families.py", "triaxis_core_sva.sv", "bulk.cpp"} <= names
    # Reached only through others: none of them is in the folder of the mutation.
    assert {"configuration.py", "exact.py", "toolchain.py", "near_miss.py", "proof.py"} <= names
    assert not {"result.json", "README.md", "meshcheck.py"} & names
    foreign = ("host", "docs", "bench", "fpga")
    assert not [path for path in files if path.relative_to(ROOT).parts[0] in foreign]


def test_what_is_known_of_a_block_rests_on_that_and_what_is_below(tmp_path, seed, monkeypatch):
    files = {block: {path.name for path in killers.OUTCOMES[block].files()} for block in killers.BLOCKS}
    assert "triaxis_board_sva.sv" in files["board"] and "reference.py" in files["board"]
    assert not {"equivalents.toml", "triaxis_board_sva.sv", "triaxis_go_formal.sv"} & files["core"]
    assert {"near_miss.py", "operators.py", "killing.py", "core_player.cpp"} <= files["core"]
    players = {"core_player.cpp", "mesh_player.cpp", "board_player.cpp"}
    assert [players & files[block] for block in files] == [{f"{block}_player.cpp"} for block in files]
    assert "kept_clocks.json" not in files["core"] and not any("waves.py" in files[block] for block in files)
    shutil.copytree(DUT, tmp_path / "dut")
    monkeypatch.setattr(outcomes, "FOLDER", tmp_path)
    chosen = {
        block: next(one for one in catalogue().mutants if one.file.startswith(block)) for block in files
    }
    store = outcomes.Store(catalogue(), tmp_path / "dut", seed, False)
    store.killed |= {one.id: KILL for one in chosen.values()}
    store.save()
    for changed, left in (("board", {"core", "mesh"}), ("mesh", {"core"}), ("core", set())):
        path = next((tmp_path / "dut" / changed).glob("triaxis_*.sv"))
        path.write_text(path.read_text() + "\n// changed\n")
        known = outcomes.Store(few(), tmp_path / "dut", seed, False).killed
        assert known == {chosen[block].id: KILL for block in left}
    # What changed meanwhile is not written.
    store.killed.clear()
    store.save()
    assert not outcomes.Store(few(), tmp_path / "dut", seed, False).killed


KILL = outcomes.Killed("MixedTest", "w8_m8", "wrong word", 3)


@pytest.mark.parametrize(
    ("change", "listing", "message"),
    [
        ({}, [], None),
        ({"symptom": None}, [], "killed, but without symptom"),
        ({"test": ""}, [], "killed, but without test"),
        ({"target": None}, [], "killed, but without target"),
        ({"by": "belief"}, [], "by nothing that is known"),
        ({"by": "proof"}, [], "killed by a proof, but not listed as such"),
        ({"by": "proof"}, None, "killed by a proof, but not listed as such"),
        ({}, None, "killed, but listed as equivalent"),
        ({"fate": "equivalent"}, [], "equivalent, but not listed"),
        ({"fate": "excused"}, [], "no such fate"),
        ({"fate": "surviving", "by": None}, [], "not the sum over its mutants"),
        ({"nonsense": 1}, [], "damaged"),
    ],
)
def test_fates_are_not_believed(tmp_path, change, listing, message):
    content = json.loads(result.write_result(one(KILL), "test", tmp_path / "mutation.json").read_text())
    name = content["mutants"][0]["id"]
    content["mutants"][0] |= change
    file = empty(tmp_path) if listing is not None else listed(tmp_path, name)
    if message:
        with pytest.raises(InputError, match=message):
            result.fates_in(content, file)
        return
    assert [fate.id for fate in result.fates_in(content, file)] == [name]
    for key in ("summary", "total", "files", "operators", "kinds"):
        with pytest.raises(InputError, match=f"{key}: not the sum over its mutants"):
            result.fates_in(content | {key: {}}, file)


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("exit 1", "ends with 1, not for an error in the RTL: no message"),
        ("echo '%Error: no/such.sv:1:2: wrong' >&2; exit 1", "not for an error in the RTL"),
        ('echo "%Error: $DUT/triaxis_core.sv:1:2: wrong" >&2; kill -SEGV $$', "ends with -11"),
        ('echo "%Error: $DUT/a.sv:1:2: x" >&2; echo No space left on device >&2; exit 1', "ends with 1"),
        ("sleep 5", "still running"),
        ('echo "%Error: $DUT/triaxis_core.sv:1:2: wrong" >&2; exit 1', r"triaxis_core.sv:1:2"),
    ],
)
def test_a_verilator_that_fails_kills_no_mutant(tmp_path, monkeypatch, script, message):
    monkeypatch.setattr(programs, "_WALL_SECONDS", 2 if "sleep" in script else 60)
    fails = SimpleNamespace(executable=tmp_path / "fails", environment=lambda: dict(os.environ))
    for module in (builds, verilate):
        monkeypatch.setattr(module, "verilator", lambda: fails)
    monkeypatch.setattr(builds, "_build", lambda *_: replace(MAIN.build(DUT), dut=tmp_path))
    monkeypatch.setenv("DUT", str(tmp_path))
    (tmp_path / "fails").write_text(f"#!/bin/sh\n{script}\n")
    (tmp_path / "fails").chmod(0o755)
    error = builds.ElaborationError if "core.sv:1:2" in message else InputError
    with pytest.raises(error, match=message):
        builds.elaboration_hash(MAIN, tmp_path, False)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--seed", "-1"], "--seed: -1: must not be negative"),
        (["--jobs", "0"], "--jobs: 0: must be at least 1"),
        (["--mutant", "nothing/at/all"], "no such mutant"),
    ],
)
def test_the_command_refuses_what_it_cannot_do(arguments, message, capsys):
    assert main(["prove", "mutate", *arguments]) == 2
    assert message in capsys.readouterr().err
