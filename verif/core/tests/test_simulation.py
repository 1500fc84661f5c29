"""Every UVM test passes on the core, in the configurations where it has most to find."""

import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import load
from triaxis.golden.errors import InputError
from triaxis.sim.configuration import parse_configuration
from triaxis.verif.testbench.simulation import run, run_settings
from triaxis.verif.testbench.test_table import REPLAY, core_tests

RUNS = [(test, "w16_m16", 1500) for test in core_tests() if test != REPLAY] + [
    ("RandomTest", "w13_m4_t1", 500),
    ("ResetsTest", "w13_m4_t1", 500),
    ("CoplanarTest", "w16_m0_no_edge_box", 500),
]


def test_a_folder_that_cannot_be_written_is_one_clear_line(tmp_path):
    (tmp_path / "runs").touch()
    settings = run_settings("RandomTest", "w16_m16", 1, 10, folder=tmp_path / "runs" / "one")
    with pytest.raises(InputError, match="runs/one: cannot make this folder: Not a directory"):
        run(settings)


@pytest.mark.parametrize(("test", "config", "pairs"), RUNS)
def test_passes(seed, test, config, pairs):
    result = run(run_settings(test, parse_configuration(config), seed, pairs))
    assert result.passed, result.explain()
    assert result.counts is not None
    assert result.counts["checked"] > 0
    model = core_model(*result.settings.configuration.covered)
    assert load(result.coverage, model).hits["claim"].sum() == result.counts["checked"]
    if test == "ResetsTest":
        assert result.counts["resets"] > 3
        assert result.counts["discarded_by_reset"] > 0
