# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress of a list of tasks: a bar of tqdm in notebooks; else on stderr, a bar on a terminal, lines in a file."""
from __future__ import annotations

import sys
import time

from ..contact import bar, in_notebook

__all__: list[str] = []


def duration(seconds: float) -> str:
    """Seconds as a short text."""
    minutes, s = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {s:02d} s" if minutes else f"{s} s"


class Progress:
    """Counts tasks and estimates the time left from the tasks done so far.

    Parameters
    ----------
    total, done : int
        Tasks in all, tasks done before.
    show : bool
        Write to stderr, in a notebook to the cell.
    """

    def __init__(self, total: int, done: int = 0, show: bool = True) -> None:
        self.total, self.done, self.first, self.failed, self.show = total, done, done, 0, show and sys.stderr is not None
        self.start = time.monotonic()
        self.bar = bar(total=total, initial=done, desc="points", unit="") if show and in_notebook() else None

    def step(self, label: str, failed: bool = False) -> None:
        """One more task is done."""
        self.done += 1
        self.failed += failed
        elapsed = time.monotonic() - self.start
        left = elapsed / (self.done - self.first) * (self.total - self.done)
        if not self.show:
            return
        tail = f"{self.done}/{self.total}" + (f", {self.failed} failed" if self.failed else "")
        if self.bar is not None:
            self.bar.set_postfix_str(label + (f", {self.failed} failed" if self.failed else ""))
            self.bar.update()
            if self.done == self.total:
                self.bar.close()
        elif sys.stderr.isatty():
            filled = 30 * self.done // self.total
            print(f"\r[{'#' * filled}{'.' * (30 - filled)}] {tail}, {duration(left)} left ", end="", file=sys.stderr, flush=True)
            if self.done == self.total:
                print(file=sys.stderr)
        else:
            print(f"{tail}, {duration(left)} left: {label}{' FAILED' if failed else ''}", file=sys.stderr, flush=True)
