"""Kinds of arguments that commands share."""

import argparse
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from pathlib import Path

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


def natural(text: str) -> int:
    """Parse an integer that is not negative."""
    return _at_least(text, 0, "must not be negative")


def positive(text: str) -> int:
    """Parse an integer of at least 1."""
    return _at_least(text, 1, "must be at least 1")


def named_folder(text: str) -> Path:
    """Parse the name of a folder."""
    if not text:
        raise argparse.ArgumentTypeError("names no folder: give one, or . for this one")
    return Path(text)


def _at_least(text: str, least: int, must: str) -> int:
    try:
        value = int(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text:.40}: not an integer") from error
    if value < least:
        raise argparse.ArgumentTypeError(f"{text:.40}: {must}")
    return value


def add_numbers(
    parser: argparse.ArgumentParser, option: str, names: str, about: str, default: object = None
) -> None:
    """Add an option with an exact decimal number for each of the names."""
    many = names.split()
    if len(many) == 1:
        parser.add_argument(option, type=number, metavar=names, default=default, help=about)
    else:
        parser.add_argument(
            option, type=number, nargs=len(many), metavar=tuple(many), default=default, help=about
        )


def add_seed(parser: argparse.ArgumentParser, what: str = "what all random choices follow from") -> None:
    """Add ``--seed``."""
    parser.add_argument("--seed", type=natural, default=1, help=f"{what} (1)")
