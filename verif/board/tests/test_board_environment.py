"""The board's environment: its tests pass; lies are seen."""

import pytest

from triaxis.verif.board.uvm_tests import BOARD
from triaxis.verif.testbench.settings import BURST, Block
from triaxis.verif.testbench.simulation import run, run_settings
from triaxis.verif.testbench.table import names_of

pytestmark = pytest.mark.simulator

# The tests whose monitor lies, or that check nothing, and what is said of each.
SAID = {
    "BoardGoTooMuchTest": "is due",
    "BoardGoLateTest": "is due",
    "BoardPinsLostTest": "is due",
    "BoardByteLostTest": "a reply that nothing asked for",
    "BoardOtherReplyTest": "bad CRC",
    "BoardReplyUnaskedTest": "a reply that nothing asked for",
    "BoardReplyLostTest": "is due",
    "BoardBeatLostTest": "the beat is",
    "BoardLitLateTest": "the displays begin",
    "BoardNothingTest": "nothing was checked",
}

# Those that press the button.
PRESSED = ("BoardGoTest", "BoardFullTest", "BoardSilenceTest", "BoardResetsTest", "BoardMixedTest")


def simulated(folder, test, seed):
    return run(run_settings(test, BOARD, seed, 60, folder=folder, agent=BURST))


@pytest.mark.parametrize("test", names_of(Block.BOARD))
def test_passes(tmp_path, seed, test):
    result = simulated(tmp_path / "run", test, seed)
    assert result.passed and result.counts, result.explain()
    assert result.counts["runs"] and result.counts["gos"]
    assert (result.counts["resets"] > 1) == (test in PRESSED)


@pytest.mark.parametrize("name", SAID)
def test_a_lie_fails_the_test(tmp_path, seed, name):
    result = simulated(tmp_path / "run", name, seed)
    assert not result.passed
    log = result.log.read_text()
    assert SAID[name] in log, log[-3000:]
