"""Style, types, imports, testplan: Verilator, verible, slang; ruff, import-linter, basedpyright."""

import argparse
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from triaxis.fpga.board_build import TOP as BOARD
from triaxis.fpga.board_build import TWICE, bitstream_sources
from triaxis.fpga.gowin_timing import HARNESS as TIMING_HARNESS
from triaxis.fpga.gowin_timing import TOP as TIMING_TOP
from triaxis.fpga.register_block import REGISTERS_RTL, SOC_RTL
from triaxis.golden.errors import InputError
from triaxis.golden.processes import threads
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.configuration import Configuration
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.paths import BUILD, DUT, ROOT, SIM, VERIF, board_sources, mesh_sources, rtl_sources
from triaxis.sim.slang import compiled
from triaxis.sim.toolchain import verilator
from triaxis.sim.verilate import elaboration

# Builds that differ in what they elaborate.
_BUILDS = (
    Configuration(),
    Configuration(8, 8),
    Configuration(32, 32),
    Configuration(24, 10),
    Configuration(13, 1, tag_bits=1),
    Configuration(16, 0, edge_box=False, gating=False),
    Configuration(16, 16, certified=True),
    Configuration(9, 0, tag_bits=1, certified=True),
)
_MESH_BUILDS = (
    MeshConfiguration(certified=True),
    MeshConfiguration(8, 0, depth=16, group=4, lanes=4),
    MeshConfiguration(32, 32, depth=64, group=8, lanes=2),
    MeshConfiguration(24, 2, lanes=1),
    MeshConfiguration(16, 16, depth=2, group=1, lanes=1, certified=True),
)
_BOARD_BUILDS = (
    BoardParameters(depth=4096, clocks_per_three_bits=25),
    BoardParameters(32, 32),
    BoardParameters(13, 1, depth=128, group=16, lanes=4),
    BoardParameters(8, 0),
)
_SOC_BUILDS = ({"W": 16}, {"W": 32, "M": 0, "Depth": 32768}, {"W": 8, "M": 1, "Depth": 64, "Certify": 0})

# What no synthesis may merge, remove or move, by its place in the board's top: what is there twice, the
# registers of go and stop, synchronisers.
_KEPT = {
    **{place: {"keep_hierarchy": "yes", "dont_touch": "yes"} for place in TWICE},
    **{
        f"g_safety[{k}].u_safety.{register}": {"keep": "true", "dont_touch": "true"}
        for k in range(2)
        for register in ("go_q", "stop_q")
    },
    "u_reset.stage_q": {"ASYNC_REG": "TRUE"},
    "u_receiver.u_uart.line_q": {"ASYNC_REG": "TRUE"},
}

# A finding of Verilator, or of verible, which names the place first; what else they print explains it.
_FINDING = re.compile(r"%(?:Warning|Error)[^:]*: (?!Exiting)|\S+\.svh?:")


def _bin(name: str) -> str:
    return str(Path(sys.executable).with_name(name))


def _told(what: str, good: bool, output: str = "") -> bool:
    """Print how a check went, in one piece: others may print at the same time."""
    print(f"{'ok    ' if good else 'FAILED'} {what}\n{'' if good else output}", end="", flush=True)
    return good


def _run(what: str, command: Sequence[str], apart: bool = False) -> bool:
    answer = _answer_apart(command) if apart else _answer(command)
    return _told(what, answer.returncode == 0, answer.stdout + answer.stderr)


def _answer(command: Sequence[str], folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            command,
            cwd=folder or ROOT,
            env=verilator().environment(),
            capture_output=True,
            text=True,
            check=False,
        )
    except FileNotFoundError as error:
        raise InputError(f"{command[0]}: not found: run `make lint`, which installs it") from error


def _answer_apart(command: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run a linter in an empty folder: Verilator would take modules and includes from where it is run, which
    are in no list of the RTL, and so in no hash of it.
    """
    with TemporaryDirectory() as folder:
        return _answer(command, Path(folder))


def rtl_linters() -> dict[str, list[str]]:
    """Return the commands of the linters of all SystemVerilog, by name; they change nothing."""
    found: dict[str, list[str]] = {}
    for top, parameters, sources, name in _elaborations():
        files = map(str, [*rtl_sources(), *sources])
        command = [*elaboration(top, parameters), "--lint-only", "-Wall", *files]
        found[f"verilator -Wall {top} {name}".rstrip()] = command
    found["kept in synthesis"] = [sys.executable, "-m", "triaxis.verif.lint", "--kept"]
    found["verible lint"] = [_bin("verible-verilog-lint"), *_systemverilog()]
    found["verible format"] = [*_verible_format(), "--verify"]
    return found


def not_kept(dut: Path = DUT) -> list[str]:
    """Return what of the board lacks the attributes by which synthesis keeps it, a line each."""
    compilation = compiled(bitstream_sources(dut), dut / "core", BOARD, {})
    (top,) = compilation.getRoot().topInstances
    found: dict[str, dict[str, str]] = {}

    def visit(symbol: Any) -> None:
        for attribute in compilation.getAttributes(symbol) if hasattr(symbol, "hierarchicalPath") else ():
            number = int(attribute.value.value)
            text = number.to_bytes((number.bit_length() + 7) // 8).decode(errors="replace")
            found.setdefault(symbol.hierarchicalPath.removeprefix(f"{BOARD}."), {})[attribute.name] = text

    top.visit(visit)
    return [
        f"{BOARD}.sv: {place}: must have {name} = {value}"
        for place, wanted in _KEPT.items()
        for name, value in wanted.items()
        if found.get(place, {}).get(name) != value
    ]


def _systemverilog() -> list[str]:
    folders = (DUT, SIM, VERIF, ROOT / "fpga")
    found = [path for folder in folders for path in sorted(folder.rglob("*.sv*"))]
    # What PeakRDL makes has its own style.
    return [str(path) for path in found if path not in REGISTERS_RTL]


def _verible_format() -> list[str]:
    return [_bin("verible-verilog-format"), "--inplace", *_systemverilog()]


def lint_rtl(linters: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Run these linters; return what each found, a line each: none where it is content."""
    with threads(os.cpu_count() or 1) as pool:
        answers = pool.map(_answer_apart, linters.values())
        return {what: _findings(answer) for what, answer in zip(linters, answers, strict=True)}


def _findings(answer: subprocess.CompletedProcess[str]) -> list[str]:
    """Return the findings; one that failed without any has its exit code as its finding."""
    lines = (answer.stdout + answer.stderr).replace(f"{ROOT}/", "").splitlines()
    found = list(dict.fromkeys(line.strip() for line in lines if _FINDING.match(line)))
    return found or ([f"exit code {answer.returncode}"] if answer.returncode else [])


def _elaborations() -> Iterator[tuple[str, dict[str, int], list[Path], str]]:
    """Yield top, parameters, sources besides the core's, and name of all that is elaborated."""
    for build in _BUILDS:
        yield build.top, build.parameters, [], build.name
    for engine in _MESH_BUILDS:
        yield "triaxis_mesh", engine.parameters, mesh_sources(), engine.name
    for board in _BOARD_BUILDS:
        yield "nexys4ddr_top", board.rtl, [*mesh_sources(), *board_sources()], board.name
    for parameters in _SOC_BUILDS:
        name = "_".join(f"{key.lower()}{value}" for key, value in parameters.items())
        yield "triaxis_soc", parameters, [*mesh_sources(), *SOC_RTL], name
    yield TIMING_TOP, {"W": 16}, [TIMING_HARNESS], ""
    yield "CollisionDetector", {"W": 16}, [], ""


def _types() -> bool:
    """Check types; no file checked is a failure too."""
    _link_package()
    answer = _answer([_bin("basedpyright"), "--outputjson"])
    try:
        report = json.loads(answer.stdout)
    except ValueError:
        return _told("basedpyright", False, answer.stdout + answer.stderr)
    checked = report["summary"]["filesAnalyzed"]
    said = "".join(
        f"{Path(found['file']).resolve()}:{found['range']['start']['line'] + 1}: {found['message']}\n"
        for found in report["generalDiagnostics"]
    )
    return _told(f"basedpyright, {checked} files", answer.returncode == 0 and checked > 0, said)


def _link_package() -> None:
    """Lay out the package as links in build/typing: the type checker knows no package-dir."""
    folder = BUILD / "typing" / "triaxis"
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("bench", "coverage", "fpga", "golden", "host", "sim", "verif"):
        link = folder / name
        # In a checkout that was copied or moved it leads to another one, which would be checked instead.
        if not link.is_symlink() or link.readlink() != ROOT / name:
            link.unlink(missing_ok=True)
            link.symlink_to(ROOT / name)


def lint(fix: bool) -> bool:
    """Return whether everything is clean; with ``fix``, format first."""
    good = True
    if fix:
        good &= _run("verible format", _verible_format())
        good &= _run("ruff fix", [_bin("ruff"), "check", "--fix", "."])
        good &= _run("ruff format", [_bin("ruff"), "format", "."])
    # What takes longest first.
    checks: list[Callable[[], bool]] = [_types]
    for what, command in (
        # By its command: the sign-off, to which the testplan belongs, imports this.
        ("testplan", [_bin("triaxis"), "coverage", "plan"]),
        ("ruff check", [_bin("ruff"), "check", "."]),
        ("ruff format", [_bin("ruff"), "format", "--check", "."]),
        ("import-linter", [_bin("lint-imports"), "--no-cache"]),
    ):
        checks.append(partial(_run, what, command))
    checks[2:2] = [partial(_run, what, command, apart=True) for what, command in rtl_linters().items()]
    with threads(os.cpu_count() or 1) as pool:
        return all([good, *pool.map(lambda check: check(), checks)])


def main() -> int:
    """Run from the command line; exit code 0 clean, 1 not, 2 error."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fix", action="store_true", help="format the RTL and the Python code")
    parser.add_argument("--kept", action="store_true", help="look at what synthesis is to keep, alone")
    options = parser.parse_args()
    try:
        if options.kept:
            print("\n".join(found := not_kept()))
            return 1 if found else 0
        return 0 if lint(options.fix) else 1
    except InputError as error:
        print(f"lint: error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
