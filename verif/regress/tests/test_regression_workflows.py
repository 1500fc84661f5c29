"""The files of GitHub Actions: they call make targets, and keep what must outlive a failing job."""

import re

import pytest

from triaxis.sim.paths import ROOT

yaml = pytest.importorskip("yaml", reason="PyYAML is not installed: run `make regress`, which installs it")

TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))


@pytest.mark.parametrize("path", sorted((ROOT / ".github" / "workflows").glob("*.yml")))
def test_workflow(path):
    content = yaml.safe_load(path.read_text())
    assert content["permissions"] == {"contents": "read"}
    for job in content["jobs"].values():
        assert job["timeout-minutes"] <= 360 and not job["runs-on"].endswith("latest")
        targets = [one["target"] for one in job.get("strategy", {}).get("matrix", {}).get("include", [])]
        for step in job["steps"]:
            if "uses" in step:
                assert re.fullmatch(r"actions/[\w/-]+@v\d+\.\d+\.\d+", step["uses"])
            if re.match("actions/(upload-artifact|cache/save)@", step.get("uses", "")):
                assert step["if"] == "always()"
                # Counterexamples that a failing run found are nowhere else.
                assert "build/kept" in step["with"]["path"] or job is content["jobs"].get("test")
            for target in targets or [""]:
                command = step.get("run", "make lint").replace("${{ matrix.target }}", target)
                assert command.removeprefix("make ") in TARGETS, command
