"""Scripts for the mesh engine: what must come of them, and what they hold."""

import re

import numpy as np

from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import LOAD, RUN, STEP, Mode, Status
from triaxis.sim.paths import SIM
from triaxis.sim.player import SYMPTOMS
from triaxis.verif.mesh.script_stimulus import engine_directed, engine_extremes
from triaxis.verif.mesh.scripts import Script, Traffic

ENGINE = MeshConfiguration(8, 8, depth=64, group=8, lanes=2, cycle_bits=9)
SINGLE = MeshConfiguration(8, 0, depth=16, group=1, lanes=1, cycle_bits=8)
SMALL = MeshConfiguration(8, 3, depth=16, group=4, lanes=4, cycle_bits=8, gating=False)
ONE = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])


def test_a_step_and_the_symptoms_are_those_of_the_players():
    text = (SIM / "mesh_player.cpp").read_text()
    body = text[text.index("struct Step {") :].split("};")[0].replace("move[3]", "move_x, move_y, move_z")
    names = re.findall(r"\w+(?=[,;])", body)
    assert tuple(names) == STEP.names
    enumerated = (SIM / "player.h").read_text().partition("enum Symptom")[2].split("};")[0]
    assert len(re.findall(r"\bk[A-Z]", enumerated)) == len(SYMPTOMS)


def steps_of(script):
    return script.play("T", "f").script.steps


def test_a_script_knows_what_the_engine_holds():
    depth = SMALL.depth
    many = np.repeat(ONE, depth, 0)
    script = Script(SMALL)
    script.load(0, many).load(0, ONE, clear=False).run().load(0, ONE).load(1, ONE).run().reset().run()
    steps = steps_of(script)
    assert steps["held_a"].tolist() == [depth, depth, depth, 1, 1, 1, 0, 0]
    assert steps["overfull"].tolist() == [0, 1, 1, 0, 0, 0, 0, 0]
    runs = steps[steps["kind"] == RUN]
    assert runs["status"].tolist() == [Status.OVERFULL, Status.COMPLETE, Status.COMPLETE]
    assert runs["near_count"].tolist() == [0, 1, 0]


def test_a_reset_in_a_run_empties_the_meshes():
    script = Script(SMALL).load(0, ONE).load(1, ONE).run(traffic=Traffic(cut=3)).run()
    assert steps_of(script)["held_a"].tolist() == [1, 1, 0, 0]


def test_a_run_expects_what_its_mode_gives():
    script = Script(SMALL).load(0, np.repeat(ONE, 2, 0)).load(1, np.repeat(ONE, 3, 0))
    for mode in (*Mode, 3):
        script.run(mode=mode)
    script.run((127, 0, 0)).run((0, 0, 2), margin=1).run((0, 0, 2), margin=2)
    play = script.play("T", "f")
    runs = play.script.steps[play.script.steps["kind"] == RUN]
    assert runs["status"].tolist() == [2, 1, 1, 6, 4, 1, 1]
    assert runs["near_length"].tolist() == [1, 6, 0, 0, 0, 0, 6]
    assert runs["near_count"].tolist() == [1, 6, 6, 0, 0, 0, 6]
    assert runs["tested"].tolist() == [1, 6, 6, 0, 0, 0, 6]
    assert play.script.near[:3].tolist() == [[0, 0], [0, 0], [0, 1]]


def test_the_stimulus_repeats_by_its_seed_and_has_every_kind_of_step(seed):
    plays = engine_directed(SINGLE, seed)
    again = engine_directed(SINGLE, seed)
    assert all(
        (one.script.steps == other.script.steps).all() for one, other in zip(plays, again, strict=True)
    )
    steps = np.concatenate([play.script.steps for play in plays])
    assert set(steps["kind"]) == {0, 1, 2}
    runs = steps[steps["kind"] == RUN]
    assert set(runs["status"]) == set(Status) - {Status.ABORTED}
    assert (runs["abort_at"] >= 0).any() and (runs["cut"] >= 0).any() and (runs["hold"] > 0).any()
    assert (steps[steps["kind"] == LOAD]["clear"] == 0).any()


def test_extremes_take_every_counter_to_its_end(seed):
    depth, group = ENGINE.depth, ENGINE.group
    runs = np.concatenate([play.script.steps for play in engine_extremes(ENGINE, seed)])
    assert {int(runs[name].max()) for name in ("pairs_skipped", "tested", "near_count")} == {depth**2}
    for name in ("group_pairs_skipped", "group_pairs_opened"):
        assert runs[name].max() == (depth // group) ** 2
