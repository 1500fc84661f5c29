import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import check_margin, check_pairs, check_width, read_pairs


def test_good_pairs_of_any_integer_type():
    for dtype in (np.int8, np.uint8, np.int32, np.uint64):
        assert check_pairs(np.ones((4, 2, 3, 3), dtype), 8).dtype == np.int64
    assert len(check_pairs(np.zeros((0, 2, 3, 3), np.int16), 8)) == 0


def placed(value):
    pairs = np.zeros((9, 2, 3, 3), np.uint64 if value >= 1 << 63 else np.int64)
    pairs[7, 1, 2, 1] = value
    return pairs


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros((4, 3, 2, 3), np.int64), "shape"),
        (np.full((1, 2, 3, 3), np.nan), "type float64"),
        (np.zeros((1, 2, 3, 3), bool), "type bool"),
        (np.full((1, 2, 3, 3), "NaT", "m8[s]"), "type timedelta64"),
        (placed(2**15), r"pair 7, triangle B, vertex 2, coordinate y: .*-32768\.\.32767"),
        (placed(-(2**15) - 1), "coordinate y"),
        # No value wraps.
        (placed(2**64 - 1), "18446744073709551615"),
    ],
)
def test_wrong_pairs_are_refused(array, message):
    with pytest.raises(InputError, match=message):
        check_pairs(array, 16)


def test_limits_of_width_and_margin():
    for width in (7, 33, -1):
        with pytest.raises(InputError, match=r"8\.\.32"):
            check_width(width)
    check_margin(65535, 16)
    for margin in (-1, 65536):
        with pytest.raises(InputError, match=r"0\.\.65535"):
            check_margin(margin, 16)


def test_pairs_of_any_layout(tmp_path, rng):
    for dtype in ("<i8", ">i2", "u1"):
        pairs = np.asarray(rng.integers(0, 99, (5, 2, 3, 3)), dtype, order="F" if dtype == "u1" else "C")
        np.save(tmp_path / "pairs.npy", pairs)
        assert (read_pairs(tmp_path / "pairs.npy", 16) == pairs).all()


def test_what_is_not_whole_is_refused(tmp_path):
    path, objects = tmp_path / "pairs.npy", tmp_path / "objects.npy"
    np.save(objects, np.array([{}]), allow_pickle=True)
    np.save(path, np.zeros((5, 2, 3, 3), np.int64))
    whole = path.read_bytes()
    for data, message in (
        (whole + b"\0", "720 bytes of numbers .* holds 721"),
        (whole + whole, "720 bytes of numbers"),
        (whole[:-9], "holds 711"),
        (whole.replace(b"(5, ", b"(5000000000000, "), "holds 7"),
        (objects.read_bytes(), r"^[^\n]*$"),
        (b"not numpy", r"^[^\n]*$"),
        (b"", r"^[^\n]*$"),
    ):
        path.write_bytes(data)
        with pytest.raises(InputError, match=message):
            read_pairs(path, 16)
