# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts of contact methods on problems with closed solutions, CalculiX beside the engine on the same meshes."""
import shutil
import time

import contact_cases as cc
import numpy as np
import peer_contact
from pareto_points import Chart, Point

STIFFNESS, STICK = 1e7, 1e6   # of CalculiX's penalty [N/mm3]: fifty moduli over a millimetre; the slope of sticking
FRICTION = 0.3
PATIENCE = 60                 # CPU seconds for one run of a peer
NOTHING = 1e3                 # error drawn for a run that ended without a result


def peers():
    """The methods of CalculiX, none where it is not installed."""
    return ("n2s", "s2s", "mortar") if shutil.which("ccx") else ()


def peer_point(method, setting, found, error):
    """A point of a peer; one that found nothing stands at the top of the chart."""
    return Point(f"CalculiX {method}", setting if found.done else f"{setting}: {found.trouble or 'no result'}", float(error) if found.done else NOTHING,
                 found.seconds, peer=True)


def shear_error(run, step):
    """Error of a shear field that was loaded only, against Cattaneo and Mindlin, in the norm of full slip."""
    a = np.sqrt(4 * run["force"][step] * run["radius"] / (np.pi * run["modulus"]))
    p0, y = 2 * run["force"][step] / (np.pi * a), run["y"]
    full = np.sqrt(((FRICTION * p0) ** 2 * np.maximum(0, 1 - (y / a) ** 2)).sum())
    ratio = min(1.0, abs(run["drag"][step]) / (FRICTION * run["force"][step]))
    exact = cc.mindlin_shear(y, a, p0, FRICTION, [ratio])
    return np.sqrt(((np.abs(run["shear"][step]) - exact) ** 2).sum()) / full


def line_contact(quick):
    """Hertz's line contact: error of the pressure field."""
    points = []
    for element, sizes in (("hex8i", (5, 10, 20) if quick else (5, 10, 20, 40)), ("hex20r", (5, 10) if quick else (5, 10, 20))):
        for m in sizes:
            start = time.process_time()
            found = cc.line_errors(cc.cylinder(m, element))
            points.append(Point(element, f"{m} cells in a", float(found["field"]), time.process_time() - start,
                                default=element == "hex8i" and m == 10))
    for method in peers():
        for m in (5, 10) if quick else (5, 10, 20):
            found, run = peer_contact.cylinder(method, m, "hex8i", stiffness=STIFFNESS, limit=PATIENCE)
            points.append(peer_point(f"{method}, C3D8I", f"{m} cells in a", found, run and cc.line_errors(run)["field"]))
    return Chart("line_contact", "Hertz line contact, pressure field",
                 "Contact needs five to ten cells in the half-width, whatever the element; n2s and mortar contact of CalculiX are as accurate.", points)


def cattaneo_mindlin(quick):
    """Partial slip of a line contact: error of the shear field."""
    points = []
    for m in (5, 10) if quick else (5, 10, 20):
        start = time.process_time()
        run = cc.cylinder(m, "hex8i", FRICTION, (0.5,))
        points.append(Point("hex8i", f"{m} cells in a", float(shear_error(run, 1)), time.process_time() - start, default=m == 10))
    for method in peers():
        for m in (5,) if quick else (5, 10):
            found, run = peer_contact.cylinder(method, m, "hex8i", FRICTION, (0.5,), stiffness=STIFFNESS, stick=STICK, increment=0.25, limit=PATIENCE)
            points.append(peer_point(f"{method}, C3D8I", f"{m} cells in a", found, run and shear_error(run, 0)))
    return Chart("cattaneo_mindlin", "Partial slip of a line contact, shear field",
                 "n2s and mortar contact of CalculiX reach the engine's error with ten cells in the half-width; surface to surface contact does not.",
                 points)


def pin_in_a_hole(quick):
    """Persson's pin in a hole with clearance: error of the pressure field."""
    points = []
    for element in ("hex8i", "hex20r"):
        for n in (5, 10) if quick else (5, 10, 15):
            start = time.process_time()
            run = cc.pin(n, element, 1e-3, 4e-3, 1.3)
            error = np.sqrt(((run["pressure"] - run["exact"]) ** 2).sum() / (run["exact"] ** 2).sum())
            points.append(Point(element, f"{4 * n} cells round the pin", float(error), time.process_time() - start, default=element == "hex8i" and n == 10))
    return Chart("pin_in_a_hole", "Pin in a hole with clearance, pressure field",
                 "With forty cells or more round the pin both elements hold the conforming contact; hex8i takes a tenth of the time.", points)


def rings(quick, ratio, start_angle):
    """Points of a press fit: root mean square of the radial displacement at the interface, ours and the peer's."""
    points = []
    for element, solid_name in (("hex8i", "C3D8I"), ("hex20r", "C3D20R")):
        for n in (24, 48) if quick else (24, 48, 96):
            outer, setting = round(ratio * n), f"{n} / {round(ratio * n)} divisions"
            start = time.process_time()
            found = cc.lame(n, outer, element, layers=n // 8, start=start_angle)
            points.append(Point(f"mortar, {element}", setting, float(found["displacement_rms"]), time.process_time() - start,
                                default=element == "hex8i" and n == 48))
            for method in peers():
                if n <= 48:   # n2s reads no *CLEARANCE; s2s takes whichever errs less, the interference told or as shape
                    found = [peer_contact.press_fit(method, told, n, outer, element, n // 8, start_angle, stiffness=STIFFNESS, limit=PATIENCE)
                             for told in {"n2s": (False,), "s2s": (True, False), "mortar": (True,)}[method]]
                    points.append(peer_point(f"{method}, {solid_name}", setting, *min(found, key=lambda f: np.nan_to_num(f[1], nan=NOTHING))))
    return points


def press_fit_matching(quick):
    """Lame's press fit of two rings whose meshes match."""
    return Chart("press_fit_matching", "Press fit of two rings, meshes match, displacement",
                 "Where facets match, every method of contact is as good as its elements; only n2s with quadratic ones is not.", rings(quick, 1, 0.0))


def press_fit(quick):
    """Lame's press fit of two rings whose meshes do not match."""
    return Chart("press_fit", "Press fit of two rings, meshes 1 : 1.5, displacement",
                 "Mortar contact keeps the order of the elements on meshes that do not match; with linear cells n2s and s2s ride on the corners of "
                 "the facets, s2s even where it is told the interference.",
                 rings(quick, 1.5, 0.3))
