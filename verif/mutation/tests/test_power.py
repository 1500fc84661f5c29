"""The power of tests: which of them are needed, and that it is measured with the tests themselves."""

import random
from itertools import combinations

import pytest

from triaxis.golden.errors import InputError
from triaxis.host.cli import DONE, main
from triaxis.verif.mutation import power
from triaxis.verif.mutation.catalogue import catalogue
from triaxis.verif.mutation.power import Power, measure_power, sampled
from triaxis.verif.mutation.targets import MAIN, SMALLEST
from triaxis.verif.testbench.trials import Verdict

pytest.importorskip("pyslang", reason="mutants need pyslang: make setup")


def of(**found):
    return Power("a model", tuple("abcdefgh"), {test: frozenset(names) for test, names in found.items()})


@pytest.mark.parametrize(
    ("found", "fewest"),
    [
        ({"A": "abc", "B": "ab", "C": "c"}, ("A",)),
        ({"A": "ab", "B": "bc", "C": "ac"}, ("A", "B")),
        # The test with most is not among the fewest.
        ({"A": "abcd", "B": "abe", "C": "cdf"}, ("B", "C")),
        ({"A": "a", "B": "", "C": "b"}, ("A", "C")),
        ({"A": "", "B": ""}, ()),
    ],
)
def test_the_fewest_tests_notice_all_that_any_does(found, fewest):
    assert of(**found).fewest == fewest


def test_the_fewest_are_the_fewest_of_all_sets():
    seed = 20261127
    print(f"seed {seed}")
    draw = random.Random(seed)
    for _ in range(200):
        one = of(**{test: "".join(n for n in "abcdefgh" if draw.random() < 0.3) for test in "ABCDEF"})
        sizes = [
            count
            for count in range(7)
            for chosen in combinations(one.found_by, count)
            if one.noticed <= frozenset().union(*(one.found_by[test] for test in chosen))
        ]
        assert len(one.fewest) == min(sizes)
        assert frozenset().union(*(one.found_by[test] for test in one.fewest)) == one.noticed
        needed = {test for test in one.found_by if one.alone(test)}
        assert needed <= set(one.fewest)


def test_a_test_that_fails_without_a_mutant_or_says_nothing_is_told():
    fine = Verdict("no mutant", "A", "", 9)
    with pytest.raises(InputError, match=r"no mutant selected: A: wrong word"):
        power._judged("m", ("x",), {"A": [Verdict("no mutant", "A", "wrong word", 3)]})
    with pytest.raises(InputError, match=r"no mutant selected: A: no verdict"):
        power._judged("m", ("x",), {"A": []})
    found, problems = power._judged(
        "m", ("x", "y", "z"), {"A": [fine, Verdict("x", "A", "wrong", 1), Verdict("y", "A", "", 0, "killed")]}
    )
    assert found.found_by == {"A": {"x"}}
    assert problems == ["y: no verdict of A: killed", "z: no verdict of A: its process ended"]


@pytest.mark.long
def test_mutants_are_drawn_by_seed_and_none_is_equivalent():
    every = catalogue()
    one, other = (sampled(MAIN, seed, 50, every) for seed in (1, 2))
    assert one == sampled(MAIN, 1, 50, every) and one != other
    assert all(mutant.file.startswith("core/") for mutant in one)
    with pytest.raises(InputError, match=r"core/nothing\*: no such mutant"):
        measure_power([MAIN], files="core/nothing*")


@pytest.mark.long
@pytest.mark.simulator
def test_each_mutant_meets_every_test(monkeypatch, capsys):
    monkeypatch.setattr(power, "MODELS", {"core": SMALLEST})
    monkeypatch.setattr("triaxis.verif.commands.inject.MODELS", {"core": SMALLEST})
    assert (
        main(["prove", "power", "--of", "core", "--file", "core/triaxis_flags.sv", "--one-in", "2"]) == DONE
    )
    told = capsys.readouterr().out
    assert "written" not in told and "PASSED: w8_m0_no_edge_box: " in told, told
