# SPDX-License-Identifier: GPL-3.0-or-later
"""What the engine takes, in instructions."""
import shutil
import sys

import pytest

from conftest import ROOT, executable

sys.path.insert(0, str(ROOT / "bench"))
import regressions  # noqa: E402


@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind is not installed")
def test_no_run_takes_more_than_its_record_allows(monkeypatch):
    """Every case has a record, and none takes 1.3 times its recorded instructions or more."""
    monkeypatch.setattr(regressions, "program", lambda name: executable())
    record = regressions.last_record()
    assert set(record) == set(regressions.CASES)
    assert regressions.losses(regressions.counts(), record) == {}


def test_a_loss_is_seen():
    """A case above 1.3 times its record is named with its ratio; one below, or without a record, is not."""
    assert regressions.losses({"a": 14, "b": 12, "c": 5}, {"a": 10, "b": 10}) == {"a": 1.4}
