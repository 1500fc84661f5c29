import pytest

from triaxis.coverage import testplan as plans
from triaxis.coverage import testplan_progress
from triaxis.coverage.report import IllegalHit, ItemReport, ModelReport
from triaxis.coverage.testplan_lint import Inventory, lint
from triaxis.golden.errors import InputError

GOOD = """
{
  name: "toy"
  requirements: [
    { id: "A-1", text: "It is right." }
    { id: "A-2", text: "It is fast." }
  ]
  testpoints: [
    {
      name: smoke
      desc: '''
            **Goal**: It works,
            after a fashion.
            **Stimulus**: Some.
            **Check**: The answer.'''
      stage: V1
      requirements: ["A-1"]
      tests: ["SmokeTest", "LongTest"]
      bins: ["answer", "kind.near / *"]
      assertions: ["sva.Held"]
      mutants: ["fifo/*"]
    }
    {
      name: rest
      desc: '''
            **Goal**: G.
            **Stimulus**: S.
            **Check**: C.'''
      stage: V3
      requirements: ["A-1", "A-2"]
      tests: ["N/A"]
      proofs: ["axi"]
      faults: ["F1"]
      checks: ["grid"]
      bins: ["kind.clear / *"]
      mutants: ["core/swap/*", "core/drop/*"]
    }
  ]
}
"""

NARROW = frozenset({"answer.right", "kind.near / 0", "kind.clear / 0"})
INVENTORY = Inventory(
    tests=frozenset({"SmokeTest", "LongTest"}),
    proofs=frozenset({"axi"}),
    faults=frozenset({"F1"}),
    checks=frozenset({"grid"}),
    assertions=frozenset({"sva.Held"}),
    mutants=frozenset({"fifo/swap/1", "core/swap/2", "core/drop/3"}),
    bins={"narrow": NARROW, "wide": NARROW | {"kind.near / 1"}},
    illegal={"narrow": frozenset({"answer.wrong"}), "wide": frozenset({"answer.wrong"})},
)


def read(tmp_path, text):
    path = tmp_path / "plan.hjson"
    path.write_text(text)
    return plans.read_testplan(path)


def changed(old, new):
    assert GOOD.count(old) == 1, old
    return GOOD.replace(old, new)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        # What a testpoint lacks.
        ('tests: ["SmokeTest", "LongTest"]', "tests: []", "testpoint smoke: no tests"),
        ('["SmokeTest", "LongTest"]', '["N/A"]', "testpoint smoke: nothing runs"),
        ('mutants: ["fifo/*"]', "mutants: []", "testpoint smoke: no mutants"),
        ("name: rest", "name: smoke", "testpoint smoke: there are 2 of this name"),
        ("**Goal**: G.", "", "testpoint rest: no goal: add **Goal**: to its desc"),
        ("stage: V3", "stage: V9", "testpoint rest: stage V9: must be one of V1, V2, V3"),
        ("stage: V3", "", "testpoint rest: stage missing: must be one of"),
        # What it names and is not there.
        ('["kind.clear / *"]', '["kind.clear / *", "kind.far*"]', "bin kind.far*: matches nothing in kind"),
        ('["kind.clear / *"]', '["kind.clear / *", "ki*"]', "bin ki*: a pattern must write out"),
        # What is promised and nobody serves, and the other way round.
        ('["A-1", "A-2"]', '["A-1"]', "requirement A-2: no testpoint serves it"),
        ('["A-1"]', "[]", "testpoint smoke: serves no requirement"),
        ('["A-1", "A-2"]', '["A-3", "A-2"]', "testpoint rest: requirement A-3: unknown"),
        ('id: "A-2"', 'id: "A-1"', "requirement A-1: there are 2 of this id"),
        # What is there and nobody owns: an illegal bin.
        ('"answer"', '"answer.right"', "bin answer.wrong: no testpoint owns"),
    ],
)
def test_each_rule_refuses(tmp_path, old, new, said):
    found = lint(read(tmp_path, changed(old, new)), INVENTORY)
    assert any(said in line for line in found), found


def test_what_is_not_well_formed_is_named(tmp_path):
    for old, new, said in (
        ("stage: V3", "stage: V3\n stage: V1", "rest: key stage given twice"),
        ('["F1"]', "[1]", "testpoint rest: faults: must be a list of texts"),
        (GOOD, "{ name: [", "not a testplan"),
        (GOOD, "{ name: x\n requirements: []\n testpoints: [] }", "at least one"),
        (GOOD, "{ name: x\n testpoints: [] }", "must hold `name`, `requirements` and `testpoints`, and noth"),
        (GOOD, "{ name: x\n requirements: []\n testpoints: [5] }", "testpoint 1: must be an object"),
        ("name: rest", "", "testpoint 2: needs a name"),
        ('tests: ["N/A"]', "", r"rest: needs `tests`, \["),
        ("stage: V3", "stage: 3", "rest: stage: must be a text"),
        ("stage: V3", "state: V3", "rest: state: no such key; one of: name, desc, stage, requirements"),
        ("**Stimulus**: S.", "**Goal**: S.", "rest: desc: must be .* once, and nothing before"),
        ('text: "It is fast."', "", "requirement A-2: must hold an `id` and a `text`"),
        ('"It is fast."', "5", "requirement A-2: must hold an `id` and a `text`"),
    ):
        with pytest.raises(InputError, match=said):
            read(tmp_path, changed(old, new))


def report(model, missing=(), illegal=()):
    hits = tuple(IllegalHit(bin_, 1, "never") for bin_ in illegal)
    items = ItemReport("answer", "", 0, 0, (), (), hits), ItemReport("kind", "", 0, 0, missing, (), ())
    return ModelReport(model, items)


ALL_PASSED = {
    "tests": {"SmokeTest": True, "LongTest": True, "ReplayTest": False},
    "proofs": {"axi": True},
    "faults": {"F1": True},
    "checks": {"grid": True},
    "mutants": {"fifo/swap/1": True, "core/swap/2": True, "core/drop/3": True},
    "coverage": (report("narrow"), report("wide")),
}


def status(tmp_path, text=GOOD, **changes):
    """Return the statuses of the two testpoints; all passed but for the changes."""
    results = testplan_progress.PlanResults(**{**ALL_PASSED, **changes})
    smoke, rest = testplan_progress.progress(read(tmp_path, text), INVENTORY, results)
    assert (smoke.stage, rest.stage) == ("V1", "V3")
    return smoke, rest


@pytest.mark.parametrize(
    ("changes", "smoke_passed", "rest_passed", "failing"),
    [
        ({}, True, True, ""),
        ({"tests": {"SmokeTest": True, "LongTest": False}}, False, True, "LongTest"),
        ({"tests": {"SmokeTest": True}}, None, True, ""),
        ({"proofs": {"axi": False}}, True, False, "axi"),
        ({"checks": None}, True, None, ""),
        ({"mutants": {**ALL_PASSED["mutants"], "core/swap/2": False}}, True, False, "core/swap/2"),
        ({"mutants": {"fifo/swap/1": True}}, True, None, ""),
        # An equivalent mutant counts neither way, but some mutant must have been killed.
        ({"mutants": {"core/swap/2": True, "fifo/swap/1": True}, "equivalent": frozenset({"core/drop/3"})},
         True, True, ""),
        # A configuration that was not run.
        ({"coverage": (report("narrow"),)}, None, None, ""),
        ({"coverage": (report("narrow"), report("wide", ("near / 1",)))}, False, True, "kind.near / 1"),
        ({"coverage": (report("narrow", illegal=("wrong",)), report("wide"))}, False, True, "answer.wrong"),
    ],
)  # fmt: skip
def test_progress(tmp_path, changes, smoke_passed, rest_passed, failing):
    smoke, rest = status(tmp_path, **changes)
    assert (smoke.passed, rest.passed) == (smoke_passed, rest_passed)
    assert [*smoke.failing, *rest.failing] == ([failing] if failing else [])


def test_what_was_not_measured_or_does_not_exist_is_not_0(tmp_path):
    smoke, _ = status(tmp_path, changed('"LongTest"', '"LongTest", "NoTest"'), mutants=None, coverage=None)
    tests, told = smoke.tallies["tests"], smoke.content()
    assert (told["tests"], told["bins"], told["mutants"], told["others"]) == ([2, 3], None, None, None)
    assert (smoke.passed, smoke.tallies["mutants"], smoke.tallies["bins"]) == (None, None, None)
    assert tests and (tests.passed, tests.failed, tests.not_run) == (2, 0, 1)
    # Proofs, faults and checks are told together: all, or nothing.
    assert status(tmp_path, proofs={"axi": False})[1].content()["others"] == [2, 3]
    assert status(tmp_path, faults=None)[1].content()["others"] is None


def test_a_stage_that_there_is_not_is_left_to_the_linter(tmp_path):
    plan = read(tmp_path, changed("stage: V1", "stage: V9"))
    found = testplan_progress.progress(plan, INVENTORY, testplan_progress.PlanResults(**ALL_PASSED))
    assert [one.stage for one in found] == ["V3", "V9"]


def test_of_several_runs_all_must_pass():
    runs = [("A", True), ("B", True), ("A", False), ("A", True)]
    assert testplan_progress.every_run_passed(runs) == {"A": False, "B": True}
