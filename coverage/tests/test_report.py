from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from triaxis.coverage.counts import Counts
from triaxis.coverage.cover_model import CoverItem, CoverModel, Coverpoint, Exclusion, Kind
from triaxis.coverage.database import CoverageDatabase
from triaxis.coverage.page import write_page
from triaxis.coverage.report import percent, report
from triaxis.coverage.terminal import coverage_lines, summary_line
from triaxis.golden.errors import InputError

SIZES = Coverpoint[Any]("size", ("<small>", "medium", "large", "huge", "vast"), lambda s: s.astype(np.uint8))
DULL = Exclusion(Kind.IGNORE, "dull & long", "tests/a", lambda size: size == 3)
NEVER = Exclusion(Kind.ILLEGAL, "none is that large", "tests/b", lambda size: size == 4)
MODEL = CoverModel("sizes", (CoverItem("size", "how large", (SIZES,), (DULL, NEVER), at_least=2),))


def counted(*codes):
    counts = Counts.empty(MODEL)
    counts.sample(MODEL, np.array(codes, np.int64))
    return counts


def test_a_goal_is_met_by_enough_hits_and_exclusions_do_not_count():
    (item,) = report(MODEL, counted(0, 0, 1, 3)).items
    assert (item.hit, item.total, item.missing) == (1, 3, ("medium", "large"))
    assert [(e.exclusion, e.bins, e.hits) for e in item.excluded] == [(DULL, 1, 1), (NEVER, 1, 0)]
    assert not item.complete and not item.illegal_hits


def test_complete_means_all_goals_and_nothing_illegal():
    everything = [0, 0, 1, 1, 2, 2]
    assert report(MODEL, counted(*everything)).complete
    assert not report(MODEL, counted(*everything[1:])).complete
    wrong = report(MODEL, counted(*everything, 4))
    assert not wrong.complete and wrong.hit == wrong.total
    assert wrong.problems == ["coverage sizes, size: illegal bin vast hit 1 times: none is that large"]
    assert report(MODEL, counted(0)).problems == [
        "coverage sizes, size: 0 of 3 bins hit, missing first: <small>"
    ]


def test_100_percent_means_all():
    missing, done = report(MODEL, counted(0, 0, 1, 1)), report(MODEL, counted(0, 0, 1, 1, 2, 2))
    assert percent([missing]) == 66.66
    assert percent([done] * 9999 + [missing]) == 99.99
    assert percent([done]) == 100.0
    assert percent([]) == 0.0


def test_lines_for_terminals():
    lines = coverage_lines(report(MODEL, counted(1, 1, 4)))
    assert lines[0] == "sizes: 1 of 3 bins in 1 models, 33.33 %"
    assert lines[1].split() == ["size", "1", "of", "3", "(2", "excluded)", "missing:", "<small>,", "large"]
    assert lines[2] == "    ILLEGAL vast: hit 1 times; none is that large"
    done = report(MODEL, counted(0, 0, 1, 1, 2, 2))
    assert len(coverage_lines(done, everything=False)) == 1
    assert summary_line([done, done]) == "6 of 6 bins in 2 models, 100.00 %"


class Reader(HTMLParser):
    """Collects text and attributes of a page."""

    def __init__(self):
        super().__init__()
        self.texts, self.attributes = [], []

    def handle_starttag(self, tag, attrs):
        self.attributes += [(tag, *pair) for pair in attrs]

    def handle_data(self, data):
        self.texts.append(data.strip())


def read_page(path, *counts):
    database = CoverageDatabase([MODEL])
    for one in counts:
        database.add(one)
    write_page(path, database)
    reader = Reader()
    reader.feed(path.read_text())
    return reader


def test_the_page_lists_every_bin_with_reasons_and_needs_no_network(tmp_path):
    reader = read_page(tmp_path / "page.html", counted(0, 0, 1, 3))
    for text in (
        "<small>",
        "medium",
        "large",
        "huge",
        "vast",
        "dull & long",
        "none is that large",
        "missing",
    ):
        assert text in reader.texts, text
    assert "1 of 3" in reader.texts and "tests/b" in reader.texts
    assert all(key not in ("src", "action") for _, key, _ in reader.attributes)
    assert all(value.startswith("#") for _, key, value in reader.attributes if key == "href")
    assert not [a for a in reader.attributes if a[0] in ("script", "link", "img", "iframe")]
    assert [p.name for p in tmp_path.iterdir()] == ["page.html"]


def test_the_page_shows_an_illegal_hit(tmp_path):
    clean = read_page(tmp_path / "page.html", counted(0, 0, 1, 1, 2, 2, 3))
    assert "vast: 1 hits" not in clean.texts
    wrong = read_page(tmp_path / "page.html", counted(0, 0, 1, 1, 2, 2, 4))
    assert "vast: 1 hits" in wrong.texts


def test_a_page_that_cannot_be_written_is_one_clear_line(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot make this folder"):
        write_page(tmp_path / "file" / "page.html", CoverageDatabase([MODEL]))
