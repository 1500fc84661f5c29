"""``triaxis prove``: what is broken on purpose, by faults, mutants and upsets, and must be found out."""

import argparse
from collections.abc import Mapping

from rich.console import Console
from rich.table import Table

from triaxis.golden.errors import InputError
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_seed, positive
from triaxis.host.cli.terminal import print_list, progress_bar, table
from triaxis.sim.paths import DUT
from triaxis.verif.faults.catching import catch_all
from triaxis.verif.faults.known_faults import FAULTS, Fault, faults_of
from triaxis.verif.faults.result import FaultsResult, Outcome, write_json
from triaxis.verif.mutation import result as mutation_result
from triaxis.verif.mutation.catalogue import catalogue
from triaxis.verif.mutation.false_clears import PAIRS, compare, mutants_of_data_path
from triaxis.verif.mutation.false_clears import write_result as write_certificates
from triaxis.verif.mutation.killers import states
from triaxis.verif.mutation.power import MODELS, ONE_IN, Power, measure_power
from triaxis.verif.mutation.power import RESULT as POWER
from triaxis.verif.mutation.power import write_result as write_power
from triaxis.verif.mutation.record import SEED, read_record, recorded, write_record
from triaxis.verif.mutation.result import Fate, MutationResult, Tally, grouped, tally
from triaxis.verif.mutation.run import CHANGED, EVIDENCE, mutate
from triaxis.verif.results.database import keep
from triaxis.verif.upsets.campaign import CONFIG, UPSETS, by_module, is_whole, upset_board
from triaxis.verif.upsets.campaign import tally as tally_upsets
from triaxis.verif.upsets.campaign import write_result as write_upsets
from triaxis.verif.upsets.verdict import Kind

_JOBS = 2
# Problems of mutants that are printed.
_SHOWN = 40


def add_faults(parser: argparse.ArgumentParser) -> None:
    """Put the faults of the replaced design, F1 to F10, into copies of the core, its wrapper and its
    environment, and those of the board into copies of it, and let the environment's own tests catch them.
    Writes build/faults/faults.json, unless only some are asked for.
    """
    parser.add_argument(
        "--fault", action="append", metavar="NAME",
        help="only this one; F1 stands for all its variants; may be given several times",
    )  # fmt: skip
    parser.add_argument(
        "--all", action="store_true", help="the further faults of the core and those of the mesh engine too"
    )
    parser.add_argument("--list", action="store_true", help="list the catalogue, and run nothing")
    add_seed(parser)
    parser.set_defaults(run=_faults)


def _faults(options: argparse.Namespace) -> int:
    if options.all and options.fault:
        raise InputError("--all and --fault: give one of them")
    console = Console(width=110)
    chosen = _chosen(options)
    if options.list:
        console.print(_list_of(chosen if options.fault else FAULTS))
        return DONE
    with progress_bar("faults", len(chosen)) as progress:
        result = catch_all(progress, options.seed, chosen)
    for outcome in result.outcomes:
        _print_example(console, outcome)
    console.print(_catches(result))
    print_list("PROBLEM", result.problems)
    verdict = "PASSED" if result.passed else "FAILED"
    print(f"{verdict}: {result.summary}, {result.seconds:.0f} s")
    if result.complete:
        print(f"written to {write_json(result)}")
    return DONE if result.passed else NO


def _chosen(options: argparse.Namespace) -> tuple[Fault, ...]:
    if options.fault:
        wanted = [fault for name in options.fault for fault in faults_of(name)]
        return tuple(dict.fromkeys(wanted))
    return tuple(fault for fault in FAULTS if fault.signed_off or options.all)


def _list_of(faults: tuple[Fault, ...]) -> Table:
    listed = table(None, ("fault", "of", "build", "what it is"), text=4)
    for fault in faults:
        listed.add_row(fault.name, fault.kind.name.lower(), fault.config, fault.story)
    return listed


def _print_example(console: Console, outcome: Outcome) -> None:
    """Print the counterexample as found and as small as it gets."""
    example = outcome.example
    if example is None:
        return
    lines = [
        f"{outcome.fault.name}: {example.meaning}",
        f"  before: {example.before}",
        f"  after:  {example.after}",
        f"  said {example.core_said}, right is {example.right}",
        *([f"  drawn: {example.picture}"] if example.picture else []),
    ]
    console.print("\n".join(lines), markup=False, highlight=False, soft_wrap=True)


def _catches(result: FaultsResult) -> Table:
    catches = Table(title="faults, and what caught them")
    for heading in ("fault", "what it is", "caught by", "pairs", "before it", "how"):
        catches.add_column(heading, justify="right" if heading in ("pairs", "before it") else "left")
    for outcome in result.outcomes:
        catch = outcome.catch
        cells = ("NOT CAUGHT", "", "", outcome.reason or "")
        if catch:
            pairs = "" if catch.pairs is None else str(catch.pairs)
            cells = (catch.test, pairs, str(catch.pairs_before or ""), _how(outcome))
        catches.add_row(outcome.fault.name, outcome.fault.title, *cells)
    return catches


def _how(outcome: Outcome) -> str:
    """Return in what way it showed."""
    if outcome.example:
        return outcome.example.meaning
    assert outcome.catch
    after = "" if outcome.catch.clocks is None else f" (clock {outcome.catch.clocks})"
    return outcome.catch.message + after


def add_certificates(parser: argparse.ArgumentParser) -> None:
    """Ask the core and the certified core the same pairs, with each mutant of the data path in turn.
    Where the core says clear of a pair that is near, the certified core must say near, with a fault.
    Writes build/certificates/certificates.json.
    """
    parser.add_argument(
        "--pairs", type=positive, default=PAIRS, metavar="N", help=f"pairs for each mutant ({PAIRS})"
    )
    add_seed(parser)
    parser.set_defaults(run=_certificates)


def _certificates(options: argparse.Namespace) -> int:
    found = mutants_of_data_path()
    with progress_bar("mutants", len(found)) as progress:
        result = compare(progress, options.seed, options.pairs)
    rows = table("mutants of the data path", ("of", "tried", "wrong clears", "come through"))
    for shared, of in ((False, "the core alone"), (True, "modules that the certifier has too")):
        tried = sum(one.shared is shared for one in result.compared)
        rows.add_row(of, *map(str, (tried, len(result.dangerous(shared)), len(result.missed(shared)))))
    Console(width=110).print(rows)
    print_list("THROUGH", list(map(str, result.missed(False))))
    print_list("PROBLEM", result.problems)
    print(f"written to {write_certificates(result)}")
    print(f"{'PASSED' if result.passed else 'FAILED'}: {result.summary}, {result.seconds:.0f} s")
    return DONE if result.passed else NO


def add_upsets(parser: argparse.ArgumentParser) -> None:
    """Invert bits of the board's registers and memories, one at a random clock of each of many talks with
    a host; have some stick, and some registers miss an edge. Count what comes of it: nothing, a stop
    without need, an answer that a host does not believe, or the dangerous: go, or a host that is told
    clear, where something is near, or where nobody was heard. Writes build/upsets/upsets.json, where the
    board is the small one and its upsets are no fewer.
    """
    parser.add_argument(
        "--upsets", type=positive, default=UPSETS, metavar="N",
        help=f"so many ({UPSETS}: each flip-flop of the small board is inverted once at least)",
    )  # fmt: skip
    parser.add_argument("--config", default=CONFIG, help=f"the board ({CONFIG})")
    add_seed(parser)
    parser.set_defaults(run=_upsets)


def _upsets(options: argparse.Namespace) -> int:
    with progress_bar("upsets", options.upsets) as progress:
        result = upset_board(progress, options.seed, options.upsets, options.config)
    flips = table("bits inverted", ("module", "upsets", "dangerous", "detected", "false stops"))
    inverted = result.of(Kind.FLIP)
    for module, row in (*by_module(inverted).items(), ("all", tally_upsets(inverted))):
        flips.add_row(module, *map(str, (row.upsets, row.dangerous, row.detected, row.false_stops)))
    Console(width=110).print(flips)
    dangerous = [f"{one.upset}: {one.how}" for one in result.dangerous]
    print_list("DANGEROUS", dangerous, _SHOWN, "see the JSON file")
    left = table("what each measure brings", ("with the measures up to", "dangerous, of these"), text=1)
    for measure, count in result.left.items():
        left.add_row(measure, str(count))
    Console(width=110).print(left)
    print_list("PROBLEM", result.problems)
    if not is_whole(options.config, options.upsets):
        print(f"another board than {CONFIG}, or fewer upsets than {UPSETS}: no result written")
    elif not result.problems:
        print(f"written to {write_upsets(result)}, the failure modes and a plot beside it")
    print(f"{'PASSED' if result.passed else 'FAILED'}: {result.summary}, {result.seconds:.0f} s")
    return DONE if result.passed else NO


def add_mutate(parser: argparse.ArgumentParser) -> None:
    """Generate mutants of every file of dut/, let the environment's own tests look for them, short ones
    first and volume for those that survive, and check the evidence that those listed in
    verif/mutation/equivalents.toml change nothing. Writes build/mutation/mutation.json, which sign-offs
    of the same RTL and the same tests take.
    """
    add_seed(parser)
    parser.add_argument(
        "--file", metavar="GLOB", help="only mutants of these files, as in 'core/triaxis_fifo*' or 'mesh/*'"
    )
    parser.add_argument("--mutant", metavar="ID", help="only this mutant, or those that a pattern matches")
    parser.add_argument("--jobs", type=positive, default=_JOBS, help=f"processes ({_JOBS})")
    parser.add_argument("--fresh", action="store_true", help="forget what earlier runs found out")
    either = parser.add_mutually_exclusive_group()
    either.add_argument(
        "--record", action="store_true",
        help="write down what became of them, verif/mutation/record.json: sign-offs of this state take it",
    )  # fmt: skip
    either.add_argument(
        "--sample", type=int, metavar="SEED", help="take what is recorded, but for those that a seed draws"
    )
    parser.set_defaults(run=_mutate)


def _mutate(options: argparse.Namespace) -> int:
    if (options.record or options.sample is not None) and options.seed != SEED:
        raise InputError(f"--seed {options.seed}: what is recorded is of runs with --seed {SEED}")
    if options.fresh and options.sample is not None:
        raise InputError("--fresh and --sample: give one of them")
    restricted = options.file is not None or options.mutant is not None
    before = states(DUT)
    everything = found = catalogue()
    if restricted:
        found = found.restricted(options.file, options.mutant)
    with progress_bar("mutants", len(found.mutants)) as progress:
        result = mutate(
            options.seed, jobs=options.jobs, fresh=options.fresh, progress=progress, chosen=found,
            sample=options.sample, all_evidence=options.record,
        )  # fmt: skip
    _print_mutants(result)
    if not restricted:
        command = f"triaxis prove mutate --seed {options.seed}"
        if options.sample is not None:
            command += f" --sample {options.sample}"
        print(f"written to {mutation_result.write_result(result, command)}")
    elif len(result.fates) == 1:
        _print_one(result.fates[0])
    if options.record and CHANGED not in result.problems and states(DUT) == before:
        equivalent = {fate.id for fate in result.fates if fate.fate == mutation_result.EQUIVALENT}
        kills = mutation_result.kills(result.fates)
        if result.evidence_holds:
            before[EVIDENCE] = result.evidence_hash
        now = recorded(read_record(), everything.mutants, kills, equivalent, before)
        blocks = ", ".join(now.states) or "no block"
        print(f"written to {write_record(now)}: {blocks} as a whole")
    elif options.record:
        print("nothing is recorded: something changed during the run")
    if not restricted:
        keep(mutation_result.EVIDENCE)
    print(f"{'PASSED' if result.passed else 'FAILED'}: {result.summary}, {result.seconds:.0f} s")
    return DONE if result.passed else NO


def _print_mutants(result: MutationResult) -> None:
    console = Console(width=110)
    for title in ("file", "operator"):
        console.print(_fates(title, grouped(result.fates, title), tally(result.fates)))
    print_list("PROBLEM", result.problems, _SHOWN, "all in the JSON file of a full run")


def _print_one(fate: Fate) -> None:
    print(f"{fate.id} ({fate.kind}): {fate.place}")
    print(f"  {fate.original}\n  {fate.changed}")
    if fate.by is not None:
        told = f" after {fate.pairs} pairs" if fate.pairs is not None else ""
        what = f"{fate.test} on {fate.target}"
        print(f"  {fate.fate} by {fate.by}: {what}: {fate.symptom}{told}")
    else:
        print(f"  {fate.fate}")


def _fates(title: str, rows: Mapping[str, Tally], total: Tally) -> Table:
    by = ("run", "assertion", "elaboration", "proof")
    headings = (title, "mutants", *by, "equivalent", "surviving", "score")
    fates = table(f"mutants by {title}", headings)
    for name, row in (*rows.items(), ("all", total)):
        # Rounded down: 100 means all.
        score = "" if row.score is None else f"{int(row.score * 100) / 100:.2f} %"
        fates.add_row(
            name, str(row.mutants), str(row.by_run), str(row.by_assertion), str(row.by_elaboration),
            str(row.by_proof), str(row.equivalent), str(row.surviving + row.absent), score,
            end_section=name != "all",
        )  # fmt: skip
    return fates


def add_power(parser: argparse.ArgumentParser) -> None:
    """Let a sample of the mutants that are selected at run time meet every short test of a model, where
    `triaxis prove mutate` ends each at the first that notices it. Says of each test what it notices, what
    no other does, and which are the fewest that notice as much as all. Writes build/mutation/power.json,
    which `triaxis results` shows.
    """
    parser.add_argument(
        "--of", action="append", choices=tuple(MODELS), metavar="BLOCK",
        help=f"only the model of this block ({', '.join(MODELS)}); may be given several times",
    )  # fmt: skip
    parser.add_argument(
        "--file", metavar="GLOB", help="only mutants of these files; no result is written then"
    )
    parser.add_argument(
        "--one-in", type=positive, default=ONE_IN, metavar="N",
        help=f"draw one mutant in so many ({ONE_IN}); 1: all",
    )  # fmt: skip
    parser.add_argument("--jobs", type=positive, default=_JOBS, help=f"processes ({_JOBS})")
    add_seed(parser)
    parser.set_defaults(run=_power)


def _power(options: argparse.Namespace) -> int:
    wanted = [name for name in MODELS if name in (options.of or MODELS)]
    models = [MODELS[name] for name in wanted]
    with progress_bar("tests", sum(len(model.tests(options.seed)) for model in models)) as progress:
        result = measure_power(
            models, options.seed, options.one_in, options.file, options.jobs, progress=progress
        )
    console = Console(width=110)
    for power in result.powers:
        console.print(_power_of(power))
    print_list("PROBLEM", result.problems, _SHOWN, "see the JSON file")
    if options.file is None:
        command = f"triaxis prove power --seed {options.seed} --one-in {options.one_in}"
        command += "".join(f" --of {name}" for name in options.of or ())
        print(f"written to {write_power(result, command)}")
        keep(POWER)
    print(f"{'PASSED' if result.passed else 'FAILED'}: {result.summary}, {result.seconds:.0f} s")
    return DONE if result.passed else NO


def _power_of(power: Power) -> Table:
    title = f"{power.model}: {len(power.noticed)} of {len(power.tried)} mutants noticed"
    rows = table(title, ("test", "notices", "no other does", "among the fewest"), text=1)
    for test, found in power.found_by.items():
        fewest = "yes" if test in power.fewest else ""
        rows.add_row(test, str(len(found)), str(len(power.alone(test))), fewest)
    return rows
