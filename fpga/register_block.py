"""What is made of the registers of `fpga/soc/triaxis_soc.rdl`, by PeakRDL: RTL, C header, text, pyuvm.

RTL, header and text are kept with the sources, so that nobody needs PeakRDL to use them:

    fpga/soc/triaxis_soc_regs_pkg.sv, fpga/soc/triaxis_soc_regs.sv, docs/triaxis_soc.h, docs/registers.md

A register model for pyuvm, a Python module, is made where it is asked for.
"""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder, write_whole
from triaxis.sim.paths import ROOT, listed

SOC = Path(__file__).with_name("soc")
RDL = SOC / "triaxis_soc.rdl"
REGISTERS_RTL = tuple(SOC / f"triaxis_soc_regs{part}.sv" for part in ("_pkg", ""))
SOC_RTL = tuple(listed(SOC / "triaxis_soc.f"))
HEADER, TEXT = ROOT / "docs" / "triaxis_soc.h", ROOT / "docs" / "registers.md"
MODEL = "triaxis_soc_ral.py"
_MADE = "Made of fpga/soc/triaxis_soc.rdl by `triaxis fpga registers`: change that, and make it again."
_NOTICE = f"""\
// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// {_MADE}
"""
# Of what is made, which is sound: fields of one structure are written by a process each, and not all is used.
_OFF = ("GENUNNAMED", "MULTIDRIVEN", "UNUSEDPARAM", "UNUSEDSIGNAL")
_PACKED = "__attribute__ ((__packed__)) "


def _root() -> Any:
    try:
        from peakrdl_regblock.udps import ALL_UDPS
        from systemrdl.compiler import RDLCompiler
    except ImportError as error:
        raise InputError("registers: PeakRDL is absent: `make .venv/.ready-regress` installs it") from error
    compiler = RDLCompiler()
    # Properties that the maker of RTL asks for; none is used.
    for udp in ALL_UDPS:
        compiler.register_udp(udp)
    compiler.compile_file(str(RDL))
    return compiler.elaborate().top


def _rtl(root: Any, folder: Path) -> None:
    from peakrdl_regblock import RegblockExporter
    from peakrdl_regblock.cpuif.axi4lite import AXI4Lite_Cpuif_flattened

    RegblockExporter().export(
        root, str(folder), cpuif_cls=AXI4Lite_Cpuif_flattened,
        default_reset_activelow=True, default_reset_async=True,
    )  # fmt: skip


def _header(root: Any, folder: Path) -> None:
    from peakrdl_cheader.exporter import CHeaderExporter

    CHeaderExporter().export(root, str(folder / HEADER.name))


def _text(root: Any, folder: Path) -> None:
    from peakrdl_markdown import MarkdownExporter

    MarkdownExporter().export(root, str(folder / TEXT.name))


def _model(root: Any, folder: Path) -> None:
    from peakrdl_pyuvm.exporter import PyUVMExporter

    PyUVMExporter().export(root, str(folder / MODEL))


def _lint(to: str) -> str:
    return "".join(f"// verilator lint_{to} {rule}\n" for rule in _OFF)


def register_files() -> dict[Path, str]:
    """Return what the files in the repository are to hold. Raises InputError where PeakRDL is not there."""
    root = _root()
    with TemporaryDirectory() as name:
        folder = Path(name)
        for make in (_rtl, _header, _text):
            make(root, folder)
        notes: dict[Path, Callable[[str], str]] = {
            **dict.fromkeys(REGISTERS_RTL, lambda made: f"{_NOTICE}{_lint('off')}\n{made}\n{_lint('on')}"),
            # All members are whole words; of what is packed compilers read and write bytes.
            HEADER: lambda made: f"{_NOTICE}\n{made.replace(_PACKED, '')}",
            TEXT: lambda made: f"<!-- {_MADE} -->\n\n{made}",
        }
        return {path: note((folder / path.name).read_text()) for path, note in notes.items()}


def write_registers() -> list[Path]:
    """Write these files; return them. Raises InputError where there is no checkout that keeps them."""
    if not (ROOT / "pyproject.toml").exists():
        raise InputError(
            f"registers: {ROOT} is an installed package, and these files are kept in a checkout: run it in "
            "one, or make a register model in a folder of yours by --pyuvm"
        )
    return [write_whole(path, text) for path, text in register_files().items()]


def write_register_model(folder: Path) -> Path:
    """Write the register model for pyuvm into a folder; return its file."""
    root = _root()
    make_folder(folder)
    _model(root, folder)
    return folder / MODEL
