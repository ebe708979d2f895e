# SPDX-License-Identifier: GPL-3.0-or-later
"""The site is built from the pages."""
import json
import re
import subprocess
import sys

import pytest

from conftest import ROOT


def test_site_builds_without_warnings(tmp_path):
    """Sphinx finds no broken link, no page outside the contents and no faulty docstring; no page loads a style sheet or a script from a
    server; the notebooks of the gallery hold the code of the examples that the build runs."""
    done = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-d", tmp_path / "trees", ROOT / "docs", tmp_path / "html"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "html/index.html").exists()
    loads = re.compile(r"""<(?:script|link rel="stylesheet"|link)[^>]*(?:src|href)="https?://[^"]*\.(?:js|css)""")
    pages = [*(tmp_path / "html").rglob("*.html")]
    assert [str(page) for page in pages if loads.search(page.read_text())] == [] and len(pages) > 500
    notebooks = {path.stem: path for path in (tmp_path / "html/_downloads").rglob("*.ipynb")}
    assert sorted(notebooks) == sorted(path.stem for path in (ROOT / "examples").glob("*.py"))
    for name, path in notebooks.items():
        cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
        assert code(f"{''.join(cell['source'])}\n" for cell in cells) == code([(ROOT / f"examples/{name}.py").read_text().split('"""', 2)[2]]), name


def code(parts):
    """Lines of code without comments."""
    return [line for line in "".join(parts).splitlines() if line.strip() and not line.startswith("#")]


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "THIRD_PARTY.md"])
def test_links_outside_the_site_lead_somewhere(page):
    """Pages that Sphinx does not read link to files that exist; Sphinx checks the links of docs."""
    targets = re.findall(r"\]\((?!https?:)([^)#\s]+)", (ROOT / page).read_text())
    assert [t for t in targets if not (ROOT / t).exists()] == []
