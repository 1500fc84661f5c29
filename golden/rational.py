"""Exact rationals: those of gmpy2, which compute as Fraction does in a fraction of its time.

To the type checker they are Fractions: gmpy2 says nothing of its types.
"""

from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    Rational = Fraction
else:
    import gmpy2

    Rational = gmpy2.mpq
