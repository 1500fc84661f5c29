"""Counterexamples are made small, keep failing in the same way, and come out the same each time."""

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.judge import judge_pairs
from triaxis.host.cli import main
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import CoreError
from triaxis.verif.core.failing_pairs import Stream, read_failing
from triaxis.verif.core.kept_cases import read_cases
from triaxis.verif.core.tests.broken_rtl import broken_rtl
from triaxis.verif.counterexample import finding
from triaxis.verif.counterexample.explaining import explain_failures
from triaxis.verif.counterexample.finding import BareCore, Symptom
from triaxis.verif.counterexample.shrinking import Budget, minimise

CONFIGURATION = Configuration(8, 8)
NO_MARGIN = np.zeros(1, np.int64)


class HangingEngine:
    """Stands for a core that hangs on the pair after one with x = 50 at A1; its answers are all wrong."""

    def __init__(self, configuration, dut):
        self.runs = 0

    def words(self, pairs, margins):
        self.runs += 1
        if (pairs[:-1, 0, 0, 0] == 50).any():
            raise CoreError("core w8_m8: it hangs")
        return np.full(len(pairs), 0xFFFF, np.uint16), len(pairs)


def test_a_core_that_hangs(monkeypatch, rng):
    monkeypatch.setattr("triaxis.verif.counterexample.finding.RtlEngine", HangingEngine)
    core = BareCore(CONFIGURATION)
    pairs = rng.integers(-40, 40, (500, 1, 2, 3, 3))
    pairs[123, 0, 0, 0, 0] = 50
    # One stream of two must not hide what the others do.
    found = core.symptoms_together(np.repeat(pairs, 2, 1), np.zeros((500, 2), np.int64))
    assert (found == Symptom.INTERFACE).nonzero()[0].tolist() == [123]
    assert ((found != Symptom.RIGHT) & (found != Symptom.INTERFACE)).sum() == 499
    stream = Stream(pairs[100:130, 0], np.zeros(30, np.int64))
    assert core.symptom(stream) == Symptom.INTERFACE
    small = minimise(stream, core.test(Symptom.INTERFACE), Budget(pairs=3000, at_once=64))
    assert len(small) == 2
    assert np.count_nonzero(small.pairs) == 1


# --- A broken core ------------------------------------------------------------------------------------

# Two faults in one core, to be told apart by their symptoms: one needs the pair before it.
FAULTS = (
    (
        "core/triaxis_projections.sv",
        "assign far_d[i][j]   = edges_3[i][j] + across_3[i];",
        "assign far_d[i][j]   = edges_3[i][j] + across_3[i==2?j : i];",
    ),
    (
        "core/triaxis_boxes.sv",
        "        operand_margin_o <= margin;\n",
        "        if (margin != '0) operand_margin_o <= margin;\n",
    ),
)


@pytest.fixture(scope="module")
def broken(tmp_path_factory):
    return broken_rtl(tmp_path_factory.mktemp("broken"), *FAULTS)


@pytest.fixture(scope="module")
def core(broken):
    return BareCore(CONFIGURATION, broken)


# Two steps apart along x + y, the boxes overlapping; a margin of 5 left over from before hides it.
APART = np.array([[[0, 0, 0], [40, 0, 0], [0, 40, 0]], [[21, 21, 0], [60, 25, 30], [31, 70, -9]]])
FAR = APART + np.array([[[0, 0, 0]], [[0, 0, 50]]])


@pytest.fixture
def missed(core, rng):
    """Return a near pair that the core finds clear, whatever was before."""
    pairs = rng.integers(-100, 100, (2000, 2, 3, 3))
    found = core.symptoms_together(pairs[:, None], np.zeros((2000, 1), np.int64))
    return pairs[np.flatnonzero(found == Symptom.MISSED)[0]]


def archive(path, *arrays):
    names = ("pairs", "margins", "context", "context_margins", "context_counts")
    np.savez(path, **dict(zip(names, arrays, strict=False)))
    return path


def recorded(path, missed, rng):
    """Write an archive: the missed pair alone, and the other one after 20 pairs, one with a margin."""
    context = np.zeros((2, 20, 2, 3, 3), np.int64)
    context[1] = rng.integers(-20, 20, (20, 2, 3, 3))
    margins = np.zeros((2, 20), np.int64)
    # A near pair, so that its margin is looked at; no later one may replace it: they have none.
    context[1, 6], margins[1, 6] = missed, 5
    pairs = np.stack([missed, APART])
    return archive(path, pairs, np.zeros(2, np.int64), context, margins, np.array([0, 20]))


@pytest.mark.regress
@pytest.mark.simulator
def test_command_and_a_failed_run(broken, missed, tmp_path, rng, capsys, monkeypatch):
    def shrunk(failing, *words, dut=broken):
        common = ("--config", CONFIGURATION.name, "--dut", dut, "--pictures", pictures)
        status = main(["regress", "shrink", *map(str, (failing, *common, *words))])
        return status, *capsys.readouterr()

    assert explain_failures(tmp_path, CONFIGURATION, broken) == ()
    failing = recorded(tmp_path / "failing_pairs.npz", missed, rng)
    store, pictures = tmp_path / "store", tmp_path / "pictures"
    status, out, _ = shrunk(failing, "--store", store, "--fault", "two faults")
    assert status == 0
    assert f"before: margin 0, {missed.tolist()}" in out
    assert "says clear where the pair is near" in out and "; then margin 0" in out
    assert len(list(pictures.glob("*.png"))) == len(read_cases(store)) == 2
    for case in read_cases(store):
        assert case.found["fault"] == "two faults"
        assert len(case.stream) == 1 + (case.found["symptom"] == "false_alarm")
        assert np.abs(case.stream.pairs).max() <= 4

    status, again, _ = shrunk(failing, "--no-keep")
    assert (status, again) == (0, "".join(line for line in out.splitlines(True) if "kept:" not in line))
    far = archive(tmp_path / "far.npz", FAR[None], NO_MARGIN)
    one = np.ones(1, np.int64)
    before = archive(tmp_path / "before.npz", FAR[None], NO_MARGIN, FAR[None, None], -one[None], one)
    for words, dut, due, said in (
        ((far, "--no-keep"), broken, 1, "none of 1 pairs fails on the bare core w8_m8"),
        ((tmp_path / "no.npz",), broken, 2, "cannot read"),
        ((before,), broken, 2, "context of pair 0: does not fit w8_m8"),
        ((failing,), tmp_path, 2, "no triaxis_pkg.sv"),
    ):
        status, _, error = shrunk(*words, dut=dut)
        assert status == due and said in error

    # What a failed run left is explained by itself; what is damaged stops nothing.
    text = "\n".join(explain_failures(tmp_path, CONFIGURATION, broken, tmp_path / "other"))
    assert text.count("drawn:") == text.count("kept:") == 2
    assert explain_failures(tmp_path, CONFIGURATION, tmp_path / "no_rtl")[0].startswith("not shrunk: ")
    monkeypatch.setattr(finding, "judge_pairs", lambda pairs, margins: judge_pairs(pairs * 0, margins))
    assert explain_failures(tmp_path, CONFIGURATION, broken)[0].startswith("the bulk checker and the golden")
    failing.write_bytes(b"PK broken")
    assert explain_failures(tmp_path, CONFIGURATION, broken)[0].startswith("not shrunk: ")


def test_damaged_contexts_are_refused(tmp_path):
    pairs, margins = np.stack([FAR, APART]), np.zeros(2, np.int64)
    context, none = np.zeros((2, 4, 2, 3, 3), np.int64), np.zeros((2, 4), np.int64)
    path, counts = tmp_path / "failing.npz", np.array([0, 4])

    def refused(*arrays):
        with pytest.raises(InputError) as caught:
            read_failing(archive(path, pairs, margins, *arrays), CONFIGURATION)
        return str(caught.value)

    assert "only context" in refused(context)
    assert "do not go with 2 failing pairs" in refused(context[:, 0], none, counts)
    assert "must be 0..4" in refused(context, none, counts + 1)
    assert "must be integers" in refused(context * 1.5, none, counts)
    assert "context of pair 1: does not fit w8_m8" in refused(context + 128, none, counts)
    # Without recorded context, what failed before stands for it.
    first, second = read_failing(archive(path, pairs, margins), CONFIGURATION)
    assert first.context is None
    assert second.context is not None
    assert (second.context.pairs == FAR).all()


def test_equal_values_shrink_together_in_few_calls():
    """What fails where two coordinates are equal and large: one by one neither can be smaller."""
    pair = np.zeros((2, 3, 3), np.int64)
    pair[0, 0, 2] = pair[0, 1, 0] = 32_280

    def fails(pairs, _):
        first, second = pairs[:, 0, 0, 0, 2], pairs[:, 0, 0, 1, 0]
        return (first == second) & (first >= 26_755)

    budget = Budget(calls=60)
    found = minimise(Stream(pair[None], np.zeros(1, np.int64)), fails, budget)
    assert found.pairs[0, 0, 0, 2] == found.pairs[0, 0, 1, 0] == 26_755 and budget.calls
