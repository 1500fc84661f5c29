"""TriTest: sets and their proofs, the stand-alone checker, the protocol, scores."""

import gzip
import hashlib
import io
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from triaxis.bench.peers.peer import Peer, Question, present
from triaxis.bench.tritest import command, recheck
from triaxis.bench.tritest.cases import line_of, write_set
from triaxis.bench.tritest.libraries import LIBRARIES, OURS, answer
from triaxis.bench.tritest.recheck import NUMBERS, SetError, case_of, families_of, fault_of
from triaxis.bench.tritest.scoring import KINDS, read_set, score
from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.host.tests.published import read_published

# Two triangles, the second 1/2 above the first where they are closest.
APART = [[[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[1, 1, 1], [1, 1, 5], [3, 2, 5]]]
PAIRS = 16


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("set")
    return folder, write_set(folder, PAIRS, 7, lambda _: None)


@pytest.fixture
def asked(made):
    return read_set(made[0])


def python(*lines):
    return [sys.executable, "-c", "\n".join(("import sys", *lines))]


def test_a_set_is_proven_by_python_alone(made):
    folder, families = made
    # -I -S: neither our package nor any other.
    checker = [sys.executable, "-I", "-S", recheck.__file__, str(folder)]
    ran = subprocess.run(checker, capture_output=True, text=True, check=True)
    assert ran.stdout == f"PASSED: {PAIRS * len(families):,} pairs proven, 0 not\n"
    assert len(Path(recheck.__file__).read_text().splitlines()) < 300


def test_the_same_seed_gives_the_same_bytes(made, tmp_path):
    folder, _ = made
    write_set(tmp_path, PAIRS, 7, lambda _: None)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == {
        p.name: p.read_bytes() for p in folder.iterdir()
    }


def test_distances_are_those_of_the_bulk_checker(asked):
    """Within a whole margin exactly where the set's distance is at most that."""
    compared = 0
    for one in asked:
        pairs = np.array([question.split() for question in one.questions], np.int64).reshape(-1, 2, 3, 3)
        fit = np.abs(pairs).max((1, 2, 3)) < 1 << 31
        near = bulk_verdicts(pairs[fit], np.zeros(fit.sum(), np.int64))["near"]
        assert near.tolist() == np.array(one.collide)[fit].tolist(), one.family.name
        compared += len(near)
    assert compared > PAIRS * 20


def test_a_set_has_all_kinds_and_both_verdicts(asked):
    kinds = {(kind, collides) for one in asked for kind, collides in zip(one.kinds, one.collide, strict=True)}
    assert kinds == {(kind, collides) for kind in KINDS for collides in (True, False)}


def test_each_number_of_a_proof_counts():
    numbers = list(map(int, line_of(APART).split()))
    assert numbers[18:20] == [1, 1] and len(numbers) == NUMBERS
    assert fault_of(case_of(" ".join(map(str, numbers)))) is None
    for place, value, why in (
        (18, 2, "axis"), (19, 2, "further apart"), (18, 0, "further apart"), (19, 0, "lowest terms"),
        (18, -1, "lowest terms"), (20, -1, "weights"), (28, 0, "axis"), (28, -numbers[28], "axis"),
        (11, 2, "further apart"), (11, 0, "axis"), (0, 1 << 54, "in size"),
    ):  # fmt: skip
        changed = [*numbers[:place], value, *numbers[place + 1 :]]
        assert why in (fault_of(case_of(" ".join(map(str, changed)))) or ""), (place, value)
    halved = [*numbers[:18], 2, 2, *numbers[20:]]
    assert "lowest terms" in (fault_of(case_of(" ".join(map(str, halved)))) or "")
    good = " ".join(map(str, numbers))
    broken = "1 2 3", "x " * NUMBERS, "+" + good, good.replace(" ", "  "), good.replace("4", "1_0")
    for line in (*broken, good + "0" * 4300):
        with pytest.raises(SetError):
            case_of(line)


def copied(made, folder):
    for path in made[0].iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    return families_of(folder)[0]


def test_a_set_that_was_changed_is_noticed(made, tmp_path, capsys):
    family = copied(made, tmp_path)
    path, manifest = tmp_path / family.file, tmp_path / "set.json"
    lines = gzip.decompress(path.read_bytes()).decode().splitlines()
    # A wrong claim, with the right hash: by its number.
    numbers = lines[3].split()
    numbers[18] = str(int(numbers[18]) + int(numbers[19]))
    path.write_bytes(gzip.compress("\n".join([*lines[:3], " ".join(numbers), *lines[4:], ""]).encode()))
    told = read_published(manifest, "triangles")
    told["families"][0]["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
    manifest.write_text(json.dumps(told))
    assert main(["tritest", "recheck", str(tmp_path)]) == 1
    assert f"{family.name}:3: " in capsys.readouterr().out
    with pytest.raises(InputError, match=f"{family.name}:3: "):
        read_set(tmp_path)
    # Another format, no families, fewer pairs than it says, another file than it has the hash of.
    for changes, why in (
        ({"format": 2}, "format 2"),
        ({"families": None}, "not a TriTest set"),
        ({"format": True}, "format True"),
        ({"families": told["families"][:1] * 2}, "not a TriTest set"),
        ({"families": [{**told["families"][1], "name": "../outside"}]}, "not a TriTest set"),
        ({"families": [{**told["families"][1], "pairs": float(PAIRS)}]}, "not a TriTest set"),
        ({"families": [{**told["families"][1], "pairs": PAIRS + 1}]}, f"set.json says {PAIRS + 1}"),
        ({"families": [{**told["families"][1], "sha256": "0" * 64}]}, "hash"),
    ):
        manifest.write_text(json.dumps({**told, **changes}))
        assert main(["tritest", "recheck", str(tmp_path)]) == 2
        assert why in capsys.readouterr().err
    assert main(["tritest", "recheck", str(tmp_path / "none")]) == 2
    # What nobody writes to would be waited for for ever.
    manifest.unlink()
    os.mkfifo(manifest)
    assert main(["tritest", "recheck", str(tmp_path)]) == 2


def test_scores_of_programs(made, asked, capsys, tmp_path):
    total, colliding = PAIRS * len(asked), sum(sum(one.collide) for one in asked)
    truth = tmp_path / "truth"
    truth.write_text("".join(f"{int(one)}\n" for each in asked for one in each.collide))
    right = score(["cat", str(truth)], asked, lambda _: None)
    assert right.all_right and right.wrong == (0, 0) and sum(t.right for t in right.kinds.values()) == total
    report = tmp_path / "report.json"
    always = [*python("for line in sys.stdin: print(1)")]
    words = [
        "tritest",
        "run",
        "--command",
        f"{always[0]} -c '{always[2]}'",
        str(made[0]),
        "--json",
        str(report),
    ]
    assert main(words) == 1
    assert f"0 missed, {total - colliding:,} false alarms, 0 unanswered" in capsys.readouterr().out
    told = read_published(report, "score")
    assert sum(map(len, told["false_alarms"].values())) == total - colliding and not told["passed"]
    name, numbers = next(iter(told["false_alarms"].items()))
    assert main(["tritest", "show", f"{name}:{numbers[0]}", str(made[0])]) == 0
    assert "they are clear" in capsys.readouterr().out
    assert main(["tritest", "show", f"{name}:{PAIRS + 1}", str(made[0])]) == 2


_FROM_TRUTH = ("for line in sys.stdin:", " if line.strip() in truth: print(truth[line.strip()])")


def test_a_program_that_ends_early_is_asked_family_by_family(asked):
    """It dies of a pair of the second, and loses what it had not yet written of that."""
    worst = asked[1].questions[4]
    lines = f"for line in sys.stdin: said.append('0') if line.strip() != {worst!r} else sys.exit('boom')"
    dies = python("said = []", "try:", f" {lines}", "except SystemExit: sys.exit('boom')", "print(*said)")
    found = score(dies, asked[:4], lambda _: None)
    assert [found.families[one.family.name].unanswered for one in asked[:4]] == [0, PAIRS, 0, 0]
    assert found.ended == {asked[1].family.name: "exit code 1: boom"}
    flushed = python(
        "for line in sys.stdin:", f" if line.strip() == {worst!r}: sys.exit(1)", " print(0, flush=True)"
    )
    found = score(flushed, asked[:4], lambda _: None)
    assert [found.families[one.family.name].unanswered for one in asked[:4]] == [0, PAIRS - 4, 0, 0]
    short = score(python("print(0)"), asked[:1], lambda _: None)
    assert list(short.ended.values()) == ["1 answers to 16 pairs"] and not short.all_right
    # One that leaves an answer out is not held to the other families', shifted by one.
    truth = {q: int(c) for one in asked for q, c in zip(one.questions, one.collide, strict=True)}
    skips = python(f"truth = {truth!r}", f"del truth[{worst!r}]", *_FROM_TRUTH)
    found = score(skips, asked[:4], lambda _: None)
    assert [found.families[one.family.name].unanswered for one in asked[:4]] == [0, PAIRS, 0, 0]
    assert found.wrong == (0, 0) and found.ended == {asked[1].family.name: "15 answers to 16 pairs"}
    badly = score(python("for line in sys.stdin: print(1)", "sys.exit(3)"), asked[:2], lambda _: None)
    assert badly.ended == {asked[1].family.name: "exit code 3: "} and not badly.all_right


def test_what_is_no_answer_is_refused(asked):
    for program, why in (
        (python("for line in sys.stdin: print('yes')"), "yes: no answer"),
        (python("for line in sys.stdin: print(0, 1)"), "32 answers to 16 pairs"),
        (["/none"], "No such file"),
        # Without an end.
        (["yes", "1"], "more than 1088 bytes of answers: a line a pair is wanted"),
        (python("while True: print('x' * 99, file=sys.stderr) or print(1)"), "more than 1088 bytes"),
    ):
        with pytest.raises(InputError, match=why):
            score(program, asked[:1], lambda _: None)
    for line in ("0 " * 17, "0 0 0.5 9 0 0.5 0 9 0.5 0 0 0 9 0 0 0 9 0", "0 " * 17 + "9007199254740993"):
        with pytest.raises(InputError, match=r"^line 2: .*: must be 18 whole numbers of at most 2\^53$"):
            answer(LIBRARIES["triaxis-bulk"], io.StringIO(f"{'0 ' * 18}\n{line}\n"), io.StringIO())
    assert main(["tritest", "run", "--library", "none"]) == 2
    assert main(["tritest", "run", "--command", "'"]) == 2
    assert main(["tritest", "run", "--command", ""]) == 2


def test_a_library_that_raises_an_error_is_asked_one_by_one():
    def load(a, b):
        if (a[:, 0, 0] == 3).any():
            raise ValueError
        return Question(lambda: a[:, 0, 0] > 1)

    lines = "".join(f"{n}{' 0' * 17}\n" for n in range(5))
    out = io.StringIO()
    answer(Peer("x", "x", "x", lambda: "1", load), io.StringIO(lines), out)
    assert out.getvalue().split() == ["0", "0", "1", "?", "1"]


def test_ours_refuse_what_is_beyond_32_bits():
    bulk = next(one for one in OURS if one.name == "Triaxis bulk")
    out = io.StringIO()
    answer(bulk, io.StringIO(f"{'0 ' * 18}\n{1 << 31}{' 0' * 17}\n"), out)
    assert out.getvalue().split() == ["1", "?"]


def test_packages_tell_plain_pairs_apart():
    """Where `make peers` has installed them: pierced, and far above."""
    through = np.array([[1, 1, -1], [1, 1, 1], [2, 5, 1]])
    above = [through + np.array([0, 0, height]) for height in (4, -9)]
    there, _ = present(tuple(one for one in LIBRARIES.values() if one.distribution != "triaxis"))
    for peer, _ in there:
        pairs = [np.array(APART[0], float)] * 3, [each.astype(float) for each in (through, *above)]
        assert peer.load(*map(np.stack, pairs)).ask().tolist() == [True, False, False], peer.name


def test_a_league_needs_right_answers_of_ours(asked):
    there = [(one, "1") for one in OURS]
    zeros = score(python("for line in sys.stdin: print(0)"), asked[:2], lambda _: None)
    none = score(python("for line in sys.stdin: print('?')"), asked[:2], lambda _: None)
    found = command.league_of(asked[:2], there, {OURS[0].name: zeros, OURS[1].name: none}, [])
    problems = [problem.partition(":")[0] for problem in found.problems]
    assert problems == ["Triaxis core", "Triaxis bulk", "0 packages of others"]
    # One that answers nothing is no rival, and is told.
    silent, wrong = (replace(OURS[0], name=name, distribution="x") for name in ("a", "b"))
    scores = {OURS[0].name: zeros, OURS[1].name: zeros, silent.name: none, wrong.name: zeros}
    found = command.league_of(asked[:2], [(one, "1") for one in (silent, wrong, *OURS)], scores, [])
    assert [one["name"] for one in found.content["libraries"]][-1] == "a"
    assert "a: answers none of the pairs that float32 holds: no error told" in found.problems
