# SPDX-License-Identifier: GPL-3.0-or-later
"""The site is built from the pages."""
import subprocess
import sys

from conftest import ROOT


def test_site_builds_without_warnings(tmp_path):
    """Sphinx finds no broken link, no page outside the contents and no faulty docstring."""
    done = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-d", tmp_path / "trees", ROOT / "docs", tmp_path / "html"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "html/index.html").exists()
