"""The board's data by itself."""

import re

import pytest

from triaxis.fpga.pins import PINS, read_pins
from triaxis.golden.errors import InputError


def test_what_is_published():
    board = read_pins()
    assert board.source.startswith("https://github.com/Digilent/")
    assert board.pins["CLK100MHZ"] == "E3"
    assert board.pins["LED[15]"] == "V11"
    assert board.ports["seg_no[7]"] == board.pins["DP"]
    assert {"led_o[15]", "an_no[7]", "go_o", "stop_o", "beat_o"} <= board.ports.keys()
    assert len(board.ports) == 1 + 1 + 2 + 16 + 8 + 8 + 3
    assert all(re.fullmatch(r"[A-HJ-NPRT-V]\d{1,2}", pin) for pin in board.pins.values())


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('JA2 = "D18"', 'JA2 = "C17"', "C17: given to more than one name"),
        ('go_o = "JA1"', 'go_o = "JZ1"', "go_o: no such pin"),
        ('"CF", "CG", "DP"]', '"CF", "CG", "DQ"]', r"port seg_no\[7\]: no pin called DQ"),
    ],
)
def test_wrong_data_is_one_clear_error(tmp_path, old, new, says):
    text = PINS.read_text()
    assert text.count(old) == 1
    path = tmp_path / "pins.toml"
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=says):
        read_pins(path)
