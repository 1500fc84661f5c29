"""The simulated board of tests of the host."""

from collections.abc import Iterator

import pytest

from triaxis.sim.simulated_board import SimulatedTop


@pytest.fixture
def top(request: pytest.FixtureRequest) -> Iterator[SimulatedTop]:
    """Simulate a board of the PARAMETERS of the test's module."""
    with SimulatedTop(request.module.PARAMETERS) as board:
        yield board
        assert board.pins().bad_clocks == 0
