"""Errors whose message is for the user as it is: one line that says what, where, the limit, what to do."""


class ToldError(Exception):
    """Any of them."""


class InputError(ToldError, ValueError):
    """Bad input, or an output that cannot be written."""
