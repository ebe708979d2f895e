# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve the points of a study, in this process or in worker processes that may die without taking the study along."""
import multiprocessing
from multiprocessing.connection import wait

import numpy as np

from . import torsion
from ._engine import HdengineError
from .contact import Run, read_scene
from .results import long_axis


def _row(step, run, scene):
    """One row of the table."""
    f = step.facets
    place = np.stack([f["x_m"], f["y_m"], f["z_m"]], -1), np.stack([f["n_x"], f["n_y"], f["n_z"]], -1)
    normal = torsion.torsional_stiffness(f["k_n_n_per_m"], 0 * f["k_t_n_per_m"], *place)
    shape = run.facets // run.axial_facets, run.axial_facets
    rotation, torque = step.sums["rotation_rad"], step.sums["torque_nm"]
    stiffness = {
        "k_ts_nm_per_rad": step.k_ts_nm_per_rad, "k_ts_normal_nm_per_rad": float(normal),
        "k_ts_paper_n": float(torsion.torsional_stiffness_paper(
            f["k_n_n_per_m"], f["k_t_n_per_m"], f["theta_rad"], scene["geometry.bore_radius"], scene["wave_generator.w"]))}
    if scene["load.support"] == "teeth":  # bonded: there is no contact of Eq. 45
        stiffness = dict.fromkeys(stiffness, float("nan"))
    return {
        "status": "done", **step.sums, **stiffness,
        "k_fe_secant_nm_per_rad": torque / rotation if torque and rotation else float("nan"),
        **long_axis(f, shape, scene["output.positions"], scene["geometry.band_length"]),
    }


def solve(path, keys, rows):
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
            except HdengineError as error:
                step = run.step()
                kept = _row(step, run, scene) if step.sums["step"] > last else {}
                table.append({**kept, "status": "failed", "reason": str(error), "code": error.code})
    except HdengineError as error:
        table.append({"status": "failed", "reason": str(error), "code": error.code})
    return table[-1:] if rows == "last" else table if rows == "all" else [
        r for r in table if r["status"] == "failed" or r["in_torque"] or r["load_factor"] >= 1 - 1e-9]


def _work(pipe):
    """Body of a worker process."""
    while True:
        task = pipe.recv()
        if task is None:
            return
        pipe.send(solve(*task))


class _Worker:
    """A process that solves one task at a time."""

    def __init__(self, context):
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_work, args=(other,), daemon=True)
        self.process.start()
        other.close()
        self.task = None


def solve_all(tasks, jobs=1):
    """Solve tasks and yield (number, rows) as they finish.

    Parameters
    ----------
    tasks : list of (number, path, keys, rows)
    jobs : int
        Worker processes; 1: in this process, one after the other.
    """
    if jobs <= 1:
        for number, *task in tasks:
            yield number, solve(*task)
        return
    context = multiprocessing.get_context("spawn")
    waiting, busy = list(tasks)[::-1], {}
    workers = [_Worker(context) for _ in range(min(jobs, len(tasks)))]
    try:
        while waiting or busy:
            for i, worker in enumerate(workers):
                if worker.task is None and waiting:
                    worker.task = waiting.pop()
                    worker.pipe.send(worker.task[1:])
                    busy[worker.pipe] = i
            for pipe in wait(list(busy)):
                i = busy.pop(pipe)
                number = workers[i].task[0]
                try:
                    rows = pipe.recv()
                    workers[i].task = None
                except EOFError:
                    workers[i].process.join()
                    rows = [{"status": "failed", "code": 1,
                             "reason": f"the worker process died, exit code {workers[i].process.exitcode}"}]
                    workers[i] = _Worker(context)
                yield number, rows
    finally:
        for worker in workers:
            if worker.task is None and worker.process.is_alive():
                worker.pipe.send(None)
            else:
                worker.process.terminate()
            worker.process.join()
