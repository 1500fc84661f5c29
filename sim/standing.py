"""Whether what a run is of stood until the run ended, however soon an edit in between was taken back."""

from dataclasses import dataclass
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.native import written
from triaxis.sim.build import rtl_files
from triaxis.sim.paths import DUT
from triaxis.sim.validity import Provenance, Sources, provenance

_State = dict[Path, tuple[int, int] | None]


@dataclass(frozen=True)
class Standing:
    """What a run is of, taken before anything of it runs. ``valid_for``: what its result is valid for."""

    valid_for: Provenance
    _sources: Sources
    _dut: Path
    _state: _State

    @property
    def stands(self) -> bool:
        """Return whether none of its files was written to since, and none is new or gone."""
        return _state(self._sources, self._dut) == self._state

    def check(self) -> None:
        """Raise InputError where it does not stand."""
        if not self.stands:
            raise InputError("the RTL, or its environment, was written to during the run: run again")


def standing(sources: Sources, dut: Path = DUT) -> Standing:
    """Return how the files of ``sources``, and the RTL, stand now."""
    # First: what is written to while it is hashed is another afterwards.
    state = _state(sources, dut)
    return Standing(provenance(sources), sources, dut, state)


def _state(sources: Sources, dut: Path) -> _State:
    files = [*rtl_files(dut), *sources.files()]
    return dict(zip(files, written(files), strict=True))
