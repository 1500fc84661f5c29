"""Mutants of the mesh engine: what they are played with, what must come of it, and what it finds out."""

import re
from dataclasses import replace

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.mesh_engine import Mode, Status
from triaxis.sim.paths import DUT, VERIF
from triaxis.verif.mutation import killing, outcomes
from triaxis.verif.mutation.catalogue import catalogue
from triaxis.verif.mutation.engine_play import LOAD, RUN, STEP, Script, Traffic
from triaxis.verif.mutation.engine_stimulus import engine_directed, engine_extremes
from triaxis.verif.mutation.equivalence import CONTRACT, Equivalent, keep_contract
from triaxis.verif.mutation.models import SYMPTOMS
from triaxis.verif.mutation.result import KILLED, SURVIVING
from triaxis.verif.mutation.run import mutate
from triaxis.verif.mutation.targets import ENGINE, ENGINE_SINGLE, ENGINE_WORD, MAIN, TARGETS, EngineTarget

pytest.importorskip("pyslang", reason="mutants need pyslang: make setup")

SMALL = ENGINE_WORD
ONE = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])


@pytest.fixture(autouse=True)
def outcomes_of_its_own(tmp_path, monkeypatch):
    """Keep what these runs find out away from what the checkout's own runs know."""
    monkeypatch.setattr(outcomes, "FOLDER", tmp_path / "known")


def steps_of(script):
    return script.play("T", "f").steps


def of(module, changed):
    return next(m for m in catalogue().mutants if m.module == module and changed in m.changed)


def test_a_step_and_the_symptoms_are_those_of_the_harness():
    text = (VERIF / "mutation" / "engine_player.h").read_text()
    body = text[text.index("struct Step {") :].split("};")[0]
    names = [
        name.strip()
        for line in body.splitlines()[1:]
        for name in line.replace("int64_t", "").strip("; ").split(",")
    ]
    wide = [
        part
        for name in names
        if name
        for part in ([name] if name != "move[3]" else ["move_x", "move_y", "move_z"])
    ]
    assert tuple(wide) == STEP.names
    symptoms = (VERIF / "mutation" / "harness.h").read_text()
    enumerated = symptoms[symptoms.index("enum Symptom") :].split("};")[0]
    assert len(re.findall(r"\bk[A-Z]", enumerated)) == len(SYMPTOMS)


def test_a_script_knows_what_the_engine_holds():
    depth = SMALL.configuration.depth
    many = np.repeat(ONE, depth, 0)
    script = Script(SMALL.configuration)
    script.load(0, many).load(0, ONE, clear=False).run().load(0, ONE).load(1, ONE).run().reset().run()
    steps = steps_of(script)
    assert steps["held_a"].tolist() == [depth, depth, depth, 1, 1, 1, 0, 0]
    assert steps["overfull"].tolist() == [0, 1, 1, 0, 0, 0, 0, 0]
    runs = steps[steps["kind"] == RUN]
    assert runs["status"].tolist() == [Status.OVERFULL, Status.COMPLETE, Status.COMPLETE]
    assert runs["near_count"].tolist() == [0, 1, 0]


def test_a_reset_in_a_run_empties_the_meshes():
    script = Script(SMALL.configuration).load(0, ONE).load(1, ONE).run(traffic=Traffic(cut=3)).run()
    assert steps_of(script)["held_a"].tolist() == [1, 1, 0, 0]


def test_a_run_expects_what_its_mode_gives():
    script = Script(SMALL.configuration).load(0, np.repeat(ONE, 2, 0)).load(1, np.repeat(ONE, 3, 0))
    for mode in (*Mode, 3):
        script.run(mode=mode)
    script.run((127, 0, 0)).run((0, 0, 2), margin=1).run((0, 0, 2), margin=2)
    play = script.play("T", "f")
    runs = play.steps[play.steps["kind"] == RUN]
    assert runs["status"].tolist() == [2, 1, 1, 6, 4, 1, 1]
    assert runs["near_length"].tolist() == [1, 6, 0, 0, 0, 0, 6]
    assert runs["near_count"].tolist() == [1, 6, 6, 0, 0, 0, 6]
    assert runs["tested"].tolist() == [1, 6, 6, 0, 0, 0, 6]
    assert play.near[:3].tolist() == [[0, 0], [0, 0], [0, 1]]


def test_the_stimulus_repeats_by_its_seed_and_has_every_kind_of_step(seed):
    plays = engine_directed(ENGINE_SINGLE, seed)
    again = engine_directed(ENGINE_SINGLE, seed)
    assert all((one.steps == other.steps).all() for one, other in zip(plays, again, strict=True))
    steps = np.concatenate([play.steps for play in plays])
    assert set(steps["kind"]) == {0, 1, 2}
    runs = steps[steps["kind"] == RUN]
    assert set(runs["status"]) == set(Status) - {Status.ABORTED}
    assert (runs["abort_at"] >= 0).any() and (runs["cut"] >= 0).any() and (runs["hold"] > 0).any()
    assert (steps[steps["kind"] == LOAD]["clear"] == 0).any()


def test_extremes_take_every_counter_to_its_end(seed):
    depth, group = ENGINE.configuration.depth, ENGINE.configuration.group
    runs = np.concatenate([play.steps for play in engine_extremes(ENGINE, seed)])
    assert {int(runs[name].max()) for name in ("pairs_skipped", "tested", "near_count")} == {depth**2}
    for name in ("group_pairs_skipped", "group_pairs_opened"):
        assert runs[name].max() == (depth // group) ** 2


def test_mutants_of_the_engine_are_looked_for_in_the_engine_alone():
    files = {mutant.file for mutant in catalogue().mutants}
    for target in TARGETS:
        of_mesh = {target.mutates(file) for file in files if file.startswith("mesh/")}
        of_core = {target.mutates(file) for file in files if "/" not in file}
        assert (of_mesh, of_core) == (
            {isinstance(target, EngineTarget)},
            {not isinstance(target, EngineTarget)},
        )
    assert not any(path.parent.name == "mesh" for path in MAIN.sources(DUT))


def run(folder, mutant, seed):
    equivalents = folder / "equivalents.toml"
    equivalents.write_text("")
    chosen = replace(catalogue(), mutants=(mutant,))
    return mutate(
        seed, targets=(SMALL,), fresh=True, with_volume=False, chosen=chosen, equivalents=equivalents
    )  # fmt: skip


def test_a_mutant_is_killed_and_a_weakened_stimulus_leaves_it(tmp_path, seed, monkeypatch):
    lost = of("triaxis_near_pairs", "|| (m_axis_near_tvalid_o) ||")
    found = run(tmp_path, lost, seed)
    assert found.passed
    assert found.fates[0].fate == KILLED and found.fates[0].target == SMALL.name
    real = killing.engine_directed
    monkeypatch.setattr(
        killing, "engine_directed", lambda *a: [play for play in real(*a) if play.family == "translations"]
    )
    found = run(tmp_path, lost, seed)
    assert found.fates[0].fate == SURVIVING
    assert f"triaxis prove mutate --mutant {lost.id}" in found.problems[0]


def test_an_engine_that_breaks_its_contract_is_no_original(tmp_path, seed):
    wrong = of("triaxis_overlap", "apart != '0")
    with killing.mutated(DUT, wrong) as broken, pytest.raises(InputError, match="the RTL is wrong"):
        killing.measured(SMALL, engine_directed(SMALL, seed), broken)


def test_a_contract_refuses_what_breaks_it():
    from triaxis.verif.formal.proof import require_tools

    try:
        require_tools()
    except InputError as error:
        pytest.skip(str(error))
    wrong = of("triaxis_stream_fifo", "held_d == count_t'(Depth)")
    entry = Equivalent((wrong.id,), "reason", CONTRACT, "triaxis_stream_fifo", {}, "nothing is lost")
    refused = keep_contract(entry, [wrong])
    assert refused is not None and "not equivalent by its contract" in refused
    other = keep_contract(replace(entry, module="triaxis_ram"), [wrong])
    assert other is not None and "there is no proof of triaxis_ram" in other
    elsewhere = keep_contract(replace(entry, module="triaxis_pick"), [wrong])
    assert elsewhere is not None and "are not of mesh/triaxis_stream_fifo.sv" in elsewhere
