"""What counts as RTL: everything that can elaborate, wherever it lies; what lies outside is refused."""

import shutil
from pathlib import Path

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.build import content_hash, rtl_files, rtl_hash
from triaxis.sim.paths import DUT, listed


@pytest.fixture
def dut(tmp_path: Path) -> Path:
    """A copy of the RTL."""
    return shutil.copytree(DUT, tmp_path / "dut")


def test_all_of_the_rtl_counts(dut: Path) -> None:
    names = {path.name for path in rtl_files()}
    files = [path for folder in ("core", "mesh", "board") for path in DUT.glob(f"{folder}/*.f")]
    named = [path.name for listing in files for path in listed(listing)]
    assert names == {"triaxis_stage.svh", *(path.name for path in files), *named}
    assert rtl_hash(dut) == rtl_hash() == content_hash(sorted(DUT.rglob("*.*")))


@pytest.mark.parametrize("name", ["new.sv", "new.svh", "new.v", "new.vh", "new.f", "sub/new.svh"])
def test_a_new_file_is_another_rtl(dut: Path, name: str) -> None:
    place = dut / name
    place.parent.mkdir(exist_ok=True)
    place.touch()
    assert rtl_hash(dut) != rtl_hash()


@pytest.mark.parametrize(
    "entry", ["../../other.sv", "/other.sv", "other.inc", "+incdir+other", "sub/../../../x.sv"]
)
def test_a_list_that_names_what_is_not_hashed_is_refused(dut: Path, entry: str) -> None:
    with (dut / "core" / "triaxis.f").open("a") as file:
        file.write(f"{entry}\n")
    with pytest.raises(InputError, match="must be a file of RTL"):
        rtl_hash(dut)
