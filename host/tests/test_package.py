"""The wheel: whole outside a checkout."""

import os
import shutil
import subprocess
import sys
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


@pytest.mark.simulator
@pytest.mark.regress
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
    tritest = "import sys; from triaxis.host.cli import tritest; sys.exit(tritest())"
    for words in (["make", "set", "--pairs", "2"], ["recheck", "set"]):
        subprocess.run([sys.executable, "-c", tritest, *words], cwd=home, env=environment, check=True)
    built = Path(home, ".cache", "triaxis", version("triaxis"))
    assert any(built.iterdir()) and not (site / "triaxis" / "build").exists()
