# SPDX-License-Identifier: GPL-3.0-or-later
"""Why K_FTS lies above the catalogue's K3: each cause switched alone, and one after the other. Table of docs/evidence/cup_and_catalogue.md,
raw figures in bench/results/tooth_causes.json.

Usage: python bench/tooth_causes.py
"""
from paper_comparison import BALLS, ball_stiffness

import hdengine
from common import ROOT, put, table, write_record
from hdengine.catalogue import UNITS

SCENE = str(ROOT / "data/teeth.nml")
PARTS = (("flexspline rigid", {"material.flexspline_e": 2.09e14}), ("ring rigid", {"material.ring_e": 2.19e14}),
         ("pairs of teeth rigid", {"load.tooth_stiffness": 1e13}), ("ring held on the cam", {"wave_generator.ring_tangent": "follow"}),
         ("pressure angle 20°", {"load.pressure_angle_deg": 20.0}), ("pressure angle 30°", {"load.pressure_angle_deg": 30.0}),
         ("wall 0.32 mm", {"geometry.wall_thickness": 0.32e-3}))
CAUSES = (("bonded ring adds no stiffness (E / 100)", {"material.ring_e": 2.19e9}),
          (f"balls give way, {ball_stiffness() / BALLS / 1e6:.0f} N/µm each", {"wave_generator.ball_stiffness": ball_stiffness()}),
          ("outermost teeth 10 µm open", {"load.tooth_clearance": 10e-6}), ("20 pairs in mesh", {"load.tooth_pairs": 20}),
          ("pairs half as stiff", {"load.tooth_stiffness": 6.25e7}), ("bottom 0.4 mm", {"geometry.bottom_thickness": 0.4e-3}),
          ("cup 26.7 mm long", {"geometry.cup_length": 26.7e-3}), ("hub radius 6 mm", {"geometry.hub_radius": 6e-3}))


def solve(**keys):
    """Torque over rotation [N m/rad] at 5 N m."""
    with hdengine.Run(SCENE, **{"load.torque_steps": 1, **keys}) as run:
        *_, last = run
    return last.sums["torque_nm"] / last.sums["rotation_rad"]


def main():
    """Solve, write."""
    base, k3 = solve(), UNITS[14].k3_nm_per_rad
    alone = {name: solve(**keys) for name, keys in PARTS + CAUSES}
    keys, chain = {}, []
    for _, change in CAUSES:
        keys.update(change)
        chain.append((solve(**keys), solve(**keys, **{"load.torque": 1.0})))
    facts = {"base_nm_per_rad": base, "k3_nm_per_rad": k3, "ball_stiffness_n_per_m": ball_stiffness(), "alone_nm_per_rad": alone,
             "one_after_the_other_5_nm_1_nm": dict(zip((name for name, _ in CAUSES), chain))}
    write_record("tooth_causes", facts)

    def share(k):
        return f"{100 * (base / k - 1):+.0f} %"
    rows = [("scene as it stands", f"{base / 1e3:.1f}", "", "", "")]
    rows += [(name, f"{alone[name] / 1e3:.1f}", share(alone[name]), "", "") for name, _ in PARTS]
    rows += [(name, f"{alone[name] / 1e3:.1f}", share(alone[name]), f"{five / 1e3:.1f}", f"{one / 1e3:.1f}")
             for (name, _), (five, one) in zip(CAUSES, chain)]
    put("causes", table(("switch", "alone: K_FTS / (kN m/rad)", "compliance against the scene", "one after the other: 5 N m", "1 N m"), rows), "evidence/cup_and_catalogue")


if __name__ == "__main__":
    main()
