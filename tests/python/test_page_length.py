# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages fit three screens of 1280 x 900 pixels: 2700 pixels.

No browser is needed: the height is computed from the Markdown. The pixels of a word, a row and so on were fitted by least squares to the heights
of the pages as Chromium 156 shows them (25 November 2026, text of 16 px, tables of 13 px). Computed heights of 141 pages differ from those by
51 pixels (root mean square), by 200 at most. What is folded (<details>) takes a line. After a change of docs/_static/tables.css the fit is due again.
"""
import importlib
import re
import struct
import sys

import pytest

from conftest import ROOT

DOCS = ROOT / "docs"
SCREENS = 3 * 900
PAGE, WORD, BLOCK, ITEM, ROW, HEADING, CODE = 173, 1.4, 28.6, 11.7, 26.3, 45, 19.5  # pixels; a block is a paragraph or a list, a cell fits a line
TEXT, FIGURE, BESIDE, WIDE = 736, 800, 360, 248    # width of a picture: alone, as figure, beside its table, beside a wide one
MADE = {"requirements.md", "coverage.md", "record_ages.md", "api.md", "api_surfaces.md"}  # made by tools, or lists of links
PAGES = sorted(str(p.relative_to(DOCS)) for p in DOCS.rglob("*.md") if p.name not in MADE and not {"api", "gallery", "_build"} & set(p.parts))


def picture(page, target, width):
    """Height of a picture at this width [pixels]; no picture is drawn larger than it is, but for vector figures."""
    path = (page.parent / target).resolve()
    if path.suffix == ".svg":
        if not path.exists():  # the site draws them when it is built
            sys.path[:0] = [str(DOCS / "drawings")]
            for name in ("draw", "diagrams"):
                importlib.import_module(name).draw_all(DOCS / "figures")
        wide, high = map(float, re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', path.read_text()).groups())
        return width * high / wide
    wide, high = struct.unpack(">II", path.read_bytes()[16:24])
    return min(width, wide) * high / wide


def height(page, text):
    """Height of a page [pixels] by its Markdown."""
    pixels = PAGE

    def add(pattern, size, keep=lambda m: ""):
        nonlocal text, pixels
        for m in re.finditer(pattern, text, re.S | re.M):
            pixels += size(m)
        text = re.sub(pattern, keep, text, flags=re.S | re.M)

    def rows(part):
        return len(re.findall(r"^\|", part, re.M)) - len(re.findall(r"^\|[-| :]+\|$", part, re.M))

    def figure(m):
        percent = re.search(r":width: (\d+)%", m[0])
        return 30 + picture(page, m[1], FIGURE * int(percent[1] if percent else 100) / 100)

    text = re.sub(r"^```\{include\} (\S+)\n```", lambda m: (page.parent / m[1]).read_text() if (page.parent / m[1]).exists() else "", text, flags=re.M)
    add(r"^<details>.*?^</details>", lambda m: BLOCK)
    add(r"^```\{toctree\}.*?^```", lambda m: 0 if ":hidden:" in m[0] else 20 * m[0].count("\n"))
    add(r"^```\{figure\} (\S+)\n(.*?)^```", figure, lambda m: re.sub(r"^:.*\n", "", m[2], flags=re.M))
    add(r"^:::\{container\} beside( wide)?\n.*?\]\((\S+)\)(.*?)^:::$",
        lambda m: 16 + max(picture(page, m[2], WIDE if m[1] else BESIDE), ROW * rows(m[3])))
    add(r"^!\[[^]]*\]\((\S+)\)$", lambda m: 12 + picture(page, m[1], TEXT))
    add(r"^```(?!\{)[^\n]*\n(.*?)^```", lambda m: CODE * (m[1].count("\n") + 2))
    pixels += ROW * rows(text) + HEADING * len(re.findall(r"^#", text, re.M))
    prose = re.sub(r"\]\([^)]*\)", "", re.sub(r"^(?:\||#|<|```).*$", "", text, flags=re.M))
    pixels += WORD * sum(any(map(str.isalnum, word)) for word in prose.split())
    pixels += BLOCK * sum(bool(part.strip()) for part in re.split(r"\n\s*\n", prose)) + ITEM * len(re.findall(r"^\s*(?:[-*]|\d+\.) ", prose, re.M))
    return pixels


@pytest.mark.parametrize("page", PAGES)
def test_page_fits_three_screens(page):
    """A page of the site is at most three screens high; lists made by tools are left out."""
    found = height(DOCS / page, (DOCS / page).read_text())
    assert found <= SCREENS, f"{found / 900:.2f} screens: split the page by subject, or fold (<details>) what is no headline"


def test_long_pages_are_found():
    """A page of two screens with as much again is too long, as is a page with four tall figures; a folded table is not counted."""
    page = DOCS / "explain/surface_fit.md"
    text = page.read_text()
    assert height(page, text) < SCREENS < height(page, text + text)
    assert height(page, "# Title\n\n" + "![four](../figures/joint_models.png)\n\n" * 4) > SCREENS
    table = "| a |\n|---|\n" + "| 1 |\n" * 150
    assert height(page, f"# Title\n\n{table}") > SCREENS > height(page, f"# Title\n\n<details>\n<summary>a</summary>\n\n{table}\n</details>\n")
