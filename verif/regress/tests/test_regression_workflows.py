"""The files of GitHub Actions: readable, pinned, and nothing but make targets in them."""

import re

import pytest

from triaxis.sim.paths import ROOT

yaml = pytest.importorskip("yaml", reason="PyYAML is not installed: run `make regress`, which installs it")

FOLDER = ROOT / ".github" / "workflows"
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))


def workflow(name):
    return yaml.safe_load((FOLDER / name).read_text())


def commands(name):
    """Return what the run steps call, with the values of a matrix filled in."""
    found = []
    for job in workflow(name)["jobs"].values():
        targets = [one["target"] for one in matrix(job)] or [""]
        for step in job["steps"]:
            if "run" in step:
                found += [step["run"].replace("${{ matrix.target }}", target) for target in targets]
    return found


def matrix(job):
    return job.get("strategy", {}).get("matrix", {}).get("include", [])


@pytest.mark.parametrize("name", ["pull-request.yml", "nightly.yml"])
def test_steps_call_only_make_targets(name):
    found = commands(name)
    assert found
    for command in found:
        assert re.fullmatch(r"make [a-z-]+", command), command
        assert command.removeprefix("make ") in TARGETS, command


@pytest.mark.parametrize("name", ["pull-request.yml", "nightly.yml"])
def test_actions_are_pinned_and_jobs_limited(name):
    content = workflow(name)
    assert content["permissions"] == {"contents": "read"}
    for job in content["jobs"].values():
        assert job["timeout-minutes"] <= 360
        assert not job["runs-on"].endswith("latest")
        for step in job["steps"]:
            if "uses" in step:
                assert re.fullmatch(r"actions/[\w/-]+@v\d+\.\d+\.\d+", step["uses"])


def test_what_must_outlive_a_failing_job_is_kept_whatever_happens():
    for name in ("pull-request.yml", "nightly.yml"):
        for job in workflow(name)["jobs"].values():
            for step in job["steps"]:
                if re.match("actions/(upload-artifact|cache/save)@", step.get("uses", "")):
                    assert step["if"] == "always()"


def test_pictures_and_kept_cases_are_uploaded_and_each_attempt_has_its_own_cache():
    for name in ("pull-request.yml", "nightly.yml"):
        steps = [step for job in workflow(name)["jobs"].values() for step in job["steps"]]
        for step in steps:
            if step.get("uses", "").startswith("actions/upload-artifact"):
                assert "verif/core/kept/*.json" in step["with"]["path"]
                assert "/**/*.png" in step["with"]["path"]
            if step.get("uses", "").startswith("actions/cache/"):
                assert step["with"]["key"].endswith("${{ github.run_id }}-${{ github.run_attempt }}")


def test_artifacts_are_taken_from_where_results_are_written():
    sources = "".join(path.read_text() for path in (ROOT / "verif").glob("*/*.py"))
    for one in matrix(workflow("nightly.yml")["jobs"]["checks"]):
        assert f'BUILD / "{one["folder"]}"' in sources


def test_when_they_run():
    # YAML takes the key `on` for a truth value.
    assert "pull_request" in workflow("pull-request.yml")[True]
    assert workflow("nightly.yml")[True]["schedule"]
    assert set(commands("pull-request.yml")) == {"make test", "make regress", "make signoff"}
    assert set(commands("nightly.yml")) == {
        "make nightly", "make mutate", "make formal", "make exhaustive", "make signoff",
    }  # fmt: skip
