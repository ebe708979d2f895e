# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages of evidence and the README show what the records of the benches hold."""
import json
import sys

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "bench"))
from tables import TABLES, text_of  # noqa: E402

PAGES = sorted((ROOT / "docs/evidence").glob("*.md"))


def between(text, marker):
    """What stands between the markers of a table."""
    return text.split(f"<!-- {marker} -->\n")[1].split(f"\n<!-- end of {marker} -->")[0]


@pytest.mark.parametrize("marker", TABLES)
def test_tables_are_those_of_the_records(marker):
    """Every generated table is made of its record, to the last character."""
    text = (ROOT / f"docs/{TABLES[marker][0]}.md").read_text()
    assert between(text, marker) == text_of(marker), "run bench/tables.py"


def test_evidence_is_short():
    """Evidence has at most twelve pages and 12 500 words, its tables included, and each page opens with what it shows."""
    assert len(PAGES) <= 12 and sum(len(page.read_text().split()) for page in PAGES) <= 12500
    for page in PAGES:
        assert page.read_text().split("\n\n")[1].startswith("Th"), page.name


def test_mutants_are_those_of_the_record():
    """The page names the mutants that the record holds; each that was not killed is listed with its fate."""
    record = json.loads((ROOT / "tools/mutants.json").read_text())
    said = f"{record['killed']} of {record['mutants']} killed, {record['undecided']} undecided"
    assert said in (ROOT / "docs/evidence/stability.md").read_text()
    assert len(record["left"]) == record["mutants"] - record["killed"] == record["undecided"] + record["survived"]
