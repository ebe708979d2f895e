# SPDX-License-Identifier: GPL-3.0-or-later
"""One self-contained HTML file of a run or a study; PDF on request."""
from __future__ import annotations

import datetime
import html
from pathlib import Path
from string import Template

from .. import _engine
from .._check import checked, flag, optional
from .._check import path as a_path
from .._engine import InputError
from .._types import PathLike
from ..files import write_files
from .parts import Part, parts_of

__all__ = ["write_pdf", "write_report"]

_CITE = """hdengine {version}. Model: Hu, Li, Wang, Li (2023), Front. Mater. 10:1211019, doi:10.3389/fmats.2023.1211019
Solvers: MUMPS (Amestoy, Duff, L'Excellent, Koster 2001), METIS (Karypis, Kumar 1998)"""

def _render(title, parts):
    """The page of some sections: those of the first look, links to the others, these folded away."""
    templates = Path(__file__).parent / "templates"
    shown = "".join(
        f'<section id="{part.mark}"{" class=answer" if part.headline else ""}>'
        f'{"" if part.headline else f"<h2>{html.escape(part.heading)}</h2>"}{part.body}</section>\n' for part in parts if part.open)
    folded = [part for part in parts if not part.open]
    return Template((templates / "report.html").read_text(encoding="utf-8")).substitute(
        title=html.escape(title), style=(templates / "report.css").read_text(encoding="utf-8"), shown=shown,
        version=_engine.version(), made=datetime.datetime.now().astimezone().isoformat(sep=" ", timespec="minutes"),
        links="\n".join(f'<li><a href="#{part.mark}">{html.escape(part.heading)}</a></li>' for part in folded),
        folded="\n".join(f'<details><summary><h2>{html.escape(part.heading)}</h2></summary>\n'
                         f'<div id="{part.mark}">{part.body}</div></details>' for part in folded))


@checked(folder=a_path, path=optional(a_path), picture=flag, animation=flag)
def write_report(folder: PathLike, path: PathLike | None = None, picture: bool = False, animation: bool = False) -> Path:
    """Write the report of a run or a study.

    Parameters
    ----------
    folder : str or Path
        Folder with summary.json or study.json.
    path : str or Path, optional
        HTML file; default: report.html in the folder.
    picture : bool
        3-D picture of a run (needs PyVista; the report says so where it is missing).
    animation : bool
        Pressure and shear step by step, a GIF.

    Returns
    -------
    Path

    Raises
    ------
    FileError
        The folder holds none of them.
    """
    folder = Path(folder)
    title, parts = parts_of(folder, picture, animation)
    title = title or folder.name
    parts = [Part(*part) for part in parts]
    parts.append(Part("How to cite", f"<pre>{html.escape(_CITE.format(version=_engine.version()))}</pre>"))
    page = _render(title, parts)
    path = Path(path) if path else folder / "report.html"
    write_files({path: page})
    return path


@checked(path=a_path)
def write_pdf(path: PathLike) -> Path:
    """The report as a PDF beside its HTML file (needs WeasyPrint).

    Raises
    ------
    InputError
        WeasyPrint, or a library of the system that it needs, is not installed.
    """
    try:
        import weasyprint
    except (ImportError, OSError) as why:
        raise InputError("a PDF needs WeasyPrint and its system library Pango: pip install 'hdengine[pdf]', apt install "
                         f"libpangoft2-1.0-0; or print the HTML file from a browser ({str(why).splitlines()[0]})") from None
    out = Path(path).with_suffix(".pdf")
    page = Path(path).read_text(encoding="utf-8").replace("<details>", "<details open>")  # paper does not unfold
    write_files({out: weasyprint.HTML(string=page, base_url=str(Path(path).parent)).write_pdf()})
    return out
