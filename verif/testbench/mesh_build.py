"""Simulator executables for runs of the mesh engine, kept in build/simulation/."""

from pathlib import Path

from triaxis.sim.build import cocotb_build
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.paths import DUT, VERIF, mesh_sources, rtl_sources

TOP = "triaxis_mesh"
BARE_TOP = "triaxis_bare_tb"

SVA = VERIF / "mesh" / "sva"


def mesh_simulation(configuration: MeshConfiguration, dut: Path = DUT) -> Path:
    """Return the folder of the simulator executable with the engine's pins, built where needed.

    ``dut`` may be another folder of RTL with the same files: mutants and faults.
    """
    sources = [
        SVA / "public.vlt",
        *rtl_sources(dut),
        *mesh_sources(dut),
        *sorted(SVA.glob("*.sv")),
    ]
    return cocotb_build(f"mesh_{configuration.name}", TOP, sources, configuration.parameters, dut)


def bare_simulation() -> Path:
    """Return the folder of the simulator executable with nothing in it: the engine stands beside it."""
    folder = VERIF / "mesh"
    return cocotb_build("bare", BARE_TOP, [folder / "bare_tb.vlt", folder / f"{BARE_TOP}.sv"], {})
