"""``triaxis sim``: one test by name and seed, on the simulated core or mesh engine."""

import argparse
import os
import sys
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
from triaxis.verif.faults.broken_rtl import faulty_rtl
from triaxis.verif.faults.known_faults import Kind, fault_of
from triaxis.verif.testbench.golden_sample import MOST_SELDOM
from triaxis.verif.testbench.settings import BURST, PIN, VERBOSITIES, VERILATOR, Block
from triaxis.verif.testbench.simulation import RunResult, run_settings
from triaxis.verif.testbench.table import (
    REPLAY,
    check_test_fits,
    check_test_name,
    names_of,
    table,
)
from triaxis.verif.testbench.waves import WAVES, check_waves

_SIMULATORS = (VERILATOR, ICARUS, *UNTRIED)


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
        "--config", default="w16_m0", metavar="NAME",
        help="w<width>_m<margin bits>[_t<tag bits>][_no_edge_box][_ungated] (w16_m0); for the mesh engine "
        "mesh_w<width>_m<margin bits>_d<depth>_g<group>_l<lanes>[_c<cycle bits>][_ungated]; for the board "
        "board_w<width>_m<margin bits>_d<depth>_g<group>_l<lanes>",
    )  # fmt: skip
    parser.add_argument(
        "--pairs", type=positive, default=2000,
        help="how many pairs to send; for the mesh engine: to account for at least; for the board: "
        "replies (2000)",
    )  # fmt: skip
    parser.add_argument(
        "--agent", choices=(PIN, BURST), default=PIN,
        help="who drives the streams: pin by pin, or a bus-functional model of the Verilated library (pin)",
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
        help="break the core, or the mesh engine, by a fault of `triaxis prove faults --list`",
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
    if options.soak and options.agent != BURST:
        raise InputError("--soak goes with --agent burst, and only with it")
    if options.simulator != VERILATOR and options.agent != PIN:
        raise InputError(f"--agent {options.agent} needs Verilator: {options.simulator} drives pins alone")
    if options.waves:
        check_waves(options.waves, options.agent, options.simulator)
    check_test_fits(options.test, options.config)
    dut = DUT if options.fault is None else _broken(options.fault, options.test)
    block = table()[options.test].block
    if block is not Block.CORE:
        return _run_mesh(options, dut) if block is Block.MESH else _run_board(options, dut)
    configuration = parse_configuration(options.config)
    if (options.replay is None) == (options.test == REPLAY):
        raise InputError(f"--replay FILE.npz goes with {REPLAY}, and only with it")
    replay = ""
    if options.replay is not None:
        read_failing_pairs(options.replay, configuration)
        replay = str(options.replay.resolve())
    if options.test == "SeedVectorsTest":
        seed_vectors(configuration.width)
    settings = run_settings(
        options.test,
        configuration,
        options.seed,
        options.pairs,
        replay,
        agent=options.agent,
        judged_one_in=options.judged,
        soak=options.soak,
        simulator=options.simulator,
        waves=options.waves,
        verbosity=options.verbosity,
    )
    result = run_and_explain(settings, dut)
    _print_waves(result)
    if result.passed and result.counts:
        print(
            f"passed: {options.test}, {configuration.name}, seed {options.seed}: "
            f"{result.counts['checked']} pairs checked, {result.counts['judged_by_golden_model']} judged by "
            f"the golden model, {result.counts['clear_claims_rechecked']} clear answers proved, "
            f"{result.seconds:.1f} s"
        )
        return DONE
    return _failed(options, result)


def _print_waves(result: RunResult) -> None:
    if result.waves:
        print(f"waves: {result.waves}: gtkwave {result.waves.with_suffix('.gtkw')}")


def _failed(options: argparse.Namespace, result: RunResult) -> int:
    # The last lines are the commands that repeat the run.
    fault = "" if options.fault is None else f" --fault {options.fault}"
    print(result.explain().replace(" --waves\n", f"{fault} --waves\n") + fault, file=sys.stderr)
    return NO


def _broken(name: str, test: str) -> Path:
    """Return the RTL with a fault; raise InputError where the test does not drive what the fault is in."""
    fault, block = fault_of(name), table()[test].block
    if fault.kind is not {Block.CORE: Kind.CORE, Block.MESH: Kind.ENGINE}.get(block):
        raise InputError(
            f"fault {name}: is in {fault.kind.value}, and {test} drives the {block.value}: "
            f"`triaxis prove faults --fault {name}` tries it"
        )
    return faulty_rtl(fault)


def _run_mesh(options: argparse.Namespace, dut: Path) -> int:
    """Run a test of the mesh engine."""
    if options.replay is not None or options.soak:
        raise InputError("--replay and --soak go with tests of the core")
    name = f"mesh_{parse_mesh_configuration(options.config).name}"
    settings = run_settings(
        options.test,
        name,
        options.seed,
        options.pairs,
        agent=options.agent,
        judged_one_in=options.judged,
        simulator=options.simulator,
        waves=options.waves,
        verbosity=options.verbosity,
    )
    result = run_and_explain(settings, dut)
    _print_waves(result)
    if not result.passed or not result.counts:
        return _failed(options, result)
    counts = result.counts
    print(
        f"passed: {options.test}, {name}, seed {options.seed}: {counts['runs']} runs, "
        f"{counts['checked']} pairs decided, {counts['skipped_with_proof']} of them skipped with a "
        f"proof, {counts['judged_by_golden_model']} judged by the golden model, {result.seconds:.1f} s"
    )
    return DONE


def _run_board(options: argparse.Namespace, dut: Path) -> int:
    """Run a test of the board, which is always driven in bursts."""
    if options.replay is not None or options.soak:
        raise InputError("--replay and --soak go with tests of the core")
    name = parse_board_configuration(options.config).name
    settings = run_settings(options.test, name, options.seed, options.pairs, agent=BURST)
    result = run_and_explain(settings, dut)
    if not result.passed or not result.counts:
        return _failed(options, result)
    counts = result.counts
    print(
        f"passed: {options.test}, {name}, seed {options.seed}: {counts['checked']} replies and "
        f"{counts['clocks']} clocks checked, {counts['runs']} runs, {counts['gos']} times go, "
        f"{result.seconds:.1f} s"
    )
    return DONE
