"""What dvsim starts for each build: the simulators of one configuration, for the agents that need them.

Exit codes: 0 built, 1 failed; the reason is left in a file too, for the report.
"""

import argparse
import sys
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.configuration import Configuration
from triaxis.sim.mesh_configuration import parse_mesh_configuration
from triaxis.verif.testbench.settings import BURST, PIN
from triaxis.verif.testbench.simulation import build_for, run_settings


def error_file(folder: Path, config: str) -> Path:
    """Return where the reason of a failed build is left."""
    return folder / "builds" / f"{config}.error"


def _configuration_name(options: argparse.Namespace) -> str:
    """Return the name of the configuration that the options give; raise InputError where there is none."""
    if options.mesh_engine is not None:
        configuration = parse_mesh_configuration(f"mesh_{options.mesh_engine}")
        return f"mesh_{configuration.name}"
    return Configuration(
        options.width,
        options.margin_bits,
        options.tag_bits,
        not options.no_edge_box,
        not options.ungated,
    ).name


def main() -> int:
    """Build what is not built already."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", required=True, help="the name of what the other options give")
    parser.add_argument("--folder", type=Path, required=True, help="where the reason of a failure goes")
    parser.add_argument("--agent", choices=(PIN, BURST), action="append", required=True)
    parser.add_argument("--mesh-engine", help="configuration of the mesh engine, without mesh_")
    parser.add_argument("--width", type=int, default=16)
    parser.add_argument("--margin-bits", type=int, default=0)
    parser.add_argument("--tag-bits", type=int, default=16)
    parser.add_argument("--no-edge-box", action="store_true")
    parser.add_argument("--ungated", action="store_true")
    options = parser.parse_args()
    failed = error_file(options.folder, options.config)
    failed.unlink(missing_ok=True)
    try:
        name = _configuration_name(options)
        if name != options.config:
            raise InputError(f"build mode {options.config}: its parameters are those of {name}")
        for agent in options.agent:
            build_for(run_settings("build", name, 1, 1, agent=agent))
    except InputError as error:
        write_whole(failed, f"{error}\n")
        print(f"FAILED: {error}")
        return 1
    print("BUILD DONE")
    return 0


if __name__ == "__main__":
    sys.exit(main())
