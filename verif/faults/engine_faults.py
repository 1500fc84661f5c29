"""Faults of the mesh engine: the first of its tests that sees one."""

from pathlib import Path

from triaxis.verif.faults.attempt import Attempt
from triaxis.verif.faults.catalogue import Fault
from triaxis.verif.faults.result import Catch
from triaxis.verif.faults.runs import engine_sign_of, until_one_fails
from triaxis.verif.testbench.settings import PIN

# In the order in which they are tried. None knows a fault.
ENGINE_TESTS = (
    "MeshGapsTest",
    "MeshRandomTest",
    "MeshLimitsTest",
    "MeshStallsTest",
    "MeshAbortTest",
    "MeshResetsTest",
)
# Pairs of triangles that a test accounts for at least.
_PAIRS = 400


def try_engine(fault: Fault, dut: Path, seed: int) -> Attempt:
    """Run the engine's tests on the RTL in ``dut``, one after the other, until one fails."""
    tried = until_one_fails(ENGINE_TESTS, fault.config, seed, fault.name, dut, PIN, _PAIRS)
    result = tried.failed
    if result is None:
        return Attempt(None, f"{', '.join(ENGINE_TESTS)} pass", clean=True)
    sign = engine_sign_of(result)
    if sign is None:
        said = next(iter(result.errors), "no error line")
        test = result.settings.test
        return Attempt(None, f"{test} ended without a verdict on the engine: {said} (log: {result.log})")
    replay = f".venv/bin/triaxis prove faults --fault {fault.name} --seed {seed}"
    return Attempt(
        Catch(
            result.settings.test,
            sign.message,
            clocks=sign.clocks,
            missed_by=tried.missed,
            pairs_before=tried.pairs_before,
            replay=replay,
        )
    )
