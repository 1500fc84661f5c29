import pytest

from triaxis.coverage.arithmetic import BoundError, evaluate


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3 * L**3 + 1", 3 * 7**3 + 1),
        ("-(L // 2) % 4", -(7 // 2) % 4),
        ("1 << W", 8),
        ("L >> 1", 3),
        ("2 + (W > 2)", 3),
        ("W == 3 and not L == 3", 1),
        ("W == 4 or 0", 0),
    ],
)
def test_values(text: str, value: int) -> None:
    assert evaluate(text, {"W": 3, "L": 7}) == value


@pytest.mark.parametrize(
    "text",
    ["L", "1 +", "open('x')", "W.real", "1.5", "W / 2", "1 // 0", "1 << -1", "'a'", "2**-1", "[1]"],
)
def test_what_is_no_whole_number_arithmetic_is_refused(text: str) -> None:
    with pytest.raises(BoundError):
        evaluate(text, {"W": 3})
