"""Monitors that lie: what the tests are made of that a scoreboard must fail."""

from collections.abc import Callable
from itertools import count
from typing import Any

from pyuvm import uvm_factory

# From one transaction those that the scoreboard is told of in its place.
Lie = Callable[[Any], list[Any]]


def lie_about(monitor: Any, falsify: Lie, which: range) -> None:
    """Put a liar in the place of a monitor, for transactions of these numbers, counted from 0."""

    class Liar(monitor):
        """Publishes what `falsify` makes of transactions."""

        def build_phase(self) -> None:
            """Put the lie in front of the analysis port."""
            super().build_phase()
            publish, numbers = self.ap.write, count()

            def write(datum: Any) -> None:
                for told in falsify(datum) if next(numbers) in which else [datum]:
                    publish(told)

            self.ap.write = write

    uvm_factory().set_type_override_by_type(monitor, Liar)
