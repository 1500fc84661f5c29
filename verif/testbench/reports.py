"""What a run says, as UVM does: by pyuvm's report server, at a verbosity, and counted by severity."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pyuvm import UVM_NONE, parse_uvm_verbosity, uvm_report_policy, uvm_report_server

from triaxis.verif.testbench.settings import (
    RunSettings,
    library_from_environment,
    program_from_environment,
)
from triaxis.verif.testbench.trials import in_trials

INFO, ERROR = "INFO", "ERROR"
_LOGGER = logging.getLogger("uvm")


def report(severity: str, text: str, report_id: str, verbosity: int = UVM_NONE) -> None:
    """Report something; trials, of which there are thousands, only say what is wrong."""
    if server := uvm_report_server.get_or_none():
        server.emit_uvm(severity, text, report_id, verbosity, _LOGGER, stacklevel=3)
    elif severity == ERROR:
        _LOGGER.error(text)


@contextmanager
def reporting(settings: RunSettings) -> Iterator[None]:
    """Report at the verbosity of a run, and count what is reported."""
    if in_trials():
        yield
        return
    _LOGGER.setLevel(logging.INFO)
    # A run goes on to its end whatever it has found.
    server = uvm_report_server.create(
        verbosity=parse_uvm_verbosity(settings.verbosity),
        policy=uvm_report_policy(max_quit_count=0),
        print_char_len=10_000,
    )
    model = library_from_environment()
    build = Path(model).resolve().parent.name if model else program_from_environment()
    # At any verbosity: a log that does not say what ran is of no use.
    report(
        INFO,
        f"{settings.test}, seed {settings.seed}, {settings.config}, agent {settings.agent}, build {build}",
        "RUN",
    )
    try:
        yield
    finally:
        server.log_summary(_LOGGER)
