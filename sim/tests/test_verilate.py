"""A build has a name of its own for everything that goes in, and every block can be built in every way."""

from dataclasses import replace

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
from triaxis.sim.paths import DUT
from triaxis.sim.verilate import MANY, QUICK, product, verilate_command

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
            {"assertions": not build.assertions}, {"defines": {"MORE": 1}}, {"parameters": {"W": 9}},
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
