# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages of evidence and of explain, and the README, show what the records of the benches hold."""
import re
import sys

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "bench"))
import explained_tables  # noqa: E402
from evidence_tables import TABLES, text_of  # noqa: E402

from common import table  # noqa: E402


def between(text, marker):
    """What stands between the markers of a table."""
    return text.split(f"<!-- {marker} -->\n")[1].split(f"\n<!-- end of {marker} -->")[0]


@pytest.mark.parametrize("marker", TABLES)
def test_tables_are_those_of_the_records(marker):
    """Every table of a page of evidence is made of the record that it names, to the last character."""
    text = (ROOT / f"docs/evidence/{TABLES[marker][0]}.md").read_text()
    assert between(text, marker) == text_of(marker), "run bench/evidence_tables.py"


@pytest.mark.parametrize("marker", explained_tables.TABLES)
def test_explained_tables_are_those_of_the_records(marker):
    """Every measured table of a page of explain and of the README is made of a record or of the engine's constants, to the last character."""
    page, build = explained_tables.TABLES[marker]
    assert between((ROOT / f"docs/{page}.md").read_text(), marker) == table(*build()), "run bench/explained.py --tables"


@pytest.mark.parametrize("page", sorted({page for page, *_ in TABLES.values()}))
def test_pages_are_short(page):
    """A page of evidence has at most 900 words, its tables included, and opens with what it shows."""
    text = (ROOT / f"docs/evidence/{page}.md").read_text()
    assert sum(any(map(str.isalnum, word)) for word in text.split()) <= 900
    assert text.split("\n\n")[1].startswith("This page shows")


def test_headline_figures_stand_on_their_pages():
    """Every number of a headline in the list of evidence, but for digits and powers of ten, is one of the page that it leads to, or counts the rows of a table there."""
    number = re.compile(r"\d+(?:\.\d+)?(?:e-?\d+)?")
    rows = re.findall(r"^\| (\[.*?) \| .*? \| (.*?) \|$", (ROOT / "docs/evidence/index.md").read_text(), re.M)
    assert len(rows) > 30
    for links, headline in rows:
        text = " ".join((ROOT / "docs/evidence" / name).read_text() for name in re.findall(r"\((\w+\.md)\)", links))
        tables = [m[1].count("\n") for m in re.finditer(r"^\|[-| ]+\|\n((?:\|.*\n)+)", text, re.M)]
        assert {n for n in number.findall(headline) if len(n) > 1 and "e" not in n} <= {*number.findall(text), *map(str, tables)}, (links, headline)
