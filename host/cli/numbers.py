"""Decimal numbers on the command line, exactly as they are written."""

import argparse
from decimal import Decimal, InvalidOperation
from fractions import Fraction

_DIGITS = 60


def number(text: str) -> Fraction:
    """Parse a decimal number exactly."""
    try:
        value = Decimal(text)
    except InvalidOperation as error:
        raise argparse.ArgumentTypeError(f"{text:.40}: not a finite decimal number") from error
    if not value.is_finite():
        raise argparse.ArgumentTypeError(f"{text:.40}: not a finite decimal number")
    # Keeps the exact fraction, and everything computed from it, of a reasonable size.
    if abs(value.adjusted()) > _DIGITS or len(value.as_tuple().digits) > _DIGITS:
        raise argparse.ArgumentTypeError(f"{text:.40}: beyond {_DIGITS} digits")
    return Fraction(value)
