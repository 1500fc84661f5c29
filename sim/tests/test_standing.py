"""What a run is of is known to be written to, whatever stands there in the end."""

import shutil

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT
from triaxis.sim.standing import standing
from triaxis.sim.validity import Sources

SOURCES = Sources(("triaxis.sim.standing",))


def test_an_edit_that_is_taken_back_is_seen(tmp_path):
    dut = tmp_path / "dut"
    shutil.copytree(DUT, dut)
    file = dut / "core" / "triaxis_core.sv"
    before, text = standing(SOURCES, dut), file.read_text()
    assert before.stands
    file.write_text("another")
    assert not before.stands
    file.write_text(text)
    with pytest.raises(InputError, match="was written to during the run"):
        before.check()
    again = standing(SOURCES, dut)
    (dut / "core" / "new.sv").write_text("")
    assert not again.stands
