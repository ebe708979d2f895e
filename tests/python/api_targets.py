# SPDX-License-Identifier: GPL-3.0-or-later
"""The public Python functions that test_attack.py calls with wrong arguments, each with a call that is valid."""
import numpy as np

from conftest import ROOT


def targets():
    """(name, function, valid arguments) of the functions under attack."""
    import hdengine
    from hdengine import catalogue, mesh, roughness, specimen, surface, torsion
    from hdengine.record import Record
    from hdengine.studies import planner

    rng = np.random.default_rng(1)
    z = rng.normal(size=(40, 48)).cumsum(0).cumsum(1) * 1e-8
    eq1 = {"fractal_dimension": 2.5, "roughness": 1e-8, "gamma": 1.5, "length": 1e-4, "shortest_wavelength": 1e-6}
    grid = {"shape": (12, 9), "spacing": 1e-6}
    part = mesh.block([0, 1, 2], [0, 1], [0, 1])
    n = len(part.points)
    held = np.zeros((n, 3), bool)
    held[part.points[:, 0] == 0] = True
    pull = np.zeros((n, 3))
    pull[part.points[:, 0] == 2, 2] = 1.0
    joint = hdengine.Joint()
    turn = np.concatenate([np.linspace(0, 5, 40), np.linspace(5, -5, 80), np.linspace(-5, 5, 80)])
    yield "solid.static", solid_static, {"points": part.points, "cells": part.cells, "young": 1.0, "poisson": 0.3,
                                         "angle": 0.0, "fixed": held, "displacement": None, "force": pull, "element": "hex8i"}
    yield "solid.contact", solid_contact, {
        "facets_slave": part.facets(part.points[:, 2] == 1), "facets_master": part.facets(part.points[:, 2] == 0),
        "chart": part.points[:, :2], "force": None, "gap": None, "friction": 0.2, "mode": "frictional", "period": 0.0, "scale": None,
        "tolerance": 1e-10, "max_iterations": 20, "young": 1.0}
    yield "mesh.block", mesh.block, {"x": [0, 1], "y": [0, 1], "z": [0, 1, 2], "quadratic": False}
    yield "mesh.merge", mesh.merge, {"*": (part, part), "tolerance": 1e-9}
    yield "mesh.graded", mesh.graded, {"first": 0.0, "last": 1.0, "size": 0.1, "growth": 1.2}
    yield "Mesh.facets", part.facets, {"chosen": part.points[:, 2] == 1}
    yield "surface.generate", surface.generate, {**grid, **eq1, "ridges": 5, "seed": 3, "origin": 0.0, "tolerance": None,
                                                 "method": "auto", "dtype": float}
    yield "surface.choose", surface.choose, {**grid, **eq1, "ridges": 5, "seed": 3, "origin": 0.0, "tolerance": 1e-6,
                                             "method": "auto", "dtype": float}
    yield "surface.profile", surface.profile, {"n": 40, "spacing": 1e-6, **eq1, "seed": 3, "origin": 0.0}
    yield "surface.waves", surface.waves, {**eq1, "ridges": 4, "seed": 1}
    yield "surface.sum_waves", surface.sum_waves, {
        "fx": [1e4, 2e4, 3e4], "fy": [1e4, 2e4, 3e4], "amplitude": [1e-7] * 3, "phase": [.1, .2, .3], "shape": (16, 16),
        "spacing": 1e-6, "origin": 0.0, "tolerance": 1e-6, "method": "nufft"}
    yield "surface.periodic", surface.periodic, {"n": 16, "length": 1e-4, "fractal_dimension": 2.5, "roughness": 1e-8,
                                                 "shortest_wavelength": 2e-5, "seed": 1}
    yield "roughness.structure_function", roughness.structure_function, {
        "heights": z, "spacing": 1e-6, "lags": [1, 2, 3], "direction": "rows", "second": False}
    yield "roughness.expected_structure", roughness.expected_structure, {
        "tau": [1e-6, 2e-6], "fractal_dimension": 2.5, "roughness": 1e-8, "band": (1e-6, 1e-4), "model": "isotropic"}
    yield "roughness.level", roughness.level, {"heights": z}
    yield "roughness.fit", roughness.fit, {"heights": z, "spacing": 1e-6, "lags": (1, 8), "model": "paper", "surface": None,
                                           "level": True, "band": None, "noise": 0.0, "second": None}
    yield "roughness.Ridges", ridges, {"length": 1e-4, "shortest_wavelength": 1e-6, "ridges": 10, "gamma": 1.5}
    yield "specimen.Specimen.fit", specimen_fit, {"heights": z, "spacing": (1e-6, 1e-6), "name": "a", "lags": (1, 8)}
    yield "specimen.equivalent", specimen.equivalent, {"first": specimen.Specimen(z, (1e-6, 1e-6)),
                                                       "second": specimen.Specimen(2 * z, (1e-6, 1e-6)), "lags": (1, 8)}
    yield "specimen.save", specimen.save, {"path": "s.sdf", "specimen": specimen.Specimen(z, (1e-6, 1e-6))}
    yield "specimen.read", specimen.read, {"path": str(ROOT / "data/specimen_bearing.sdf"), "unit": None, "spacing": None,
                                           "channel": None}
    numbers = {name: getattr(joint, name) for name in joint.__dataclass_fields__}
    yield "Joint", joint_stiffness, {**numbers, "pressure": [1e6, 1e7], "shear": 0.0, "area": None}
    yield "Joint.stiffness", joint.stiffness, {"pressure": [1e6, 1e7], "shear": 0.0, "area": 1e-6}
    yield "Joint.derivatives", joint.derivatives, {"pressure": [1e6, 1e7], "shear": 0.0, "area": 1e-6}
    yield "Joint.closure", joint.closure, {"pressure": [1e6], "zero_pressure": 1e3}
    yield "Joint.pressure", joint.pressure, {"closure": [1e-7], "zero_pressure": 1e3}
    yield "Joint.shear", joint.shear, {"pressure": [1e6], "displacement": [1e-7]}
    yield "Joint.largest_spot", joint.largest_spot, {"pressure": [1e6]}
    yield "Joint.warnings", joint.warnings, {"pressure": 1e6}
    yield "Joint.sensitivity", joint.sensitivity, {"pressure": 1e6, "shear": 0.0, "step": 1e-4}
    yield "Joint.parts", joint.parts, {"s_l": 1e-11, "tau": 0.0}
    yield "Joint.asperity", joint.asperity, {"depth": 1e-8, "area": 1e-12, "tau": 0.0}
    position, normal = rng.normal(size=(7, 3)), rng.normal(size=(7, 3))
    yield "torsion.torsional_stiffness", torsion.torsional_stiffness, {"k_n": np.ones(7), "k_t": np.ones(7), "position": position,
                                                                       "normal": normal}
    yield "torsion.torsional_stiffness_paper", torsion.torsional_stiffness_paper, {
        "k_n": np.ones(7), "k_t": np.ones(7), "theta": np.arange(7.0), "r": 17.5e-3, "w": 2e-4, "slope": 0.0}
    yield "torsion.facet_weights", torsion.facet_weights, {"position": position, "normal": normal}
    yield "torsion.series", torsion.series, {"*": (1e4, 2e4)}
    yield "torsion.remaining_stiffness", torsion.remaining_stiffness, {"k_total": 1e3, "k_part": 2e3}
    yield "catalogue.stages", catalogue.stages, {"torque_nm": turn[:40], "angle_rad": turn[:40] / 5e3, "t1_nm": 2.0, "t2_nm": 4.0}
    yield "catalogue.Unit.angle", catalogue.UNITS[14].angle, {"torque_nm": turn}
    yield "Record", Record, {"torque_nm": turn, "angle_rad": turn / 5e3, "torque_error_nm": 0.05, "angle_error_rad": 1e-5,
                             "pieces": 12}
    record = Record(turn, turn / 5e3 + 1e-6 * rng.normal(size=len(turn)))
    yield "Record.curve", record.curve, {"branch": "middle", "points": 20, "share": 0.9, "draws": 5, "seed": 1}
    yield "Record.numbers", record.numbers, {"unit": None, "rated_torque_nm": None, "share": 0.9, "draws": 5, "seed": 1}
    yield "read_scene", hdengine.read_scene, {"path": "", "load": {"torque": 1.0}, "mesh__divisions": 24}
    yield "catalogue.unit", catalogue.unit, {"size": 14, "ratio": 100}
    yield "as_built", hdengine.as_built, {"size": 14, "ratio": 100, "hat": False, "load": {"tooth_clearance": 1e-5}}
    yield "Run", short_run, {"path": "", "out": "", "force": False, "resume": False, "load": {"torque": 1.0}, "mesh__divisions": 8}
    yield "Study", study_points, {"scene": "", "grid": {"load.torque": [1, 2]}, "together": {}, "fixed": {"mesh.divisions": 16},
                                  "rows": "torque", "title": "t", "figure": {}}
    yield "load", hdengine.load, {"folder": "nothing"}
    yield "planner.plan", planner.plan, {"path": "nothing", "tolerance": 0.1, "keys": {}}


def solid_static(points, cells, young, poisson, angle, **more):
    """A body made and solved."""
    from hdengine import mesh, solid

    return solid.static([solid.Body(mesh.Mesh(points, cells), young, poisson, angle)], **more)


def solid_contact(facets_slave, facets_master, chart, young, **more):
    """Two blocks on top of each other."""
    from hdengine import mesh, solid

    low, top = mesh.block([0, 1, 2], [0, 1], [0, 1]), mesh.block([0, 1, 2], [0, 1], [1, 2])
    n = len(low.points)
    points = np.vstack([low.points, top.points])
    held = np.zeros((2 * n, 3), bool)
    held[points[:, 2] == 0] = held[points[:, 2] == 2] = True
    chart = np.vstack([chart, chart]) if isinstance(chart, np.ndarray) and chart.shape == (n, 2) else chart
    if isinstance(facets_master, np.ndarray) and facets_master.dtype.kind == "i":
        facets_master = facets_master + n
    more["displacement"] = np.where(points[:, 2:] == 2, [[0, 0, -0.01]], 0.0)
    return solid.contact([solid.Body(low, young, 0.3), solid.Body(top, 1.0, 0.3)], solid.Face(facets_slave, chart),
                         solid.Face(facets_master, chart), held, **more)


def ridges(**numbers):
    """What a known sum says of its waves."""
    from hdengine import roughness

    known = roughness.Ridges(**numbers)
    return known.n_max, known.band


def specimen_fit(heights, spacing, name, lags):
    """A specimen, its size, numbers and fit."""
    from hdengine import specimen
    from hdengine.surfaces.texture import texture

    made = specimen.Specimen(heights, spacing, name)
    return made.size, texture(made).numbers, made.fit(lags=lags)


def joint_stiffness(pressure, shear, area, **numbers):
    """A joint made and asked."""
    import hdengine

    joint = hdengine.Joint(**numbers)
    return str(joint), joint.stiffness(pressure, shear, area)


def short_run(**more):
    """A run that is opened and closed."""
    import hdengine

    with hdengine.Run(**more) as run:
        return run.dof


def study_points(**more):
    """A study that is made and checked."""
    from hdengine import Study

    study = Study(**more)
    return study.points, str(study), study.check()
