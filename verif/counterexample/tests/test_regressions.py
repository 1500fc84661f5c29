"""Kept counterexamples: written whole, read back as they were, refused where damaged."""

import dataclasses
import json
import re

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.golden.judge import judge_pairs
from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.result import NEAR
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.failing_pairs import Stream
from triaxis.verif.core.kept_cases import (
    REGRESSIONS,
    RegressionCase,
    load_regressions,
    read_case,
    read_cases,
    write_case,
)
from triaxis.verif.counterexample.explaining import case_of
from triaxis.verif.counterexample.finding import Counterexample, Symptom, describe


def case(pairs, margins, config="w16_m16"):
    stream = Stream(np.array(pairs, np.int64), np.array(margins, np.int64))
    said, right = np.uint16(NEAR), np.uint16(0)
    found = Counterexample(parse_configuration(config), stream, Symptom.FALSE_ALARM, said, right)
    return case_of(found, "a fault")


@pytest.fixture
def some(rng):
    return case(rng.integers(-300, 300, (2, 2, 3, 3)), [17, 0])


def test_round_trip_and_the_same_is_kept_once(tmp_path, some):
    path = write_case(some, tmp_path)
    assert re.fullmatch(r"false_alarm-[0-9a-f]{12}\.json", path.name)
    again = read_case(path)
    assert (again.stream.pairs == some.stream.pairs).all()
    assert (again.stream.margins == some.stream.margins).all()
    assert again.found == some.found
    assert again.found["right"] == "clear by axis 0 (box x) (0x0000)"
    assert again.width == 10
    text = path.read_bytes()
    # Found again elsewhere, in another way: what is sent counts.
    found = {**some.found, "configuration": "w24_m24", "symptom": "claim"}
    assert write_case(dataclasses.replace(some, found=found), tmp_path) == path
    assert path.read_bytes() == text
    assert [other.name for other in tmp_path.iterdir()] == [path.name]
    changed = some.stream.pairs.copy()
    changed[0, 0, 0, 0] += 1
    write_case(RegressionCase(Stream(changed, some.stream.margins), some.found), tmp_path)
    write_case(RegressionCase(Stream(some.stream.pairs, some.stream.margins + 1), some.found), tmp_path)
    assert len(list(tmp_path.iterdir())) == 3


def damaged(text):
    """Return damaged texts of a case, each with what the error must say."""
    content = json.loads(text)

    def with_pair(**change):
        return json.dumps({**content, "pairs": [{**content["pairs"][0], **change}, *content["pairs"][1:]]})

    a = content["pairs"][0]["A"]
    return {
        "cut short": (text[: len(text) // 2], "not JSON"),
        "no found": (json.dumps({k: v for k, v in content.items() if k != "found"}), "'found' is missing"),
        "a fraction": (with_pair(A=[[1.5, 0, 0], *a[1:]]), "no integer"),
        "too large": (with_pair(A=[[1 << 40, 0, 0], *a[1:]]), "does not fit 32 bits"),
        "a negative margin": (with_pair(margin=-1), "does not fit"),
        "another coordinate": (with_pair(A=[[a[0][0] + 1, *a[0][1:]], *a[1:]]), "was changed"),
        "another width": (json.dumps({**content, "width": 16}), "was changed"),
    }


def test_damaged_files_are_refused(tmp_path, some):
    path = write_case(some, tmp_path)
    for name, (text, message) in damaged(path.read_text()).items():
        path.write_text(text)
        with pytest.raises(InputError) as caught:
            load_regressions(Configuration(16, 16), tmp_path)
        line = str(caught.value)
        assert line.startswith(f"{path}: "), name
        assert message in line, (name, line)
        assert "\n" not in line
    write_case(some, tmp_path / "other").rename(tmp_path / "false_alarm-000000000000.json")
    path.unlink()
    with pytest.raises(InputError, match="was changed"):
        load_regressions(Configuration(16, 16), tmp_path)
    with pytest.raises(InputError, match="cannot read"):
        read_case(tmp_path / "no.json")


def test_only_what_fits_is_loaded_and_whole(tmp_path):
    small, wide = np.zeros((1, 2, 3, 3), int), np.full((1, 2, 3, 3), 1 << 14)
    for pairs, margins in (((small,), [0]), ((small, small), [3, 0]), ((small, wide), [0, 0])):
        write_case(case(np.concatenate(pairs), margins), tmp_path)
    for size, margins in {(8, 0): [0], (8, 2): [0, 0, 3], (16, 0): [0] * 3, (16, 16): [0] * 4 + [3]}.items():
        pairs, loaded = load_regressions(Configuration(*size), tmp_path)
        assert sorted(loaded.tolist()) == margins
        assert pairs.shape == (len(margins), 2, 3, 3)


KEPT = read_cases()


@pytest.mark.parametrize("kept", KEPT, ids=lambda kept: kept.name)
def test_what_a_kept_case_calls_right_is_right(kept):
    configuration = parse_configuration(kept.found["configuration"])
    assert kept.stream.fits(configuration)
    pairs, margins = kept.stream.pairs[-1:], kept.stream.margins[-1:]
    facts = bulk_facts(pairs, margins)
    assert facts.verdicts == judge_pairs(pairs, margins)
    right = describe(expected_words(facts, configuration)[0])
    assert kept.found["right"] == right != kept.found["core_said"]
    assert (REGRESSIONS / f"{kept.name}.json").is_file()
