"""Style, types, imports, testplan: Verilator, verible; ruff, import-linter, basedpyright."""

import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from triaxis.fpga.ecp5_timing import HARNESS as TIMING_HARNESS
from triaxis.fpga.ecp5_timing import TOP as TIMING_TOP
from triaxis.golden.errors import InputError
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.configuration import Configuration
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.paths import BUILD, DUT, ROOT, VERIF, board_sources, mesh_sources, rtl_sources
from triaxis.sim.toolchain import verilator
from triaxis.sim.verilate import elaboration
from triaxis.verif.signoff.testplan import check_plan

# Builds that differ in what they elaborate.
_BUILDS = (
    Configuration(),
    Configuration(8, 8),
    Configuration(32, 32),
    Configuration(24, 10),
    Configuration(13, 1, tag_bits=1),
    Configuration(16, 0, edge_box=False, gating=False),
)
_MESH_BUILDS = (
    MeshConfiguration(),
    MeshConfiguration(8, 0, depth=16, group=4, lanes=4),
    MeshConfiguration(32, 32, depth=64, group=8, lanes=2),
    MeshConfiguration(24, 2, lanes=1),
    MeshConfiguration(16, 16, depth=2, group=1, lanes=1),
)
_BOARD_BUILDS = (
    BoardParameters(depth=4096, clocks_per_bit=50),
    BoardParameters(32, 32),
    BoardParameters(13, 1, depth=128, group=16, lanes=4),
    BoardParameters(8, 0),
)


def _bin(name: str) -> str:
    return str(Path(sys.executable).with_name(name))


def _run(what: str, command: list[str]) -> bool:
    answer = subprocess.run(
        command,
        cwd=ROOT,
        env=verilator().environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    print(f"{'ok    ' if answer.returncode == 0 else 'FAILED'} {what}", flush=True)
    if answer.returncode:
        print(answer.stdout + answer.stderr, end="", flush=True)
    return answer.returncode == 0


def _verilator(top: str, parameters: dict[str, int], sources: Sequence[Path] = ()) -> list[str]:
    return [
        *elaboration(top, parameters), "--lint-only", "-Wall", *map(str, [*rtl_sources(), *sources]),
    ]  # fmt: skip


def _testplan() -> bool:
    """Check that the testplan names everything there is, and nothing else."""
    plan, problems = check_plan()
    print(f"{'FAILED' if problems else 'ok    '} testplan, {len(plan.testpoints)} testpoints", flush=True)
    for problem in problems:
        print(problem)
    return not problems


def _types() -> bool:
    """Check types; no file checked is a failure too."""
    _link_package()
    command = [_bin("basedpyright"), "--outputjson"]
    answer = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    report = json.loads(answer.stdout)
    checked = report["summary"]["filesAnalyzed"]
    good = answer.returncode == 0 and checked > 0
    print(f"{'ok    ' if good else 'FAILED'} basedpyright, {checked} files", flush=True)
    for found in report["generalDiagnostics"]:
        line = found["range"]["start"]["line"] + 1
        print(f"{Path(found['file']).resolve()}:{line}: {found['message']}")
    return good


def _link_package() -> None:
    """Lay out the package as links in build/typing: the type checker knows no package-dir."""
    folder = BUILD / "typing" / "triaxis"
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("bench", "coverage", "fpga", "golden", "host", "sim", "verif"):
        link = folder / name
        if not link.is_symlink():
            link.symlink_to(ROOT / name)


def lint(fix: bool) -> bool:
    """Return whether everything is clean; with ``fix``, format first."""
    folders = (DUT, VERIF, ROOT / "fpga")
    systemverilog = [str(path) for folder in folders for path in sorted(folder.rglob("*.sv"))]
    good = True
    if fix:
        good &= _run("verible format", [_bin("verible-verilog-format"), "--inplace", *systemverilog])
        good &= _run("ruff fix", [_bin("ruff"), "check", "--fix", "."])
        good &= _run("ruff format", [_bin("ruff"), "format", "."])
    for build in _BUILDS:
        good &= _run(
            f"verilator -Wall triaxis_core {build.name}",
            _verilator("triaxis_core", build.parameters),
        )
    for engine in _MESH_BUILDS:
        command = _verilator("triaxis_mesh", engine.parameters, mesh_sources())
        good &= _run(f"verilator -Wall triaxis_mesh {engine.name}", command)
    for board in _BOARD_BUILDS:
        command = _verilator("nexys4ddr_top", board.rtl, [*mesh_sources(), *board_sources()])
        good &= _run(f"verilator -Wall nexys4ddr_top {board.name}", command)
    command = _verilator(TIMING_TOP, {"W": 16}, [TIMING_HARNESS])
    good &= _run(f"verilator -Wall {TIMING_TOP}", command)
    good &= _run("verilator -Wall CollisionDetector", _verilator("CollisionDetector", {"W": 16}))
    good &= _run("verible lint", [_bin("verible-verilog-lint"), *systemverilog])
    good &= _run(
        "verible format",
        [_bin("verible-verilog-format"), "--verify", "--inplace", *systemverilog],
    )
    good &= _run("ruff check", [_bin("ruff"), "check", "."])
    good &= _run("ruff format", [_bin("ruff"), "format", "--check", "."])
    good &= _run("import-linter", [_bin("lint-imports"), "--no-cache"])
    good &= _testplan()
    return good & _types()


def main() -> int:
    """Run from the command line; exit code 0 clean, 1 not, 2 error."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fix", action="store_true", help="format the RTL and the Python code")
    try:
        return 0 if lint(parser.parse_args().fix) else 1
    except InputError as error:
        print(f"lint: error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
