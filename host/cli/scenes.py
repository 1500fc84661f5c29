"""``triaxis scenes``: example meshes to try the other commands on."""

import argparse
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.host.scenes import write_scenes


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "scenes",
        help="write example meshes: a tool and a vise with a workpiece, in several positions",
        description="Write the scenes of the sign-off as pairs of binary STL files, in millimetres.",
    )
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="where to write them; created")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the scenes and list them."""
    try:
        written = write_scenes(options.folder)
    except OSError as error:
        raise InputError(f"{options.folder}: cannot write: {error.strerror}") from error
    for scene, a, b in written:
        print(f"{a} {b}: {scene.name}")
    return 0
