# SPDX-License-Identifier: GPL-3.0-or-later
"""The site: Sphinx reads the Markdown pages with MyST and the Python package by its docstrings (numpydoc), FORD the Fortran modules. Built by `./hd docs`."""
import functools
import importlib
import logging
import os
import re
import shutil
import subprocess
import sys
from importlib.resources import files
from pathlib import Path

from docutils import nodes
from numpydoc import docscrape_sphinx
from sphinx.ext import autosummary
from sphinx.util.logging import getLogger

import hdengine

HERE = Path(__file__).parent

project = "hdengine"
author = project_copyright = "the hdengine developers"
version = release = hdengine.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "numpydoc", "sphinx.ext.mathjax",
              "sphinx-mathjax-offline",  # formulas without a network
              "sphinx_gallery.gen_gallery"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
numpydoc_show_class_members = False
for name in ("BuiltinTemplateLoader", "SandboxedEnvironment"):  # one of each: numpydoc compiles its templates anew for each of 700 docstrings
    setattr(docscrape_sphinx, name, functools.cache(getattr(docscrape_sphinx, name)))
autosummary_generate = True
autosummary.WELL_KNOWN_ABBREVIATIONS += ("Eq.",)  # a summary does not end there
autodoc_typehints = "none"
sphinx_gallery_conf = {
    "examples_dirs": "../examples", "gallery_dirs": "gallery", "filename_pattern": r"\.py$", "abort_on_example_error": True,
    "within_subsection_order": "ExampleTitleSortKey", "remove_config_comments": True, "min_reported_time": 1e9, "show_memory": False,
    "download_all_examples": False, "image_scrapers": ("matplotlib",), "default_thumb_file": None, "matplotlib_animations": False,
    "capture_repr": (), "write_computation_times": False, "show_signature": False, "nested_sections": False}
templates_path = []
exclude_patterns = ["_build", "drawings", "gallery/*.ipynb", "gallery/*.py", "gallery/*.json"]
html_theme = "furo"
html_title = "hdengine"
html_static_path = ["_static"]
html_css_files = ["tables.css"]
html_theme_options = {"sidebar_hide_name": False, "navigation_with_keys": True}
html_show_sourcelink = False
nitpicky = False


def fortran_pages(app, failure):
    """FORD's pages of the Fortran modules, in the folder fortran of the site; its warnings are the site's."""
    if failure:
        return
    quick = "import ford, ford.sourceform; ford.sourceform.highlight = lambda *_: None; ford.run()"  # no page shows the sources that it colours
    done = subprocess.run([sys.executable, "-c", quick, HERE.parent / "config/ford.md", "--output_dir", Path(app.outdir) / "fortran"],
                          capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(HERE.parent / "tools")})
    said = (done.stdout + done.stderr).splitlines()
    for line in said if done.returncode else [line for line in said if "Warning" in line]:
        getLogger(__name__).warning("FORD: %s", line)
    keep_offline(Path(app.outdir) / "fortran")


def keep_offline(site):
    """Let FORD's pages take Bootstrap from their own folder: they ask a server for it, and for MathJax, which no comment needs."""
    for name in ("css/bootstrap.min.css", "js/bootstrap.bundle.min.js"):
        shutil.copy(files("mkdocs") / "themes/mkdocs" / name, site / name)  # the one wheel that holds both
    for page in site.rglob("*.html"):
        root = "../" * (len(page.relative_to(site).parts) - 1)
        text = re.sub(r'"https://cdn[^"]*/(css|js)/(bootstrap[^"]*)"', rf'"{root}\1/\2"', page.read_text())
        text = re.sub(r'<script src="https://cdn[^"]*MathJax[^>]*></script>', "", text)
        page.write_text(re.sub(r'\s*integrity="[^"]*" crossorigin="anonymous"', "", text))


def link_figures(app, tree, page):
    """A figure opens in full size at a touch: on a phone it is narrower than its text."""
    for image in [*tree.findall(nodes.image)]:
        found = app.env.images.get(image["uri"])
        if found and "/thumb/" not in image["uri"] and not isinstance(image.parent, nodes.reference):  # cards of the gallery link
            target = app.builder.get_relative_uri(page, "index").removesuffix("index.html") + f"{app.builder.imagedir}/{found[1]}"
            link = nodes.reference("", "", refuri=target, internal=True)
            image.replace_self(link)
            link += image


def off_menu(app, tree):
    """The menu beside each page ends at the page that lists the API: its 88 names would be three fifths of the menu."""
    for node in [*tree.findall(autosummary.autosummary_toc)]:
        node.parent.remove(node)
    if app.env.docname.startswith("reference/api/"):
        app.env.metadata[app.env.docname]["orphan"] = True


def setup(app):
    """Keep the log of the gallery's runs quiet, draw the vector figures that the pages show, write the pages that are made of the sources."""
    logging.getLogger("hdengine").setLevel(logging.WARNING)
    sys.path[:0] = [str(HERE / "drawings"), str(HERE.parent / "tools")]
    importlib.import_module("made_pages").write()
    for name in ("draw", "diagrams"):
        importlib.import_module(name).draw_all(HERE / "figures")
    app.connect("doctree-resolved", link_figures)
    app.connect("doctree-read", off_menu, priority=1)
    app.connect("build-finished", fortran_pages)
