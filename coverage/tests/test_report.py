from html.parser import HTMLParser
from typing import Any

import numpy as np

from triaxis.coverage.counts import Counts, CoverageDatabase
from triaxis.coverage.cover_model import CoverItem, CoverModel, Coverpoint, Exclusion, Kind
from triaxis.coverage.html import write_page
from triaxis.coverage.report import percent, report

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
    wanted = {"<small>", "medium", "large", "huge", "vast", "dull & long", "none is that large", "missing"}
    assert wanted | {"1 of 3", "tests/b", "1 of 3 bins in 1 models, 33.33 %"} <= set(reader.texts)
    assert all(key not in ("src", "action") for _, key, _ in reader.attributes)
    assert all(value.startswith("#") for _, key, value in reader.attributes if key == "href")
    assert not [a for a in reader.attributes if a[0] in ("script", "link", "img", "iframe")]
    assert [p.name for p in tmp_path.iterdir()] == ["page.html"]


def test_the_page_shows_an_illegal_hit(tmp_path):
    for last, shown in ((3, False), (4, True)):
        reader = read_page(tmp_path / "page.html", counted(0, 0, 1, 1, 2, 2, last))
        assert ("vast: 1 hits" in reader.texts) == shown
