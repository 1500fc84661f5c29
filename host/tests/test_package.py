"""The wheel: whole outside a checkout; for meshes it needs no package of its extras."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest

from triaxis.host import scenes
from triaxis.sim.paths import ROOT

# Packages and what makes a wheel of them.
SOURCES = (
    "bench",
    "coverage",
    "dut",
    "fpga",
    "golden",
    "host",
    "sim",
    "verif",
    "pyproject.toml",
    "README.md",
    "LICENSE",
)


# As where these are not installed.
HIDDEN = """
import sys

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Hidden())
"""


@pytest.mark.simulator
@pytest.mark.long
def test_a_wheel_decides_outside_a_checkout(tmp_path):
    source, site, home = tmp_path / "source", tmp_path / "site", tmp_path / "home"
    source.mkdir()
    home.mkdir()
    for name in SOURCES:
        place = ROOT / name
        copy = shutil.copytree if place.is_dir() else shutil.copy
        copy(place, source / name)
    pip = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "-q",
        "--no-deps",
        "--no-build-isolation",
        "-w",
        tmp_path,
        source,
    ]
    subprocess.run([str(word) for word in pip], check=True)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    names = [re.split(r"[<>=]", word)[0].replace("-", "_") for word in extras["signoff"]]
    (site / "sitecustomize.py").write_text(HIDDEN.format(names))
    scenes.write_stl(home / "a.stl", scenes.box((0, 0, 0), (1, 1, 1)))
    scenes.write_stl(home / "b.stl", scenes.box((3, 0, 0), (4, 1, 1)))
    kept = {key: value for key, value in os.environ.items() if key in ("PATH", "CXX")}
    environment = kept | {"HOME": str(home), "PYTHONPATH": str(site)}
    code = "import sys; from triaxis.host.cli import main; sys.exit(main(sys.argv[1:]))"
    for engine, clearance, status in (("bulk", "1", 0), ("golden", "2", 1), ("rtl", "2", 1)):
        words = ["check", "a.stl", "b.stl", "--clearance", clearance, "--engine", engine, "--width", "8"]
        words += ["--resolution", "0.1"]
        done = subprocess.run(
            [sys.executable, "-c", code, *words],
            cwd=home,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == status, done.stderr
    words = [sys.executable, "-c", code, "coverage", "plan"]
    done = subprocess.run(words, cwd=home, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert re.search(rf"({'|'.join(names)}) is not installed: pip install 'triaxis\[signoff\]'", done.stderr)
    tritest = "import sys; from triaxis.host.cli import tritest; sys.exit(tritest())"
    for words in (["make", "set", "--pairs", "2"], ["recheck", "set"]):
        subprocess.run([sys.executable, "-c", tritest, *words], cwd=home, env=environment, check=True)
    built = Path(home, ".cache", "triaxis", version("triaxis"))
    assert any(built.iterdir()) and not (site / "triaxis" / "build").exists()
