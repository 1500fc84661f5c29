"""Pictures of counterexamples: made for every kind of pair, and showing what they say."""

from xml.etree import ElementTree

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_facts
from triaxis.sim.configuration import parse_configuration
from triaxis.sim.result import AXIS_SHIFT, NEAR
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.failing_pairs import Stream
from triaxis.verif.counterexample.finding import Counterexample, Symptom, symptoms
from triaxis.verif.counterexample.picture import draw

FLOOR = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]
POINT = [[0, 0, 0]] * 3
WIDE = 1 << 31

COPLANAR_PAIR = (FLOOR, [[3, 3, 0], [5, 5, 0], [6, 3, 0]])

# Pairs and margins, what the core said (None: nothing), the words that must be in the picture, the core.
CASES = {
    "missed": ([(FLOOR, [[1, 1, -1], [1, 1, 3], [3, 3, 2]])], [0], 4 << AXIS_SHIFT, "core claims: axis 4"),
    "false alarm": ([(FLOOR, [[3, 3, 1], [5, 5, 3], [6, 3, 2]])], [0], NEAR, "right: axis 2 (box z)"),
    "a core without that axis": (
        [COPLANAR_PAIR], [0], NEAR, "separates, but is not in this core: axis 19", "w16_m0_no_edge_box",
    ),
    "segments in line": (
        [([[0, 0, 0], [2, 2, 2], [4, 4, 4]], [[4, 4, 4], [6, 6, 6], [9, 9, 9]])], [0], 3 << AXIS_SHIFT,
        "A: a segment, B: a segment",
    ),
    "no answer": ([(FLOOR, FLOOR)], [0], None, "core w32_m32: it hangs"),
    "the whole range": (
        [([[-WIDE] * 3, [WIDE - 1] * 3, [WIDE - 1, -WIDE, 3]], [[0, 0, 1], [9, 9, 5], [-3, -3, 0]])], [0], 0,
        "nearest points",
    ),
    "with the pair before": (
        [(FLOOR, POINT), (POINT, [[0, 0, 1], [0, 1, 0], [0, 1, 0]])], [1, 0], NEAR,
        "only after: margin 1, [[[0, 0, 0], [4, 0, 0]",
    ),
}  # fmt: skip


def counterexample(pairs, margins, said, config="w32_m32"):
    configuration = parse_configuration(config)
    stream = Stream(np.array(pairs, np.int64), np.array(margins, np.int64))
    right = expected_words(bulk_facts(stream.pairs[-1:], stream.margins[-1:]), configuration)
    if said is None:
        return Counterexample(configuration, stream, Symptom.INTERFACE, f"core {config}: it hangs", right[0])
    word = np.array([said], np.uint16)
    symptom = Symptom(int(symptoms(word, right)[0]))
    return Counterexample(configuration, stream, symptom, word[0], right[0])


def svg_text(path):
    """Return the text of an SVG file."""
    texts = ElementTree.parse(path).iter("{http://www.w3.org/2000/svg}text")
    return "\n".join("".join(text.itertext()) for text in texts)


@pytest.mark.parametrize("name", CASES)
def test_every_kind_of_pair(tmp_path, name):
    pairs, margins, said, expected, *core = CASES[name]
    found = counterexample(pairs, margins, said, *core)
    draw(found, tmp_path / "case.svg")
    text = svg_text(tmp_path / "case.svg")
    assert expected in text
    assert found.core_said in text
    assert found.right_answer in text
    assert f"{found.configuration.name}, margin {margins[-1]}" in text
    for vertex in {tuple(vertex) for triangle in pairs[-1] for vertex in triangle}:
        assert str(vertex) in text
    # The same counterexample gives the same picture.
    again = tmp_path / "again.svg"
    draw(found, again)
    assert again.read_bytes() == (tmp_path / "case.svg").read_bytes()
