"""Builds of the RTL that follow their own switching activity, kept in build/traced/."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from triaxis.golden.native import cxx, target
from triaxis.sim.build import built, content_hash, core_files, run_tool
from triaxis.sim.paths import BUILD, DUT, rtl_sources
from triaxis.sim.toolchain import verilator

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class TracedBuild:
    """A module and the harness around it.

    ``above``: what compiles after the files of the core. ``prefix``: Verilator's name for the model.
    ``harnesses``: the harness in bench/activity/, then the files that it includes.
    """

    name: str
    top: str
    prefix: str
    parameters: Mapping[str, int]
    defines: Mapping[str, int]
    harnesses: tuple[Path, ...]
    above: Sequence[Path] = ()


def traced_library(build: TracedBuild, dut: Path = DUT) -> Path:
    """Return the shared library, built where needed. ``dut``: another folder of RTL with the same files."""
    defines = " ".join(f"-D{name}={value}" for name, value in build.defines.items())
    command = [
        "--cc", "--exe", "--build", "-j", "2", "--trace-saif", "--no-public-flat-rw", "-O3",
        "--x-assign", "fast", "--x-initial", "fast", "--top-module", build.top, "--prefix", build.prefix,
        *(f"-G{name}={value}" for name, value in build.parameters.items()),
        "-CFLAGS", f"-fPIC -std=c++20 -I{FOLDER} {defines}", "-LDFLAGS", "-shared",
        "-MAKEFLAGS", "OPT_FAST=-O1 OPT_GLOBAL=-O2",
    ]  # fmt: skip
    harness, *included = build.harnesses
    sources = [*rtl_sources(dut), *build.above, harness]
    hashed = [*sources, *included, *sorted(FOLDER.glob("*.h")), *core_files(dut)]
    key = content_hash(hashed, str(verilator()), target(cxx()), *command)
    folder = BUILD / "traced" / f"{build.name}-{key[:12]}"
    file = f"lib{build.prefix}.so"

    def make(partial: Path) -> None:
        what = f"{build.name} with a trace"
        print(f"building {what} (once) ..", file=sys.stderr, flush=True)
        output = [f"-I{dut / 'core'}", "--Mdir", str(partial / "obj"), "-o", str(partial / file)]
        command_line = [str(verilator().executable), *command, *output, *map(str, sources)]
        run_tool(command_line, partial, what)

    return built(folder, make) / file
