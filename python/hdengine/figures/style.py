# SPDX-License-Identifier: GPL-3.0-or-later
"""The style of all figures, kept off the user's session: no backend is chosen and no setting of matplotlib outlives a call."""
from __future__ import annotations

import functools
from collections.abc import Callable
from typing import IO, Any, TypeVar

import matplotlib
from cycler import cycler
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from .._types import PathLike
from ..views.palette import COLOURS

__all__: list[str] = []
F = TypeVar("F", bound=Callable)
STYLE: Any = {"font.size": 12, "axes.grid": True, "grid.alpha": 0.3, "savefig.dpi": 110,
              "axes.prop_cycle": cycler(color=COLOURS)}


def styled(function: F) -> F:
    """Run a function in the style of the figures; the settings before it come back after it.

    Parameters
    ----------
    function : callable
        It draws.

    Returns
    -------
    callable
    """
    @functools.wraps(function)
    def inside(*args, **keys):
        with matplotlib.rc_context(STYLE):
            return function(*args, **keys)
    return inside  # type: ignore[return-value]  # wraps keeps what it takes and gives


class StyledFigure(Figure):
    """A figure that pyplot does not know of: nothing to close, no window; ticks made while it is drawn keep the style too."""

    draw = styled(Figure.draw)

    @styled
    def savefig(self, fname: PathLike | IO[bytes], **keys: Any) -> None:
        """Save the figure; it is laid out once, where matplotlib does so twice."""
        engine = self.get_layout_engine()
        if engine is not None:
            engine.execute(self)
            self.set_layout_engine(None)
        try:
            super().savefig(fname, **keys)
        finally:
            self.set_layout_engine(engine)


@styled
def new_figure(**keys: Any) -> StyledFigure:
    """An empty figure.

    Parameters
    ----------
    **keys
        Of `matplotlib.figure.Figure`, as figsize.

    Returns
    -------
    StyledFigure
    """
    figure = StyledFigure(**{"layout": "constrained"} | keys)
    FigureCanvasAgg(figure)
    return figure


@styled
def new_axes(rows: int = 1, columns: int = 1, figsize: tuple[float, float] | None = None, **keys: Any) -> tuple:
    """A figure and its axes, as `matplotlib.pyplot.subplots` gives them.

    Parameters
    ----------
    rows, columns : int
        Of the grid of axes.
    figsize : tuple of float, optional
        Width and height [inch].
    **keys
        Of `matplotlib.figure.Figure.subplots`.

    Returns
    -------
    figure : StyledFigure
    axes : matplotlib.axes.Axes or ndarray of them
    """
    figure = new_figure(**({"figsize": figsize} if figsize else {}))
    return figure, figure.subplots(rows, columns, **keys)
