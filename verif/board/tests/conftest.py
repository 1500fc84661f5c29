import pytest

from triaxis.verif.board.tests.board_host import BoardHost, powered


@pytest.fixture
def host() -> BoardHost:
    """Return a host of a board after power-up and HELLO."""
    return powered()
