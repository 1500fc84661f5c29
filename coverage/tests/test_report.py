"""What is reported of counts: goals, exclusions, illegal hits; the page that lists every bin."""

import re
from html import escape
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
EVERYTHING = [0, 0, 1, 1, 2, 2]


def counted(*codes):
    counts = Counts.empty(MODEL)
    counts.sample(MODEL, np.array(codes, np.int64))
    return counts


def test_complete_means_all_goals_and_nothing_illegal():
    (item,) = report(MODEL, counted(0, 0, 1, 3)).items
    assert (item.hit, item.total, item.missing) == (1, 3, ("medium", "large"))
    assert [(e.exclusion, e.bins, e.hits) for e in item.excluded] == [(DULL, 1, 1), (NEVER, 1, 0)]
    done, missing = report(MODEL, counted(*EVERYTHING)), report(MODEL, counted(*EVERYTHING[:-1]))
    assert done.complete and not missing.complete
    wrong = report(MODEL, counted(*EVERYTHING, 4))
    assert not wrong.complete and wrong.hit == wrong.total
    assert wrong.problems == ["coverage sizes, size: illegal bin vast hit 1 times: none is that large"]
    assert missing.problems == ["coverage sizes, size: 2 of 3 bins hit, missing first: large"]
    # 100 per cent mean all.
    assert percent([done] * 9999 + [missing]) == 99.99
    assert (percent([done]), percent([])) == (100.0, 0.0)


def test_the_page_lists_every_bin_with_reasons_and_needs_no_network(tmp_path):
    database = CoverageDatabase([MODEL])
    database.add(counted(0, 0, 1, 3, 4))
    write_page(tmp_path / "page.html", database)
    page = (tmp_path / "page.html").read_text()
    wanted = ("<small>", "medium", "large", "huge", "dull & long", "none is that large", "missing")
    for text in (*wanted, "1 of 3", "tests/b", "vast: 1 hits"):
        assert escape(text) in page
    assert not re.search(r'<(script|link|img|iframe)\b|\b(src|action)=|\bhref="[^#]', page)
