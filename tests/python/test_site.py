# SPDX-License-Identifier: GPL-3.0-or-later
"""The site is built from the pages."""
import functools
import http.server
import json
import re
import shutil
import subprocess
import sys
import threading

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tools"))
import made_pages  # noqa: E402


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """What Sphinx said, and the folder of the site."""
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-d", folder / "trees", ROOT / "docs", folder / "html"],
                          capture_output=True, text=True)
    return done, folder / "html"


def test_site_builds_without_warnings(built):
    """Sphinx finds no broken link, no page outside the contents and no faulty docstring; no page loads a style sheet or a script from a
    server; the notebooks of the gallery hold the code of the examples that the build runs."""
    done, html = built
    assert done.returncode == 0, done.stderr
    assert (html / "index.html").exists()
    loads = re.compile(r"""<(?:script|link rel="stylesheet"|link)[^>]*(?:src|href)="https?://[^"]*\.(?:js|css)""")
    pages = [*html.rglob("*.html")]
    assert [str(page) for page in pages if loads.search(page.read_text())] == [] and len(pages) > 500
    assert (html / "index.html").read_text().count('class="toctree-l') < 80  # of the menu, which lists no name of the API
    notebooks = {path.stem: path for path in (html / "_downloads").rglob("*.ipynb")}
    assert sorted(notebooks) == sorted(path.stem for path in (ROOT / "examples").glob("*.py"))
    for name, path in notebooks.items():
        cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
        assert code(f"{''.join(cell['source'])}\n" for cell in cells) == code([(ROOT / f"examples/{name}.py").read_text().split('"""', 2)[2]]), name


# Widths beyond the window and cards that overlap, of pages in frames of 1280 and 390 pixels, as JSON.
LOOK = """<!DOCTYPE html><html><body><script>
const pages = %s, questions = %s, found = [], hits = {};
let left = 2 * pages.length + questions.length;
function done() {
  if (!--left) document.body.innerText = 'looked: ' + JSON.stringify([found, hits]) + ' end';
}
for (const question of questions) {
  const frame = document.createElement('iframe');
  const read = wait => {
    const links = [...frame.contentDocument.querySelectorAll('li[class^=kind-] > a')];
    if (links.length < 3 && wait) return setTimeout(read, 100, wait - 1);
    hits[question] = links.slice(0, 3).map(link => link.pathname);
    done();
  };
  frame.onload = () => read(100);
  frame.src = 'search.html?q=' + encodeURIComponent(question);
  document.body.append(frame);
}
for (const page of pages) for (const width of [1280, 390]) {
  const frame = document.createElement('iframe');
  frame.style.width = width + 'px';
  frame.style.height = '900px';
  frame.onload = () => {
    const root = frame.contentDocument.documentElement;
    if (root.scrollWidth > width + 1) found.push(`${page} at ${width}: ${root.scrollWidth} wide`);
    const cards = [...root.querySelectorAll('.sphx-glr-thumbcontainer')].map(c => c.getBoundingClientRect());
    cards.forEach((a, i) => cards.slice(i + 1).forEach(b => {
      if (a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1) found.push(`${page} at ${width}: cards`);
    }));
    for (const image of root.querySelectorAll('.sphx-glr-thumbcontainer img'))
      if (image.closest('a')) found.push(`${page} at ${width}: a thumbnail in a link of its own`);
    done();
  };
  frame.src = page;
  document.body.append(frame);
}
</script></body></html>"""
QUESTIONS = {"how accurate is K_TS": "howto/trust.html", "which warning means what": "reference/errors.html", "stiffness for my robot": "howto/robot.html",
             "backlash": "reference/glossary.html", "lost motion": "explain/drive.html", "catalogue K1": "gallery/drive_loop.html", "MuJoCo": "howto/robot.html",
             "units": "start/first_run.html", "resume": "howto/resume.html", "cluster": "howto/study.html",
             "noise of measured surface": "evidence/surfaces.html", "optimise": "howto/study.html", "own gear": "howto/own_size.html"}


def test_a_browser_finds_its_way(built):
    """In Chromium no page is wider than a window of 1280 or 390 pixels, no card of the gallery overlaps, and a designer's questions lead
    to their page in the first three hits of the search."""
    chromium = shutil.which("chromium") or pytest.skip("Chromium is not installed")
    assert look(chromium, built[1]) == ([], dict.fromkeys(QUESTIONS, True))


def look(chromium, html):
    """What is wider than it may be, and whether each question finds its page."""
    pages = ["index.html", "gallery/index.html", "start/first_run.html", "howto/robot.html", "reference/errors.html", "evidence/drive.html"]
    (html / "look.html").write_text(LOOK % (json.dumps(pages), json.dumps([*QUESTIONS])))
    handler = functools.partial(QuietHandler, directory=str(html))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        seen = subprocess.run([chromium, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=30000", "--dump-dom",
                               f"http://127.0.0.1:{server.server_port}/look.html"], capture_output=True, text=True, timeout=200).stdout
        server.shutdown()
    wide, hits = json.loads(re.search(r"looked: (.*) end", seen, re.S)[1])
    return wide, {question: f"/{QUESTIONS[question]}" in found for question, found in hits.items()}


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Files of a folder, without a line for each."""

    def log_message(self, *_):
        """Say nothing."""


def code(parts):
    """Lines of code without comments."""
    return [line for line in "".join(parts).splitlines() if line.strip() and not line.startswith("#")]


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "THIRD_PARTY.md"])
def test_links_outside_the_site_lead_somewhere(page):
    """Pages that Sphinx does not read link to files that exist; Sphinx checks the links of docs."""
    targets = re.findall(r"\]\((?!https?:)([^)#\s]+)", (ROOT / page).read_text())
    assert [t for t in targets if not (ROOT / t).exists()] == []


def test_sources_name_pages_that_exist():
    """Every page of docs that a scene, an example, a script or a source names is there, or made by the build."""
    made = {f"docs/reference/{name}.md" for name in made_pages.PAGES}
    named = {(str(path.relative_to(ROOT)), page) for room in ("data", "examples", "hpc", "python", "fortran", "tools", "bench") for path in (ROOT / room).rglob("*.*")
             if path.suffix in {".nml", ".py", ".slurm", ".f90", ".toml", ".sh"} for page in re.findall(r"\bdocs/[\w/]+/\w+\.md\b", path.read_text())}
    assert len(named) > 20 and [(path, page) for path, page in sorted(named) if not (ROOT / page).exists() and page not in made] == []
