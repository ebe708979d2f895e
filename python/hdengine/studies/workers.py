# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve the points of a study, in this process or in worker processes that may die without taking the study along."""
from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any

import numpy as np

from .. import _engine, torsion
from .._check import ROUNDING
from .._engine import HdengineError, InternalError, StoppedError
from ..contact import Run, read_scene
from ..results import long_axis

__all__: list[str] = []


def _row(step, run, scene):
    """One row of the table: nothing in it depends on the machine's speed, or on which points the process solved before."""
    f = step.facets
    place = np.stack([f["x_m"], f["y_m"], f["z_m"]], -1), np.stack([f["bent_n_x"], f["bent_n_y"], f["bent_n_z"]], -1)
    normal = torsion.torsional_stiffness(f["k_n_n_per_m"], 0 * f["k_t_n_per_m"], *place)
    shape = run.facets // run.axial_facets, run.axial_facets
    stiffness = {
        "k_ts_normal_nm_per_rad": float("nan") if _engine.supported(scene, "against_teeth") else float(normal)}
    return {
        "status": "done", **{k: v for k, v in step.sums.items() if k not in ("seconds", "iterations")}, **stiffness,
        **long_axis(f, shape, scene["output.positions"], scene["geometry.band_length"]),
    }


def solve(path: str, keys: dict, rows: str) -> list:
    """Rows of one point; a point that fails ends with a row of status 'failed' and its reason.

    Parameters
    ----------
    path : str
        Scene.
    keys : dict
        'group.key' to value.
    rows : str
        'torque', 'last' or 'all'.

    Returns
    -------
    list of dict
    """
    table, last = [], 0
    try:
        scene = read_scene(path, **keys)
        with Run(path, **keys) as run:
            try:
                for step in run:
                    last = step.sums["step"]
                    table.append(_row(step, run, scene))
                table[-1] |= run.loop()
            except HdengineError as error:
                step = run.step()
                kept = _row(step, run, scene) if step.sums["step"] > last else {}
                table.append({**kept, "status": "failed", "reason": str(error), "code": error.code})
    except HdengineError as error:
        table.append({"status": "failed", "reason": str(error), "code": error.code})
    return table[-1:] if rows == "last" else table if rows == "all" else [
        r for r in table if r["status"] == "failed" or r["in_torque"] or r["load_factor"] >= 1 - ROUNDING]


def work(file: int) -> None:
    """Body of a worker process: solve what comes through a pipe until it is closed.

    Parameters
    ----------
    file : int
        Number of the open file that is the worker's end of the pipe.
    """
    for number in set(_engine.stop_signals()) - {signal.SIGTERM, signal.SIGXCPU}:  # a batch system sends them to all processes,
        signal.signal(number, signal.SIG_IGN)                                      # and the study ends its workers
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError), Connection(file) as pipe:
        pipe.send("ready")
        while (task := pipe.recv()) is not None:
            try:
                rows = solve(*task)
            except Exception as error:  # a fault of the engine costs its point only
                rows = [{"status": "failed", "reason": f"{type(error).__name__}: {error}", "code": InternalError.code}]
            pipe.send(rows)


class _Worker:
    """A process with one thread that solves one task at a time. It is no copy of this one, and needs nothing of its script."""

    def __init__(self):
        self.pipe, other = Pipe()
        code = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import work; work({other.fileno()})"
        self.process = subprocess.Popen([sys.executable, "-c", code], pass_fds=[other.fileno()], stdin=subprocess.DEVNULL,
                                        env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"})
        other.close()
        self.task: Any = None
        self.ready = False

    def give(self, task):
        """Send a task; False if the process has died."""
        try:
            self.pipe.send(task[1:])
        except OSError:
            return False
        self.task = task
        return True

    def death(self):
        """How the process ended, in words, and whether it was stopped from outside."""
        code = self.process.wait()
        self.pipe.close()
        if code >= 0:
            return f"exit code {code}", False
        short = ", as where memory is short" if code == -signal.SIGKILL else ""
        return f"signal {signal.Signals(-code).name}{short}", -code in _engine.stop_signals()

    def end(self):
        """Let an idle process go, end a busy one."""
        if self.task is None:
            with contextlib.suppress(OSError):
                self.pipe.send(None)
        else:
            self.process.terminate()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.pipe.close()


def solve_all(tasks: list, jobs: int = 1) -> Iterator:
    """Solve tasks and yield (number, rows) as they finish.

    Parameters
    ----------
    tasks : list of (number, path, keys, rows)
    jobs : int
        Worker processes with one thread each; 1: in this process, one after the other.

    Raises
    ------
    InternalError
        A worker process cannot start. One that dies later costs its task only.
    StoppedError
        Worker processes were stopped from outside: all other tasks are done, and those of these were not yielded.
    """
    if jobs <= 1:
        for number, *task in tasks:
            yield number, solve(*task)
        return
    waiting, left = list(tasks)[::-1], []
    workers = [_Worker() for _ in range(min(jobs, len(tasks)))]
    try:
        while waiting or any(worker.task for worker in workers):
            for i, worker in enumerate(workers):
                if not (worker.ready and worker.task is None and waiting):
                    continue
                if worker.give(waiting[-1]):
                    waiting.pop()
                else:  # it died while it had nothing to do
                    worker.death()
                    workers[i] = _Worker()
            ready: Any = wait([worker.pipe for worker in workers if worker.task or not worker.ready])
            for pipe in ready:
                i = next(i for i, worker in enumerate(workers) if worker.pipe is pipe)
                worker = workers[i]
                try:
                    rows = pipe.recv()
                except (EOFError, OSError):
                    how, stopped = worker.death()
                    if not worker.ready:
                        raise (StoppedError if stopped else InternalError)(
                            f"a worker process ended before it could begin ({how}); its message stands above") from None
                    rows = [{"status": "failed", "code": InternalError.code, "reason": f"the worker process died ({how})"}]
                    number, workers[i] = worker.task[0], _Worker()
                    if stopped:
                        left.append(f"{number} ({how})")
                        continue
                else:
                    if not worker.ready:
                        worker.ready = True
                        continue
                    number, worker.task = worker.task[0], None
                yield number, rows
        if left:
            raise StoppedError(f"points left to do, as their worker processes were stopped: {', '.join(left[:8])}"
                               f"{f' and {len(left) - 8} more' if left[8:] else ''}; the same command goes on with them")
    finally:
        for worker in workers:
            if worker.process.poll() is None:
                worker.end()
