"""``triaxis sim``: one test by name and seed, on the simulated core, mesh engine or board."""

import argparse
import os
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_seed, positive
from triaxis.sim.board_parameters import parse_board_configuration
from triaxis.sim.configuration import parse_configuration
from triaxis.sim.mesh_configuration import parse_mesh_configuration
from triaxis.sim.paths import DUT
from triaxis.sim.simulators import ICARUS, UNTRIED
from triaxis.verif.core.failing_pairs import read_failing_pairs
from triaxis.verif.core.stimulus.seed_vectors import seed_vectors
from triaxis.verif.counterexample.explaining import run_and_explain
from triaxis.verif.faults.faulty_rtl import faulty_rtl
from triaxis.verif.faults.known_faults import Kind, fault_of
from triaxis.verif.regress.definition import in_checkout
from triaxis.verif.testbench.golden_sample import MOST_SELDOM
from triaxis.verif.testbench.settings import BURST, PIN, REPLAY, VERBOSITIES, VERILATOR, Block
from triaxis.verif.testbench.simulation import RunResult, run_settings
from triaxis.verif.testbench.table import check_test_fits, check_test_name, names_of, table
from triaxis.verif.testbench.waves import WAVES, check_waves

_USUAL = "w16_m0"
# What ends a run before it has said anything of the design.
_REFUSED = re.compile(r"\bInputError: (.*)")
_SIMULATORS = (VERILATOR, ICARUS, *UNTRIED)

# A configuration's whole name, and what a run that passed has counted.
_NAMES = {
    Block.CORE: lambda text: parse_configuration(text).name,
    Block.MESH: lambda text: f"mesh_{parse_mesh_configuration(text).name}",
    Block.BOARD: lambda text: parse_board_configuration(text).name,
}
_TOLD = {
    Block.CORE: "{checked} pairs checked, {judged_by_golden_model} judged by the golden model, "
    "{clear_claims_rechecked} clear answers proved",
    Block.MESH: "{runs} runs, {checked} pairs decided, {skipped_with_proof} of them skipped with a proof, "
    "{judged_by_golden_model} judged by the golden model",
    Block.BOARD: "{checked} replies and {clocks} clocks checked, {runs} runs, {gos} times go",
}


def _chosen_simulator() -> str:
    """Return the simulator that the environment variable SIMULATOR names; raise InputError for no such."""
    name = os.environ.get("SIMULATOR", "") or VERILATOR
    if name not in _SIMULATORS:
        raise InputError(f"SIMULATOR={name}: unknown; one of: {', '.join(_SIMULATORS)}")
    return name


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.description = (
        "Run one test of the pyuvm environment. Tests of the core: "
        + ". Tests of the mesh engine: ".join(
            ", ".join(names_of(block)) for block in (Block.CORE, Block.MESH)
        )
        + ". Tests of the board: "
        + ", ".join(names_of(Block.BOARD))
        + "."
    )
    parser.add_argument("test", metavar="TEST", help="name of the test")
    add_seed(parser)
    parser.add_argument(
        "--config", metavar="NAME",
        help="w<width>_m<margin bits>[_t<tag bits>][_no_edge_box][_ungated][_certified]; for the mesh engine "
        "mesh_w<width>_m<margin bits>_d<depth>_g<group>_l<lanes>[_c<cycle bits>][_ungated][_certified]; for "
        "the board board_w<width>_m<margin bits>_d<depth>_g<group>_l<lanes>[_plain][_real] (the first in the "
        f"table of tests; of the core mostly {_USUAL})",
    )  # fmt: skip
    parser.add_argument(
        "--pairs", type=positive, default=2000,
        help="how many pairs to send; for the mesh engine: to account for at least; for the board: "
        "replies (2000)",
    )  # fmt: skip
    parser.add_argument(
        "--agent", choices=(PIN, BURST),
        help="who drives the streams, or the board's line: pin by pin, or a bus-functional model of the "
        "Verilated library (pin; for the board burst)",
    )  # fmt: skip
    parser.add_argument(
        "--simulator", choices=_SIMULATORS, default=_chosen_simulator(),
        help=f"who simulates the pins; also by the variable SIMULATOR; untried: {', '.join(UNTRIED)} "
        f"({VERILATOR})",
    )  # fmt: skip
    parser.add_argument(
        "--judged", type=int, default=1, metavar="N",
        help="the golden model judges one pair in N, and a few of new kinds (1: all); the bulk checker "
        "checks every pair",
    )  # fmt: skip
    parser.add_argument(
        "--soak",
        action="store_true",
        help="for long runs: no assertions, coverage samples one batch in eight",
    )
    parser.add_argument(
        "--fault",
        metavar="NAME",
        help="break the core, the mesh engine or the board by a fault of their RTL of `triaxis prove faults "
        "--list`, as F1-box",
    )
    parser.add_argument("--replay", type=Path, metavar="FILE.npz", help=f"failing pairs, for {REPLAY}")
    parser.add_argument(
        "--verbosity", choices=VERBOSITIES, default="medium",
        help="of the log, in UVM's terms: low, what runs; high, each item; debug, also cocotb's own (medium)",
    )  # fmt: skip
    parser.add_argument(
        "--waves", nargs="?", choices=WAVES, const=WAVES[0], default="",
        help="keep all values of a run on the pins, with a view for GTKWave and one for Surfer; fst is "
        "written by vcd2fst, which comes with GTKWave (vcd)",
    )  # fmt: skip
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the test and print how it went."""
    check_test_name(options.test)
    if not 1 <= options.judged <= MOST_SELDOM:
        raise InputError(f"judged {options.judged}: must be 1..{MOST_SELDOM}")
    options.config = options.config or next(iter(_configs(options.test)), _USUAL)
    check_test_fits(options.test, options.config)
    block = table()[options.test].block
    # Its line takes 57 clocks a byte: too many for a step of Python each, but for waves and four states.
    agent = options.agent or (BURST if block is Block.BOARD else PIN)
    if block is not Block.CORE and (options.replay is not None or options.soak):
        raise InputError("--replay and --soak go with tests of the core")
    if block is Block.BOARD and options.judged != 1:
        raise InputError("--judged goes with tests of the core or the mesh engine: the board judges all")
    if options.soak and agent != BURST:
        raise InputError("--soak goes with --agent burst, and only with it")
    if options.simulator != VERILATOR and agent != PIN:
        raise InputError(f"--agent {agent} needs Verilator: {options.simulator} drives pins alone")
    if options.waves:
        check_waves(options.waves, agent, options.simulator)
    dut = DUT if options.fault is None else _broken(options.fault, options.test)
    config = _NAMES[block](options.config)
    settings = run_settings(
        options.test,
        config,
        options.seed,
        options.pairs,
        _replay(options) if block is Block.CORE else "",
        agent=agent,
        judged_one_in=options.judged,
        soak=options.soak,
        simulator=options.simulator,
        waves=options.waves,
        verbosity=options.verbosity,
    )
    if options.fault is not None:
        # Not in place of a healthy run, whose coverage counts.
        settings = replace(settings, folder=f"{settings.folder}_{options.fault}")
    result = run_and_explain(settings, dut)
    if result.waves:
        print(f"waves: {result.waves}: gtkwave {result.waves.with_suffix('.gtkw')}")
    if not result.passed or not result.counts:
        return _failed(options, result)
    told = _TOLD[block].format(**result.counts)
    folder = in_checkout(Path(settings.folder))
    if options.fault is not None:
        print(f"passed, without noticing {options.fault}: {options.test}, {config}, seed {options.seed}")
        print(f"{told}; log: {folder}")
        return DONE
    print(f"passed: {options.test}, {config}, seed {options.seed}: {told}, {result.seconds:.1f} s")
    print(f"log and coverage: {folder}; `triaxis coverage page` shows its bins")
    return DONE


def _configs(test: str) -> Iterator[str]:
    """Yield the configurations in which the table of tests runs a test."""
    for runs in table()[test].runs:
        yield from runs.configs


def _replay(options: argparse.Namespace) -> str:
    """Return the file of pairs to be sent again, "" for none; raise InputError where it does not fit."""
    configuration = parse_configuration(options.config)
    if (options.replay is None) == (options.test == REPLAY):
        raise InputError(f"--replay FILE.npz goes with {REPLAY}, and only with it")
    if options.test == "SeedVectorsTest":
        seed_vectors(configuration.width)
    if options.replay is None:
        return ""
    read_failing_pairs(options.replay, configuration)
    return str(options.replay.resolve())


def _failed(options: argparse.Namespace, result: RunResult) -> int:
    refused = [_REFUSED.search(line) for line in result.errors]
    # Beside anything else it is one of the reasons for a failure.
    if refused and refused[0] and all(refused):
        raise InputError(f"test {options.test}: {refused[0][1]}")
    # The last lines are the commands that repeat the run.
    fault = "" if options.fault is None else f" --fault {options.fault}"
    print(result.explain().replace(" --waves", f"{fault} --waves") + fault, file=sys.stderr)
    return NO


def _broken(name: str, test: str) -> Path:
    """Return the RTL with a fault; raise InputError where the test does not drive what the fault is in."""
    fault, block = fault_of(name), table()[test].block
    if fault.kind is not {Block.CORE: Kind.CORE, Block.MESH: Kind.ENGINE, Block.BOARD: Kind.BOARD}.get(block):
        raise InputError(
            f"fault {name}: is in {fault.kind.value}, and {test} drives the {block.value}: "
            f"`triaxis prove faults --fault {name}` tries it"
        )
    return faulty_rtl(fault)
