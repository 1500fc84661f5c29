"""A build has a name of its own for everything that goes in, and every block can be built in every way."""

import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.configuration import Configuration
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.models import (
    asserted,
    bare_build,
    board_build,
    core_build,
    detector_build,
    mesh_build,
    mesh_pin_build,
    pin_build,
    safety_build,
)
from triaxis.sim.paths import DUT, SIM
from triaxis.sim.verilate import FAST, MANY, QUICK, compiler, product, runtime, verilate_command

CORE, MESH = Configuration(8, 8), MeshConfiguration(8, 0, depth=16, group=4, lanes=4)
BLOCKS = (
    core_build(CORE), mesh_build(MESH), detector_build(8), board_build(BoardParameters(8, 0)), safety_build(),
    pin_build(CORE), mesh_pin_build(MESH), asserted(core_build(CORE)), bare_build(),
)  # fmt: skip


@pytest.mark.parametrize("build", BLOCKS, ids=lambda build: f"{build.kind}-{build.form.value}")
def test_every_variant_is_a_build_of_its_own(build, tmp_path):
    variants = [
        replace(build, **change)
        for change in (
            {}, {"counters": True}, {"traced": True}, {"selectable": True}, {"speed": MANY}, {"split": 0},
            {"plain": True}, {"assertions": not build.assertions}, {"defines": {"MORE": 1}}, {"parameters": {"W": 9}},
        )
    ]  # fmt: skip
    assert len({variant.hashed for variant in variants}) == len(variants)
    assert all(path.is_file() for path in (*build.sources, *build.cpp, *build.above, *build.headers))
    command = verilate_command(build, tmp_path)
    assert command.index("--top-module") < command.index("--cc") < command.index(str(build.sources[-1]))


def test_the_folder_of_the_rtl_stands_for_its_contents(tmp_path):
    import shutil

    copy = shutil.copytree(DUT, tmp_path / "dut")
    here, there = (replace(core_build(CORE, dut), speed=QUICK) for dut in (DUT, copy))
    assert there.hashed == here.hashed
    (copy / "core" / "triaxis_stage.svh").write_text("// Another.")
    assert there.hashed != here.hashed


def test_names_say_what_is_special():
    build = core_build(CORE)
    assert replace(build, counters=True, selectable=True).kind == "w8_m8_covered_mutated"
    assert (product(build), product(pin_build(CORE))) == ("libtop.so", "triaxis_core")


def _checked(tmp_path, rng, header):
    """Compile the comparison of a header with Verilator's arithmetic, and run it."""
    source = tmp_path / "check.cpp"
    source.write_text((Path(__file__).parent / "arithmetic_check.cpp").read_text())
    (tmp_path / "arithmetic.h").write_text(header)
    build = core_build(CORE)
    command = [*compiler(build, FAST), "-o", str(tmp_path / "check"), str(source), str(runtime(build))]
    subprocess.run(command, check=True)
    return subprocess.run(
        [tmp_path / "check", str(rng.integers(1 << 32))], capture_output=True, text=True, check=False
    )


@pytest.mark.simulator
def test_arithmetic_is_that_of_verilator(rng, tmp_path):
    header = (SIM / "arithmetic.h").read_text()
    assert _checked(tmp_path, rng, header).returncode == 0
    broken = header.replace("(64 - bits)", "(63 - bits)")
    assert "not what Verilator's gives" in _checked(tmp_path, rng, broken).stdout
