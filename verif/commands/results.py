"""``triaxis results``: what became of all runs over time, as pages, tables, and in the browser."""

import argparse
from pathlib import Path

from triaxis.host.cli import DONE
from triaxis.host.cli.arguments import named_folder, natural
from triaxis.verif.regress.definition import in_checkout
from triaxis.verif.results.database import DATABASE, add_evidence, export_parquet
from triaxis.verif.results.pages import FOLDER, write_pages
from triaxis.verif.results.serving import server


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.description = (
        "Regressions, sign-offs and runs over the mutants add what they found to a database, "
        f"{in_checkout(DATABASE)} (SQLite, as verif/results/schema.sql says). This makes pages of it, in "
        f"{in_checkout(FOLDER)}: trends, flaky seeds, slow tests; each result down to its runs "
        "and their logs; coverage and mutants of each line."
    )
    parser.add_argument(
        "--add", nargs="+", type=Path, default=[], metavar="FILE",
        help="add results.json, signoff.json, mutation.json or power.json of runs elsewhere first",
    )  # fmt: skip
    either = parser.add_mutually_exclusive_group()
    either.add_argument(
        "--compare",
        nargs=2,
        type=natural,
        metavar="ID",
        help="make a page of what differs between two results",
    )
    parser.add_argument(
        "--parquet", type=named_folder, metavar="FOLDER", help="write each table there as Parquet"
    )
    either.add_argument(
        "--serve", type=natural, metavar="PORT",
        help="show the pages to this computer's browsers, as things are, until interrupted; 0: any free port",
    )  # fmt: skip
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    for file in options.add:
        print(f"{file}: {'added' if add_evidence(file) else 'is there already'}")
    if options.parquet:
        written = export_parquet(options.parquet)
        print(f"written to {options.parquet}: {', '.join(path.name for path in written)}")
    if options.serve is not None:
        with server(options.serve) as serving:
            print(f"http://127.0.0.1:{serving.server_address[1]}/", flush=True)
            serving.serve_forever()
        return DONE
    also = [f"compare-{options.compare[0]}-{options.compare[1]}.html"] if options.compare else []
    index = write_pages(also=also)
    print(f"written to {index}{''.join(f' and {index.with_name(name)}' for name in also)}")
    return DONE
