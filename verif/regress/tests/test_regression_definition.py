"""The regressions as they are defined: complete, readable for dvsim, no less than the sign-off's plan."""

import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.paths import ROOT
from triaxis.verif.testbench.settings import PIN
from triaxis.verif.testbench.testnames import MESH_TESTS, REPLAY, TESTS

pytest.importorskip("hjson", reason="hjson is not installed: run `make regress`, which installs it")

from triaxis.verif.regress.definition import DEFINITION, read_definition
from triaxis.verif.regress.identity import source_files
from triaxis.verif.regress.plan import plan
from triaxis.verif.signoff.mesh_plan import mesh_plan
from triaxis.verif.signoff.plan import plan as signoff_plan

BILLION = 1_000_000_000


@pytest.fixture(scope="module")
def definition():
    return read_definition()


def test_every_test_is_in_the_nightly_regression(definition):
    """But the replay, which needs a file of pairs that failed."""
    found = {definition.items[name].test for name in definition.regression("nightly").items}
    assert found == {*TESTS, *MESH_TESTS} - {REPLAY}


def test_smoke_touches_every_test_configuration_and_agent(definition):
    smoke = [definition.items[name] for name in definition.regression("smoke").items]
    assert {item.test for item in smoke} == {*TESTS, *MESH_TESTS} - {REPLAY}
    assert {item.config for item in smoke} == {item.config for item in definition.items.values()}
    assert {item.agent for item in smoke} == {item.agent for item in definition.items.values()}
    assert set(definition.regression("smoke").items) <= set(definition.regression("nightly").items)


def test_every_item_is_run_and_named_after_what_it_is(definition):
    assert set(definition.regression("nightly").items) == set(definition.items)
    for name, item in definition.items.items():
        assert name.startswith(f"{item.test}_{item.config}")
        assert name.endswith("_pin") == (item.agent == PIN)


def test_nightly_is_no_less_than_the_signoff_from_a_billion_pairs(definition, seed):
    """Both are written down; here is what keeps them from drifting apart."""
    wanted, found = Counter(), Counter()
    for run in (*signoff_plan(seed, BILLION), *mesh_plan(seed)):
        wanted[run.test, run.config, run.agent] += run.pairs
    nightly = plan(definition, "nightly", seed)
    for run in nightly:
        found[run.test, run.config, run.agent] += run.pairs
    short = {key: (found[key], pairs) for key, pairs in wanted.items() if found[key] < 0.999 * pairs}
    assert not short
    assert sum(run.pairs for run in nightly if run.test == "VolumeTest") > BILLION
    goal = definition.regression("nightly")
    assert goal.least_pairs == BILLION
    assert goal.all_covered


def test_builds_hold_the_simulators_that_their_tests_need(definition):
    agents = {
        mode["name"]: set(re.findall(r"--agent (\w+)", " ".join(mode.get("build_opts", []))))
        for mode in definition.content["build_modes"]
    }
    for item in definition.items.values():
        assert item.agent in agents[item.config], item.name
    for name, found in agents.items():
        needed = {item.agent for item in definition.items.values() if item.config == name}
        assert found == needed, name


def test_every_number_of_seeds_has_its_reason():
    """Tests stand in groups; the comment above each says why so many seeds."""
    text = DEFINITION.read_text().split("  tests: [\n", 1)[1].split("\n  ]\n", 1)[0]
    groups = text.strip("\n").split("\n\n")
    assert len(groups) > 5
    for group in groups:
        comment = " ".join(line.strip(" /") for line in group.splitlines() if line.strip().startswith("//"))
        assert re.search(r"[Ss]eed", comment), group
        assert "reseed" in group


def test_seeds_follow_from_one_and_no_two_runs_share_theirs(definition, seed):
    runs = plan(definition, "nightly", seed)
    assert runs == plan(definition, "nightly", seed)
    assert len({run.key for run in runs}) == len(runs)
    assert len({run.seed for run in runs}) == len(runs)
    other = plan(definition, "nightly", seed + 1)
    assert not {run.seed for run in runs} & {run.seed for run in other}


def test_more_seeds_begin_with_the_same(definition, seed):
    few, many = plan(definition, "smoke", seed), plan(definition, "smoke", seed, 3.0)
    assert len(many) == 3 * len(few)
    assert {run.key for run in few} < {run.key for run in many}


def test_dvsim_reads_the_file():
    dvsim = Path(sys.executable).with_name("dvsim")
    if not dvsim.exists():
        pytest.skip("dvsim is not installed: run `make regress`, which installs it")
    scratch = ROOT / "build" / "regress-tests" / "list"
    answer = subprocess.run(
        [dvsim, DEFINITION, "--proj-root", ROOT, "--scratch-root", scratch, "--list", "regressions", "tests"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    listed = answer.stdout + answer.stderr
    assert answer.returncode == 0, listed
    assert "ERROR" not in listed
    assert "not found" not in listed
    assert all(word in listed for word in ("smoke", "nightly", "VolumeTest_w32_m32"))


def test_dvsim_runs_each_test_in_its_own_configuration(definition, tmp_path):
    """dvsim takes two builds for one where their commands are the same but for the name."""
    dvsim = Path(sys.executable).with_name("dvsim")
    if not dvsim.exists():
        pytest.skip("dvsim is not installed: run `make regress`, which installs it")
    subprocess.run(
        [dvsim, DEFINITION, "--proj-root", ROOT, "--scratch-root", tmp_path, "--fake", "-i", "nightly"],
        capture_output=True, check=False,
    )  # fmt: skip
    jobs = json.loads(next(tmp_path.glob("deploy_*.json")).read_text())
    builds = [job["name"] for job in jobs if job["job_type"] == "CompileSim"]
    assert sorted(builds) == sorted({item.config for item in definition.items.values()})
    runs = [job for job in jobs if job["job_type"] == "RunTest"]
    assert len(runs) == sum(item.seeds for item in definition.items.values())
    for job in runs:
        item = definition.items[job["name"]]
        words = f"--test {item.test} --config {item.config} --seed {job['seed'] & 0xFFFFFFFF} "
        assert words in job["cmd"], job["cmd"]
        assert f"--pairs {item.pairs}" in job["cmd"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("reseed: 2", "reseed: 0"), "must be at least 1"),
        (('uvm_test: "MixedTest"', 'uvm_tset: "MixedTest"'), "uvm_test"),
        (('build_mode: "w24_m24"', 'build_mode: "w25_m24"'), "no build mode w25_m24"),
        (('"--pairs 3000"]', '"--pears 3000"]'), "run_opts"),
        (('regression: "nightly"', 'regression: "daily"'), "goals of daily"),
        (("SeedVectorsTest_w16_m0\n", "SeedVectorsTest_w17_m0\n"), "no test SeedVectorsTest_w17_m0"),
        (("  tests: [\n", "  tests: {\n"), "not a definition"),
    ],
)
def test_a_broken_file_is_refused(tmp_path, change, message):
    text, (right, wrong) = DEFINITION.read_text(), change
    assert right in text
    path = tmp_path / "broken.hjson"
    path.write_text(text.replace(right, wrong, 1))
    with pytest.raises(InputError, match=message):
        read_definition(path)


def test_unknown_regression(definition):
    with pytest.raises(InputError, match="regression weekly: unknown; one of: smoke, nightly"):
        definition.regression("weekly")


def test_results_are_valid_for_all_that_a_simulation_loads():
    """Whatever Python files the simulator's process imports of ours count among what results are of."""
    code = (
        "import json, os, sys; from triaxis.verif.testbench.settings import RunSettings; "
        "os.environ.update(RunSettings('MixedTest', 1, 'w16_m0', 1, '.').to_environment()); "
        "import triaxis.verif.core.uvm_tests, triaxis.verif.testbench.simulation; "
        "files = [getattr(m, '__file__', None) for n, m in sys.modules.items() if n.startswith('triaxis.')]; "
        "print(json.dumps([f for f in files if f]))"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {Path(name).resolve() for name in json.loads(answer.stdout)}
    assert len(loaded) > 40
    assert loaded - {path.resolve() for path in source_files()} == set()
