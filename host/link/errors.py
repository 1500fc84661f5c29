"""What may go wrong between host and board: the verdict is then unknown."""

from triaxis.golden.errors import InputError


class LinkError(InputError):
    """No verdict can be had from the board: one line that says why and what to do."""


class SessionLostError(LinkError):
    """The board stands elsewhere than the host thinks; starting again from HELLO may help."""
