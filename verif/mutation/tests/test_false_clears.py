"""Certificates turn each wrong clear of a data path into a fault; without them it is seen to come through."""

import pytest

from triaxis.verif.core.tests.broken_rtl import broken_rtl
from triaxis.verif.mutation.false_clears import compare

# Mutants of what decides: many of them make the core say clear of what is near.
OF = ("triaxis_interval/*", "triaxis_verdict/*", "triaxis_box/*")


def nothing(_):
    """Take progress."""


@pytest.mark.simulator
@pytest.mark.regress
def test_a_wrong_clear_becomes_a_fault_and_comes_through_where_claims_are_not_looked_at(tmp_path, seed):
    checked = compare(nothing, seed, 2000, of=OF)
    assert checked.passed and len(checked.dangerous(False)) > 20 and not checked.missed(False)
    change = ("core/triaxis_certified_core.sv", "!shown.claim.is_near && !holds", "1'b0")
    blind = compare(nothing, seed, 2000, broken_rtl(tmp_path / "dut", change), OF)
    assert not blind.passed and len(blind.missed(False)) > 20
