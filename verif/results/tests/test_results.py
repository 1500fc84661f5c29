"""The database of results and its pages: what is added, once, what is shown of it, and to whom."""

import json
import os
import re
import sqlite3
import threading
import urllib.error
import urllib.request
from concurrent.futures import ThreadPoolExecutor

import pytest

from triaxis.golden.errors import InputError
from triaxis.host.cli import DONE, main
from triaxis.host.tests.browser import CHROMIUM, Browser
from triaxis.sim.build import rtl_hash
from triaxis.sim.evidence import read_evidence, write_evidence
from triaxis.sim.paths import DUT
from triaxis.verif.commands import results as command
from triaxis.verif.regress.one_job import SOURCES
from triaxis.verif.regress.records import State, write_record, write_state
from triaxis.verif.regress.tests.test_regression_parts import FAILED, PASSED
from triaxis.verif.results import pages, serving
from triaxis.verif.results.database import add_evidence, export_parquet, keep, opened
from triaxis.verif.results.pages import INDEX, names, page, source_page, write_pages
from triaxis.verif.results.serving import server
from triaxis.verif.signoff.gate import SOURCES as SIGNED
from triaxis.verif.signoff.tests.signoff_evidence import good_content

FILE = "dut/core/triaxis_sum.sv"


def run(seed=1, passed=True, **changes):
    said = None if passed else "ERROR tag N where N was due"
    return {
        "test": "RandomTest", "config": "w16_m0", "agent": "burst", "seed": seed, "pairs": 100,
        "key": str(seed), "passed": passed, "silent": False, "seconds": 2.0, "pairs_checked": 100,
        "bucket": said, "log": "/elsewhere/run.log",
        "replay": f"triaxis sim RandomTest --seed {seed}", **changes,
    }  # fmt: skip


def regression(folder, number, *runs, **changes):
    """Write what the regression of some day left."""
    runs = runs or (run(),)
    content = {
        "passed": all(one["passed"] for one in runs), "problems": [], "summary": "some runs", "seconds": 9.0,
        "command": "triaxis regress run nightly", "seed": 1, "regression": "nightly",
        "seeds_multiplied_by": 1.0,
        "begun": f"2026-01-{number:02}T01:00:00+00:00", "finished": f"2026-01-{number:02}T02:00:00+00:00",
        "pairs_checked": 100 * len(runs), "runs": runs, "flaky": [],
        "coverage": {"percent": 99.5, "models": {"core_w16_m0": {"claim": {"hit": 32, "total": 33}}}},
        "git_commit": "0123abcd", **changes,
    }  # fmt: skip
    return write_evidence(folder / f"results-{number}.json", content, SOURCES)


def mutation(folder, number, **changes):
    """Write what a run over one mutant left."""
    mutant = {
        "id": "triaxis_sum/minus/1", "place": f"{FILE}:3", "original": "a + b", "changed": "a - b",
        "fate": "killed", "by": "run", "test": "MixedTest", "target": "w8_m8", **changes,
    }  # fmt: skip
    content = {
        "passed": True, "problems": [], "summary": "one killed", "seconds": float(number), "seed": 1,
        "command": "triaxis prove mutate --seed 1", "mutants": [mutant],
        "finished": f"2026-02-{number:02}T02:00:00+00:00",
    }  # fmt: skip
    return write_evidence(folder / f"mutation-{number}.json", content, SOURCES)


@pytest.fixture
def database(tmp_path):
    """Two nights, the second with a failure, a sign-off, and the mutants."""
    path = tmp_path / "history" / "results.sqlite"
    slow = run(3, agent="pin", seconds=50.0)
    first = regression(tmp_path, 1, run(1), run(2), slow)
    better = {"percent": 100.0, "models": {"core_w16_m0": {"claim": {"hit": 33, "total": 33}}}}
    second = regression(
        tmp_path,
        2,
        run(1, seconds=2.25),
        run(2, passed=False, seconds=2.5),
        coverage=better,
        problems=["<one> failed"],
    )
    for file in (first, second, signed(tmp_path), mutation(tmp_path, 1)):
        assert add_evidence(file, path)
    return path


def signed(folder):
    return write_evidence(folder / "signoff.json", good_content(), SIGNED)


def power(folder, number):
    """Write what tests noticed of two mutants, one of them nothing."""
    content = {
        "passed": True, "problems": [], "summary": "one noticed", "seconds": 1.0, "seed": 1, "one_in": 10,
        "command": "triaxis prove power", "finished": f"2026-03-{number:02}T02:00:00+00:00",
        "power": [{
            "model": "w8_m8", "tests": {
                "RandomTest": {"alone": 0, "in_fewest": True}, "TinyTest": {"alone": 0, "in_fewest": False},
            },
            "mutants": {"triaxis_sum/minus/1": ["RandomTest", "TinyTest"], "triaxis_sum/plus/2": []},
        }],
    }  # fmt: skip
    return write_evidence(folder / f"power-{number}.json", content, SOURCES)


def rows(path, query):
    with opened(path) as connection:
        return [tuple(row) for row in connection.execute(query)]


def test_what_is_added_counts_once_and_is_what_the_files_say(database, tmp_path):
    kinds = rows(database, "SELECT kind, passed, pairs, failures, coverage_percent FROM result ORDER BY id")
    assert kinds == [
        ("nightly", 1, 300, 0, 99.5), ("nightly", 0, 200, 1, 100.0), ("sign-off", 1, 100_000_000, 0, 100.0),
        ("mutation", 1, None, None, None),
    ]  # fmt: skip
    assert rows(database, "SELECT DISTINCT git_commit FROM result WHERE kind = 'nightly'") == [("0123abcd",)]
    # Killed after it was added, and continued: it ended later, and is the same.
    again = regression(tmp_path, 1, run(1), run(2), finished="2026-01-01T03:00:00+00:00")
    assert not add_evidence(again, database)
    assert add_evidence(regression(tmp_path, 1, seeds_multiplied_by=5.0), database)
    assert rows(database, "SELECT kind FROM result ORDER BY id DESC LIMIT 1") == [("nightly x 5",)]
    assert rows(database, "SELECT said FROM problem") == [("<one> failed",)]
    assert rows(database, "SELECT test, mutants, file FROM kills") == [("MixedTest", 1, FILE)]
    runs = "SELECT runs, failed, pairs, mean_seconds, most_seconds FROM test WHERE test = 'RandomTest'"
    assert sorted(rows(database, runs)) == [(1, 0, 100, 50.0, 50.0), (5, 1, 500, 2.15, 2.5)]


def test_an_empty_file_is_there_and_is_no_evidence(tmp_path):
    (tmp_path / "results.json").touch()
    with pytest.raises(InputError, match="not readable as evidence"):
        add_evidence(tmp_path / "results.json", tmp_path / "results.sqlite")


def test_of_a_sign_offs_runs_it_says_as_much_as_of_others(tmp_path):
    path = tmp_path / "results.sqlite"
    for number, errors in enumerate(
        (["no error line: the simulator ended early"], ["%Error: Rule 7 failed"])
    ):
        content = good_content()
        content["date"] = f"2026-01-0{number + 1}T00:00:00+00:00"
        said = [
            "FAILED VolumeTest, w16_m0, seed 1",
            *(f"  {error}" for error in errors),
            "  log:    ERROR.log",
        ]
        content["parts"]["simulation"]["runs"][0] |= {"passed": False, "counts": None, "explanation": said}
        add_evidence(write_evidence(tmp_path / "signoff.json", content, SIGNED), path)
    # What was killed says nothing of its seed, so that it is not flaky where it passes another time.
    assert rows(path, "SELECT silent, said FROM run WHERE NOT passed ORDER BY result") == [
        (1, "no error line: the simulator ended early"), (0, "%Error: Rule N failed"),
    ]  # fmt: skip


def test_seeds_that_both_passed_and_failed_on_the_same_sources_are_flaky(database, tmp_path):
    flaky = "SELECT test, seed, runs, failed FROM flaky"
    assert rows(database, flaky) == [("RandomTest", 2, 2, 1)]
    # On other sources it says nothing.
    add_evidence(regression(tmp_path, 3, run(1, passed=False), rtl_hash="0" * 64), database)
    assert rows(database, flaky) == [("RandomTest", 2, 2, 1)]
    add_evidence(regression(tmp_path, 4, run(7), flaky=["7"]), database)
    assert ("RandomTest", 7, 1, 0) in rows(database, flaky)


def test_of_one_state_the_newest_mutants_are_kept_whenever_they_are_added(database, tmp_path):
    add_evidence(mutation(tmp_path, 3, test="VolumeTest"), database)
    add_evidence(mutation(tmp_path, 2, test="RandomTest"), database)
    assert rows(database, "SELECT test FROM mutant") == [("VolumeTest",)]
    assert rows(database, "SELECT count(*) FROM result WHERE kind = 'mutation'") == [(3,)]
    assert "They are not kept of both" in (page("compare-4-5.html", database) or "")


def test_of_each_mutant_the_page_says_which_tests_notice_it(database, tmp_path):
    for number in (1, 2):
        add_evidence(power(tmp_path, number), database)
    of_last = "FROM noticed WHERE result = (SELECT max(id) FROM result)"
    assert rows(database, f"SELECT count(*) {of_last}") == rows(database, "SELECT count(*) FROM noticed")
    assert rows(database, "SELECT test, tried, noticed, in_fewest FROM power LIMIT 2") == [
        ("RandomTest", 2, 1, 1), ("TinyTest", 2, 1, 0),
    ]  # fmt: skip
    text = page("result-6.html", database) or ""
    assert "RandomTest, TinyTest" in text and "none of these tests" in text


def test_a_run_that_was_killed_says_nothing_of_its_seed(database, tmp_path):
    add_evidence(regression(tmp_path, 5, run(1, passed=False, silent=True)), database)
    assert rows(database, "SELECT seed FROM flaky") == [(2,)]


def test_what_fails_comes_to_light_however_little_it_checked(tmp_path):
    path = tmp_path / "results.sqlite"
    lost = {"percent": None, "models": {}}
    new = run(20260102, passed=False)
    died = run(1, passed=False, pairs_checked=None)
    add_evidence(regression(tmp_path, 1, run(1), run(20260101)), path)
    add_evidence(regression(tmp_path, 2, died, new, coverage=lost), path)
    text = page("compare-1-2.html", path) or ""
    assert text.count("<td>RandomTest<td>w16_m0, burst") == 3
    assert text.count(f"{new['replay']}<") == 1 and text.count(f"{died['replay']}<") == 1
    assert "32<" in text and "not measured" in text and "20,260" not in text


def test_what_was_not_measured_is_null_and_exceptions_are_shown(tmp_path):
    path = tmp_path / "results.sqlite"
    content = json.loads(json.dumps(good_content()))
    content["parts"]["simulation"] = {"absent": "it was not there"}
    content["exceptions"] = ["mutants: 9 as recorded of this very state, 1 more played again"]
    for name in ("pairs_checked", "functional_coverage"):
        content["figures"][name] = None
    add_evidence(write_evidence(tmp_path / "signoff.json", content, SIGNED), path)
    assert rows(path, "SELECT pairs, failures, coverage_percent FROM result") == [(None, None, None)]
    assert "9 as recorded of this very state" in (page("result-1.html", path) or "")


def test_a_log_that_a_later_run_wrote_is_not_taken_for_its_own(tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "BUILD", tmp_path)
    monkeypatch.setattr(pages, "FOLDER", tmp_path / "results")
    log = tmp_path / "run.log"
    log.write_text("")
    path = tmp_path / "results.sqlite"
    add_evidence(regression(tmp_path, 1, run(log=str(log))), path)
    assert "of a later run now" in (page("result-1.html", path) or "")
    os.utime(log, (1.7e9, 1.7e9))
    assert "<a href='../run.log'>log</a>" in (page("result-1.html", path) or "")


def test_only_pages_that_are_there_are_linked(tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "_NEWEST", 3)
    path = tmp_path / "results.sqlite"
    for number in range(1, 6):
        add_evidence(regression(tmp_path, number), path)
    add_evidence(mutation(tmp_path, 1), path)
    with opened(path) as connection:
        connection.execute("UPDATE result SET rtl_hash = 'another' WHERE kind = 'mutation'")
    made = {file.name: file.read_text() for file in write_pages(tmp_path / "pages", path).parent.iterdir()}
    assert set(made) == set(names(path)) and len(made) == 5
    for name, text in made.items():
        assert set(re.findall(r"href='([^']+)'", text)) <= set(made), name


@pytest.mark.parametrize("name", ["regression", "seed", "runs", "coverage", "begun"])
def test_what_is_no_whole_evidence_is_refused_and_leaves_nothing(tmp_path, name):
    content = read_evidence(regression(tmp_path, 1)) or {}
    del content[name]
    broken = write_evidence(tmp_path / "broken.json", content, SOURCES)
    path = tmp_path / "results.sqlite"
    with pytest.raises(InputError, match=r"broken.json: must be the whole result"):
        add_evidence(broken, path)
    with pytest.raises(InputError, match=r"none.json: no such file: name results.json"):
        add_evidence(tmp_path / "none.json", path)
    assert rows(path, "SELECT * FROM result") == []


def test_a_row_that_does_not_fit_takes_its_result_along(tmp_path):
    file = regression(tmp_path, 1, run(1), run(2, seconds=None))
    path = tmp_path / "results.sqlite"
    with pytest.raises(
        InputError, match=r"results-1.json: must be .*: NOT NULL constraint failed: run.seconds"
    ):
        add_evidence(file, path)
    assert rows(path, "SELECT * FROM result") == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"passed": "no"}, "passed: 'no': must be true or false"),
        ({"coverage": {"percent": float("inf"), "models": {}}}, "coverage_percent: inf: must be a number"),
        ({"pairs_checked": -5}, "pairs: -5: must be a number that is not negative"),
        ({"problems": "abc"}, "problems: must be a list"),
        ({"runs": [run(1, seconds="x")]}, "seconds: 'x': must be a number"),
    ],
)
def test_what_no_page_could_show_is_refused(tmp_path, change, said):
    content = {**(read_evidence(regression(tmp_path, 1)) or {}), **change}
    with pytest.raises(InputError, match=said):
        add_evidence(write_evidence(tmp_path / "broken.json", content, SOURCES), tmp_path / "results.sqlite")


def test_a_damaged_database_is_told_and_no_runs_verdict(tmp_path, capsys):
    path = tmp_path / "results.sqlite"
    path.write_text("this is no database, and long enough to be taken for one" * 9)
    with pytest.raises(InputError, match=r"results.sqlite: file is not a database: move it away"):
        page(INDEX, path)
    keep(regression(tmp_path, 1), path)
    assert "not among `triaxis results`" in capsys.readouterr().err


def test_pages_show_what_was_found_and_need_nothing_else(database, tmp_path):
    index = write_pages(tmp_path / "pages", database)
    made = {path.name: path.read_text() for path in index.parent.iterdir()}
    assert sorted(made) == sorted(names(database))
    for name, text in made.items():
        # Only to pages that are there.
        assert set(re.findall(r"href='([^']+)'", text)) <= set(made), name
        assert not re.findall(r"""(?:src|href)=["']?(?:https?:)?//""", text)
    assert made[INDEX].count("<svg") == 4 and "Over time: nightly" in made[INDEX]
    slowest = made[INDEX].partition("the slowest first")[2]
    assert slowest.index(">50.0") < slowest.index(">2.2")
    second = made["result-2.html"]
    assert "FAILED" in second and "&lt;one&gt; failed" in second and "ERROR tag N where N was due" in second
    assert "compare-1-2.html" in second and "<code>/elsewhere/run.log</code>" in second
    differs = made["compare-1-2.html"]
    assert "FAILS" in differs and differs.count("triaxis sim RandomTest --seed 2") == 1
    assert "Only in 1: RandomTest in w16_m0, pin." in differs and "Only in 2" not in differs
    assert re.search(r"claim</span><td[^>]*>32<td[^>]*>33<td[^>]*>33<td[^>]*>33", differs)
    assert page("compare-1-9.html", database) is page("../x.html", database) is None
    with pytest.raises(InputError, match=r"compare-1-9.html: there are no such results"):
        write_pages(tmp_path / "pages", database, ["compare-1-9.html"])


def test_each_line_has_its_mutants_and_what_is_open(database, tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "CODE_COVERAGE", tmp_path / "none.json")
    text = page(source_page(FILE), database) or ""
    line = re.search(r"id='3'>.*?</div>", text, re.DOTALL)
    assert line and "1 mutant, 1 killed" in line[0] and "by MixedTest in w8_m8" in line[0]
    assert text.count("role=listitem") == len((DUT.parent / FILE).read_text().splitlines())
    assert "was not measured" in text
    bins = [{"file": FILE, "line": 3, "kind": "branch", "what": "else", "instance": "sum", "model": "w8"}]
    content = {
        "passed": True, "problems": [], "summary": "s", "seconds": 1.0, "command": "c", "uncovered": bins,
    }  # fmt: skip
    monkeypatch.setattr(pages, "CODE_COVERAGE", write_evidence(tmp_path / "code.json", content, SOURCES))
    assert "not covered: branch else, sum, w8" in (page(source_page(FILE), database) or "")
    # Of another RTL its lines are others.
    with opened(database) as connection:
        connection.execute("UPDATE result SET rtl_hash = 'another'")
    assert page(source_page(FILE), database) is None and rtl_hash() != "another"


def test_a_regression_that_runs_is_shown_with_its_builds(database, tmp_path, monkeypatch):
    folder = tmp_path / "regress" / "smoke"
    monkeypatch.setattr(pages, "REGRESSIONS", folder.parent)
    monkeypatch.setattr(pages, "ROOT", tmp_path)
    state = State(1, 1.0, "sources", (10.0,))
    write_state(folder, state)
    write_record(folder, PASSED)
    write_record(folder, FAILED)
    for build, said in (("w8_m8", "BUILD DONE"), ("w16_m0", "compiling"), ("w4_m0", "%Error")):
        log = folder / "dvsim" / build / "latest" / "build.log"
        log.parent.mkdir(parents=True)
        log.write_text(said)
    (folder / "builds").mkdir()
    (folder / "builds" / "w4_m0.error").write_text("no")
    text = page(INDEX, database) or ""
    assert "smoke: 0 runs passed" in text and ">1</span> failed" in text
    for build, said in (("w8_m8", "built"), ("w16_m0", "building"), ("w4_m0", "failed")):
        assert re.search(rf"{build}: <span class='\w*'>{said}</span>", text), (build, text)
    write_state(folder, State(1, 1.0, "sources", (10.0,), finished=True))
    assert "Running now" not in (page(INDEX, database) or "")


def test_tables_are_exported_as_they_are(database, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed: no Parquet is written")
    written = {path.stem: parquet.read_table(path).to_pylist() for path in export_parquet(tmp_path, database)}
    with opened(database) as connection:
        for name, found in written.items():
            assert found == [dict(row) for row in connection.execute(f"SELECT * FROM {name}")]
    assert len(written["run"]) == 6 and len(written) == 10


def test_the_command_adds_compares_and_says_where(tmp_path, monkeypatch, capsys):
    path = tmp_path / "results.sqlite"
    monkeypatch.setattr(command, "add_evidence", lambda file: add_evidence(file, path))
    monkeypatch.setattr(command, "write_pages", lambda also: write_pages(tmp_path / "pages", path, also))
    files = [str(regression(tmp_path, number)) for number in (1, 2)]
    assert main(["results", "--add", *files, "--compare", "2", "1"]) == DONE
    assert capsys.readouterr().out.count(": added\n") == 2
    assert (tmp_path / "pages" / "compare-2-1.html").is_file()
    assert main(["results", "--add", files[0]]) == DONE
    assert "is there already" in capsys.readouterr().out


@pytest.fixture
def address(database):
    with server(0, database) as serving:
        threading.Thread(target=serving.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{serving.server_address[1]}"
        serving.shutdown()


def status(address, **headers):
    try:
        with urllib.request.urlopen(urllib.request.Request(address, headers=headers)) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


def test_pages_and_logs_are_served_and_nothing_else(address, database, tmp_path, monkeypatch):
    assert status(address) == status(f"{address}/results/result-1.html") == 200
    assert status(address, Host="triaxis.example") == 403
    monkeypatch.setattr(serving, "BUILD", tmp_path)
    (tmp_path / "smoke").mkdir()
    for name in ("smoke/run.log", "run.json"):
        (tmp_path / name).write_text("said")
    (tmp_path / "out.log").symlink_to("/etc/passwd")
    assert status(f"{address}/smoke/run.log") == 200
    for path in (
        "run.json",
        "out.log",
        "%00.log",
        "results/result-99999999999999999999.html",
        "smoke/none.log",
        "README.md",
        "build/results/../../README.md",
        "build/%2e%2e/README.md",
        "build/none.log",
        "etc",
    ):
        assert status(f"{address}/{path}") == 404, path
    with pytest.raises(InputError, match=r"--serve .*: name another"):
        server(int(address.rsplit(":", 1)[1]), database)


@pytest.mark.simulator
@pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed: no browser shows the pages")
def test_a_browser_sorts_and_filters_by_keyboard_and_reads_the_roles(address, tmp_path):
    browser = Browser(tmp_path, f"{address}/results/result-2.html")
    table = "[...document.querySelectorAll('table')].find(one => one.caption?.textContent === 'runs')"

    def seeds():
        return browser.value(
            f"[...{table}.tBodies[0].rows].filter(r => !r.hidden).map(r => r.cells[4].textContent).join()"
        )

    def press(key, code, **more):
        for kind in ("keyDown", "keyUp"):
            browser.ask(
                "Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code, **more
            )

    try:
        browser.until(f"{table}?.rows.length", 3)
        assert seeds() == "2,1"
        browser.value(f"{table}.tHead.rows[0].cells[4].querySelector('button').focus()")
        press("Enter", 13, text="\r")
        browser.until(f"{table}.tHead.rows[0].cells[4].getAttribute('aria-sort')", "ascending")
        assert seeds() == "1,2"
        press("Enter", 13, text="\r")
        assert seeds() == "2,1"
        # 2.25 and 2.5: as numbers.
        browser.value(f"{table}.tHead.rows[0].cells[6].querySelector('button').click()")
        assert seeds() == "1,2"
        browser.value(f"{table}.tHead.rows[0].cells[6].querySelector('button').click()")
        assert seeds() == "2,1"
        field = f"{table}.previousElementSibling.previousElementSibling.querySelector('input')"
        browser.value(f"{field}.focus()")
        browser.ask("Input.insertText", text="failed")
        assert seeds() == "2"
        told = f"{table}.previousElementSibling"
        assert browser.value(f"{told}.textContent") == " 1 of 2 rows"
        assert browser.value(f"{told}.getAttribute('role')") == "status"
        nodes = browser.ask("Accessibility.getFullAXTree")["nodes"]
        roles = {
            (node["role"]["value"], node.get("name", {}).get("value")) for node in nodes if "role" in node
        }
        # What a screen reader tells of them.
        wanted = {
            ("main", ""), ("table", "runs"), ("button", "seed"), ("searchbox", "Only rows of runs with"),
            ("heading", "nightly 2"), ("link", "what differs from it"),
        }  # fmt: skip
        assert wanted <= {(role, (name or "").strip()) for role, name in roles}, roles
    finally:
        browser.end()


def test_a_database_of_another_version_is_refused(database):
    with sqlite3.connect(database) as connection:
        connection.execute("PRAGMA user_version = 99")
    with pytest.raises(InputError, match=r"results.sqlite: is of another version: move it away"):
        page(INDEX, database)


def test_a_database_of_the_version_before_keeps_what_it_holds(database, tmp_path):
    with sqlite3.connect(database) as connection:
        connection.execute("DROP TABLE power")
        connection.execute("DROP TABLE noticed")
        connection.execute("PRAGMA user_version = 1")
    before = rows(database, "SELECT * FROM result")
    assert add_evidence(power(tmp_path, 1), database)
    assert rows(database, "SELECT * FROM result")[:-1] == before
    assert rows(database, "SELECT count(*) FROM power") == [(2,)]


@pytest.mark.long
def test_many_may_open_and_add_at_a_time(tmp_path):
    path = tmp_path / "results.sqlite"
    files = [regression(tmp_path, number) for number in range(1, 13)]
    with ThreadPoolExecutor(6) as pool:
        assert all(pool.map(lambda file: add_evidence(file, path), files))
        assert len(list(pool.map(lambda _: page(INDEX, path), range(12)))) == 12
    assert rows(path, "SELECT count(*) FROM result") == [(12,)]
