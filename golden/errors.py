"""The one kind of error that bad input raises."""


class InputError(ValueError):
    """Bad input: one line that says what, where, the limit, and what to do."""
