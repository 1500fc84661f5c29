"""The regressions as they are made of the table of tests: complete, and readable for dvsim."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from triaxis.golden.errors import InputError
from triaxis.verif.regress.covering import array_runs
from triaxis.verif.regress.definition import NIGHTLY, read_definition, write_view
from triaxis.verif.signoff.plan import plan
from triaxis.verif.testbench.table import configurations, planned_tests

BILLION = 1_000_000_000


@pytest.fixture(scope="module")
def definition():
    return read_definition()


def test_nightly_runs_everything_and_smoke_each_test_and_configuration_once(definition):
    assert set(definition.regression(NIGHTLY).items) == set(definition.items)
    smoke = [definition.items[name] for name in definition.regression("smoke").items]
    of_arrays = {config for _, runs in array_runs() for config in runs.configs}
    for items, more in ((smoke, set[str]()), (definition.items.values(), of_arrays)):
        assert {item.run.test for item in items} == set(planned_tests())
        assert {item.run.config for item in items} == set(configurations()) | more
        assert {item.run.agent for item in items} == {"pin", "burst"}
    goal = definition.regression(NIGHTLY)
    assert goal.least_pairs == BILLION and goal.all_covered
    # The arrays' coverage is not asked for; that of the others is, whatever the arrays hold.
    assert goal.uncovered == of_arrays - set(configurations())


def test_nightly_is_no_less_than_the_signoff_and_no_two_runs_share_a_seed(definition, seed):
    nightly = definition.plan(NIGHTLY, seed)
    for run in plan(seed, BILLION):
        same = [r.pairs for r in nightly if (r.test, r.config, r.agent) == (run.test, run.config, run.agent)]
        assert max(same) >= run.pairs, run
    assert sum(run.pairs for run in nightly if run.test == "VolumeTest") > BILLION
    assert nightly == definition.plan(NIGHTLY, seed)
    seeds = {run.seed for run in nightly}
    assert len({run.key for run in nightly}) == len(seeds) == len(nightly)
    assert not seeds & {run.seed for run in definition.plan(NIGHTLY, seed + 1)}
    assert len(definition.plan("smoke", seed, 3.0)) == 3 * len(definition.plan("smoke", seed))


def test_dvsim_runs_each_test_in_its_own_configuration(definition, tmp_path):
    """The contract with dvsim: what it makes of the file and of our view of the testplan."""
    dvsim = pytest.importorskip("dvsim.testplan", reason="dvsim is absent: `make .venv/.ready-regress`")
    view = tmp_path / "testplan.hjson"
    write_view(view, list(definition.items.values()))
    points = dvsim.Testplan(str(view), tmp_path, "triaxis").testpoints
    assert all(point.tests or point.not_mapped for point in points)
    assert any("VolumeTest_w16_m0" in point.tests for point in points)
    path = tmp_path / "cfg.hjson"
    path.write_text(json.dumps({**definition.content, "testplan": str(view)}))
    subprocess.run(
        [Path(sys.executable).with_name("dvsim"), path, "--scratch-root", tmp_path, "--fake", "-i", NIGHTLY],
        capture_output=True, check=False, cwd=Path(__file__).parents[3],
    )  # fmt: skip
    jobs = json.loads(next(tmp_path.glob("deploy_*.json")).read_text())
    builds = [job["name"] for job in jobs if job["job_type"] == "CompileSim"]
    # dvsim takes two builds for one where their commands are the same but for the name.
    assert sorted(builds) == sorted({item.run.config for item in definition.items.values()})
    runs = [job for job in jobs if job["job_type"] == "RunTest"]
    assert len(runs) == sum(item.seeds for item in definition.items.values())
    for job in runs:
        run = definition.items[job["name"]].run
        words = f"--test {run.test} --config {run.config} --seed {job['seed'] & 0xFFFFFFFF} "
        assert words in job["cmd"] and f"--pairs {run.pairs}" in job["cmd"], job["cmd"]


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ('"reseed": 2', '"reseed": 0', "must be at least 1"),
        ('"smoke", "reseed": 1', '"smoke", "reseed": -3', "regression smoke: reseed -3: must be at least 1"),
        ("--judged 1", "--judged 0", "--pairs and --judged must be at least 1"),
        ('"uvm_test": "MixedTest"', '"uvm_tset": "MixedTest"', "uvm_test"),
        ('"build_mode": "w24_m24"', '"build_mode": "w25_m24"', "no build mode w25_m24"),
        ('"--agent pin", "--j', '"--agent pen", "--j', "must be --pairs N, --judged N, --agent pin or burst"),
        ('"regression": "nightly"', '"regression": "daily"', "goals of daily"),
        (
            '"pairs": 1000000000, "coverage"',
            '"pair": 1000000000, "coverage"',
            "goals of nightly: pair: one of",
        ),
        ('"goals": [', '"goals": [{"regression": "nightly", "pairs": 9}, ', "goals: two of nightly"),
        ('"regressions": [', '"regressions": [{"name": "smoke"}, ', "regressions: two of smoke"),
        ('"tests": ["Reg', '"tests": ["Rag', "no test RagressionsTest_w16_m0"),
        ('"tests": [{', '"tests": {{', "not a definition"),
        ('"MixedTest_w16_m0"', '"MixedTest_w8_m8"', "two tests have the same name"),
        ('1, "tests": [', '1, "tests": [], "x": [', "regression smoke: it has no tests"),
    ],
)
def test_a_broken_file_is_refused(definition, tmp_path, right, wrong, message):
    text = json.dumps(definition.content)
    assert right in text
    path = tmp_path / "broken.hjson"
    path.write_text(text.replace(right, wrong, 1))
    with pytest.raises(InputError, match=message):
        read_definition(path)
