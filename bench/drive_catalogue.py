# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole drive beside the catalogue, and what its unknown inputs change. Writes bench/results/drive_catalogue.json and
docs/figures/drive_catalogue.png.

Usage: python bench/drive_catalogue.py [sizes] [inputs] [draw]; without words the first two
"""
import sys
import tempfile

import numpy as np

from common import DATA, read_record, save_figure, solve, write_part
from hdengine import load
from hdengine.catalogue import UNITS
from hdengine.figures.style import new_axes, styled

SIZES = (11, 14, 17, 20, 25, 32, 40)
ARCMIN = np.degrees(1) * 60
DRAWN = 14   # the size whose loop is drawn
FAST = {"mesh.divisions": 48, "mesh.band_facets": 8}
RISE = {**FAST, "loop.torques": 14, "load.torque_steps": 7}
UNKNOWN = (
    ("19 balls", {"bearing.balls": 19}), ("23 balls", {"bearing.balls": 23}), ("balls 2.8 mm", {"bearing.ball_diameter": 2.8e-3}),
    ("balls 3.6 mm", {"bearing.ball_diameter": 3.6e-3}), ("outer conformity 0.515", {"bearing.outer_conformity": 0.515}),
    ("outer conformity 0.60", {"bearing.outer_conformity": 0.60}), ("clearance of the balls 5 µm", {"bearing.clearance": 5e-6}),
    ("teeth closed", {"load.tooth_clearance": 0}), ("outermost teeth 20 µm open", {"load.tooth_clearance": 20e-6}),
    ("outermost teeth 40 µm open", {"load.tooth_clearance": 40e-6}), ("pairs half as stiff", {"load.tooth_stiffness": 6.25e7}),
    ("pressure angle 20°", {"load.pressure_angle_deg": 20}), ("pressure angle 30°", {"load.pressure_angle_deg": 30}),
    ("ring 0.8 mm thick", {"geometry.ring_thickness": 0.8e-3}), ("ring 1.2 mm thick", {"geometry.ring_thickness": 1.2e-3}),
    ("ring and band 6 mm wide", {"geometry.band_length": 6e-3}), ("hub radius 6 mm", {"geometry.hub_radius": 6e-3}),
    ("cup 26.7 mm long", {"geometry.cup_length": 26.7e-3}), ("bottom 0.4 mm", {"geometry.bottom_thickness": 0.4e-3}),
    ("wall 0.32 mm", {"geometry.wall_thickness": 0.32e-3}), ("rim 0.36 mm", {"geometry.rim_thickness": 0.36e-3}),
    ("interference 0", {"wave_generator.interference": 0}), ("friction 0.05", {"contact.friction": 0.05}))


def run(scene, keys):
    """Summary and loop of a run."""
    with tempfile.TemporaryDirectory() as folder:
        _, command = solve(DATA / scene, *(f"{k}={v}" for k, v in keys.items()), out=f"{folder}/r")
        if command.code != 0:
            raise SystemExit(command.text)
        result = load(f"{folder}/r")
        return result.summary | {"cpu_s": command.cpu_s}, result.loop


def three(results):
    """K1, K2, K3 [kN m/rad]."""
    return [float(f"{results[f'k{i}_nm_per_rad'] / 1e3:.4g}") for i in (1, 2, 3)]


def sizes():
    """The loop of every size on the paper's mesh."""
    rows = []
    for size in SIZES:
        summary, loop = run(f"drive{size}.nml", {})
        r, unit = summary["results"], UNITS.get(size)
        row = {"hysteresis_arcmin": ARCMIN * r["hysteresis_rad"], "lost_motion_arcmin": ARCMIN * r["lost_motion_rad"],
               "ball_force_max_n": r["ball_force_max_n"], "tooth_force_max_n": r["tooth_force_max_n"], "cpu_s": summary["cpu_s"],
               "memory_mb": summary["peak_memory_mb"], "unbalanced": (r["loop_work_j"] - r["loop_stored_j"]) / r["loop_dissipated_j"] - 1}
        rows.append({"size": size, "ours": three(r), "catalogue": [k / 1e3 for k in (unit.k1_nm_per_rad, unit.k2_nm_per_rad, unit.k3_nm_per_rad)] if unit else None}
                    | {name: float(f"{value:.4g}") for name, value in row.items()})
        if size == DRAWN:
            rows[-1] |= {name: [float(f"{x:.6g}") for x in loop[name]] for name in ("torque_nm", "angle_rad")}
    return rows


def inputs():
    """K1 to K3 of size 14 with one input changed."""
    base = three(run("drive14.nml", RISE)[0]["results"])
    rows = [{"input": "as it stands", "k": base}]
    rows += [{"input": name, "k": three(run("drive14.nml", {**RISE, **keys})[0]["results"])} for name, keys in UNKNOWN]
    chain = {}
    for name in ("hub radius 6 mm", "cup 26.7 mm long", "interference 0", "pressure angle 30°", "outermost teeth 20 µm open"):
        chain.update(dict(UNKNOWN)[name])
        rows.append({"input": f"+ {name}", "k": three(run("drive14.nml", {**RISE, **chain})[0]["results"])})
    return rows


@styled
def draw(rows):
    """Loop of size 14 beside the catalogue's chords; K over the size."""
    figure, axes = new_axes(1, 2, figsize=(11, 4.4))
    row = next(r for r in rows if r["size"] == DRAWN)
    torque = np.array(row["torque_nm"])
    axes[0].plot(ARCMIN * np.array(row["angle_rad"]), torque, label="whole drive")
    line = np.linspace(-14, 14, 200)
    axes[0].plot(ARCMIN * UNITS[14].angle(line), line, "C3--", label="catalogue, K1 K2 K3")
    axes[0].set_xlabel("angle / arc minute")
    axes[0].set_ylabel("torque / N m")
    axes[0].set_title("size 14, ratio 100", fontsize=12)
    axes[0].legend()
    for i, colour in enumerate(("C0", "C1", "C2")):
        axes[1].loglog([r["size"] for r in rows], [r["ours"][i] for r in rows], "o-", color=colour, label=f"K{i + 1}")
        known = [r for r in rows if r["catalogue"]]
        axes[1].loglog([r["size"] for r in known], [r["catalogue"][i] for r in known], "s--", color=colour, mfc="none",
                       label=f"K{i + 1}, catalogue")
    axes[1].set_xlabel("size")
    axes[1].set_ylabel("stiffness / (kN m/rad)")
    axes[1].set_xticks(SIZES, [str(s) for s in SIZES])
    axes[1].set_yticks((5, 10, 20, 50, 100, 200), ["5", "10", "20", "50", "100", "200"])
    axes[1].minorticks_off()
    axes[1].legend(fontsize=10, ncols=2, loc="upper left")
    save_figure(figure, "drive_catalogue")


def main():
    """Solve, write, draw."""
    for name, part in (("sizes", sizes), ("inputs", inputs)):
        if name in (sys.argv[1:] or ("sizes", "inputs")):
            write_part("drive_catalogue", name, part(), threads=1)
    draw(read_record("drive_catalogue")["sizes"])


if __name__ == "__main__":
    main()
