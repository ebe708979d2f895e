# SPDX-License-Identifier: GPL-3.0-or-later
"""K_TS by Eq. 45 and by the joint as contact law, the causes of the difference one after the other: table and figure of
docs/evidence/causes.md, raw figures in bench/results/coupled_law.json.

All torque goes through the contact (support 'bearing'). The coupled K_TS is the torque over the turn that the joint adds to
that of hard contact. Slip is parted from elasticity by friction that grows to 10 when the torque sets in.

Usage: python bench/coupled_law.py [--work DIR]
"""
import argparse
import tempfile
import warnings
from pathlib import Path

import numpy as np

import hdengine
from common import ROOT, put, read_record, table, write_record
from hdengine import torsion
from hdengine.figures.style import new_axes, styled
from hdengine.results import facet_stiffness

SCENE = str(ROOT / "data/cd14.nml")
MESHES = {"86 x 15": {}}
STICK = {"contact.torque_friction": 10.0}


def runs(work, mesh, name):
    """Runs by (law, slip allowed)."""
    found = {}
    for law in ("hard", "joint_elastic", "joint"):
        for slip in (True, False)[:1 if law == "joint_elastic" else 2]:
            folder = work / f"coupled_{name.replace(' ', '')}_{law}_{'slip' if slip else 'stick'}.out"
            if not (folder / "summary.json").is_file():
                keys = {"load.support": "bearing", "contact.law": law, "output.vtu": "none", **mesh, **({} if slip else STICK)}
                hdengine.run(SCENE, folder, True, **keys)
            found[law, slip] = hdengine.load(folder)
    return found


def eq45(result, sheared=True, normal=True):
    """K_TS of every step from the stored tractions [N m/rad], with or without shear in K_T and the normal part."""
    k_n, k_t = facet_stiffness(result.contact, result.joint, sheared)
    return torsion.torsional_stiffness(k_n * normal, k_t, result.vectors("x_m", "y_m", "z_m"), result.vectors("n_x", "n_y", "n_z"))


def own_energy(result, start):
    """T^2 / sum(q^2 / K_T): the joint's compliance under the shear that the torque adds in this run [N m/rad]."""
    c = result.contact
    _, k_t = result.joint.stiffness(c["pressure_pa"], 0.0, c["area_m2"])  # means, as the law has them: no power means at ends of contact
    square = sum((c[f"traction_{a}_pa"] - c[f"traction_{a}_pa"][start])**2 for a in ("theta", "z")) * c["area_m2"]**2
    work = np.divide(square, k_t, out=np.zeros_like(square), where=k_t > 0).sum(axis=1)
    return result.torque_nm[start + 1:]**2 / work[start + 1:]


def rear_row(result):
    """Shares of the rearmost row of facets in K_T and in the torque, in per cent."""
    c, torque = result.contact, result.steps["torque_nm"]
    start = int(np.flatnonzero(torque > 0)[0]) - 1
    k_t = facet_stiffness(c, result.joint, sheared=False)[1][-1].reshape(result.shape).sum(axis=0)
    shear = ((c["traction_theta_pa"][-1] - c["traction_theta_pa"][start]) * c["area_m2"][-1]).reshape(result.shape).sum(axis=0)
    return [float(100 * v[-1] / v.sum()) for v in (k_t, shear)]


def unloading(result):
    """Facets whose shear shrinks under the last torque: their share in k_t, and by how much Masing's rule would raise their flexibility
    over the path, k_t(P, |q - q_0| / 2) in place of k_t(P, 0), in the mean and at most [per cent]."""
    c, friction = result.contact, result.scene["contact.friction"]
    start = int(np.flatnonzero(result.torque_nm > 0)[0]) - 1
    shear = result.vectors("traction_theta_pa", "traction_z_pa")
    before, after = (np.linalg.norm(shear[i], axis=-1) for i in (start, -1))
    p, area = c["pressure_pa"][-1], c["area_m2"][-1]
    closed = p > 1e-3 * p.max()
    shrunk = closed & (after < before) & (after < 0.999 * friction * p)
    half = np.minimum(np.linalg.norm(shear[-1] - shear[start], axis=-1) / 2, 0.999 * friction * p)
    k_0 = result.joint.stiffness(p, 0.0, area)[1]
    rise = np.mean([k_0[shrunk] / result.joint.stiffness(p, part * half, area)[1][shrunk] - 1 for part in np.linspace(0, 1, 9)], axis=0)
    return [float(100 * v) for v in (k_0[shrunk].sum() / k_0[closed].sum(), np.average(rise, weights=k_0[shrunk]), rise.max())]


def separate(found):
    """All stiffnesses over the torque [N m/rad], 'printed' in [N]."""
    hard, joint, elastic, rigid, stuck = (found[key] for key in (("hard", True), ("joint", True), ("joint_elastic", True),
                                                                 ("hard", False), ("joint", False)))
    start = int(np.flatnonzero(hard.steps["load_factor"] >= 1 - 1e-9)[0])
    torque, after = hard.torque_nm[start:], slice(start + 1, None)

    def added(soft, stiff):
        return (soft.steps["rotation_rad"] - stiff.steps["rotation_rad"])[start:]
    free, linear, held = added(joint, hard), added(elastic, hard), added(stuck, rigid)
    return {
        "torque_nm": torque[1:], "Eq. 45, hard contact": eq45(hard)[after], "pressures of the coupled model": eq45(joint)[after],
        "without the normal part": eq45(joint, normal=False)[after], "K_T of the first slip, no shear": eq45(joint, False, False)[after],
        "shear as the bodies pass it on": own_energy(stuck, start), "elastic bodies, no slip: secant": torque[1:] / held[1:],
        "slip, k_t without its fall: secant": torque[1:] / linear[1:], "k_t falls under shear: secant": torque[1:] / free[1:],
        "tangent of the coupled model": np.diff(torque) / np.diff(free),
        "slip counts: secant against glued faces": joint.steps["k_ts_secant_nm_per_rad"][after],
        "slip counts: tangent against glued faces": joint.steps["k_ts_tangent_nm_per_rad"][after],
        "no slip, tangent": np.diff(torque) / np.diff(held), "printed": hard.torsional_stiffness()[1][after]}


CHAIN = ("Eq. 45, hard contact", "pressures of the coupled model", "without the normal part", "K_T of the first slip, no shear",
         "shear as the bodies pass it on", "elastic bodies, no slip: secant", "slip, k_t without its fall: secant",
         "k_t falls under shear: secant", "tangent of the coupled model", "slip counts: secant against glued faces",
         "slip counts: tangent against glued faces")
WHY = ("This is Eq. 45 on the facets of hard contact.", "The joint gives way, so the pressures even out.", "The normals of the pressed faces are radial.",
       "Eq. 45 takes k_t under all the shear of a facet, that of the assembly too. A change of the torque meets a stiffer joint.",
       "Eq. 45 turns all facets by one angle, so the rear row takes {:.0f} % of the torque. The bodies send it {:.0f} %.",
       "As the joint moves the shear, cup and ring themselves turn more.", "Facets near µp slip.",
       "k_t falls where shear grows. Here nearly all points slide from the assembly on, or their shear shrinks.",
       "The next newton metre finds more of them slipping.",
       "Hard contact slips too, so the difference to it leaves slip out. Glued faces do not slip.", "This is the number that a test can measure.")


@styled
def draw(s):
    """K_TS over the torque, and the chain of causes at the last torque."""
    figure, (left, right) = new_axes(2, 1, figsize=(9, 10.5))
    t = s["torque_nm"]
    for name, label, style in (("Eq. 45, hard contact", "Eq. 45 (default)", "C0o-"), ("elastic bodies, no slip: secant",
                               "coupled, no slip, secant", "C2^--"), ("k_t falls under shear: secant", "coupled less hard contact, secant", "C1s-"),
                               ("tangent of the coupled model", "coupled less hard contact, tangent", "C3v-"),
                               ("slip counts: secant against glued faces", "coupled less glued faces, secant", "C4D-"),
                               ("slip counts: tangent against glued faces", "coupled less glued faces, tangent", "C5P-")):
        left.plot(t, s[name] / 1e6, style, label=label)
    left.set_xlabel("torque / N m")
    left.set_ylabel("$K_{TS}$ / (MN m/rad)")
    left.set_ylim(0, 6)
    other = left.twinx()
    other.grid(False)
    left.plot([], [], "k:", label="Eq. 45 as printed (right scale)")
    other.plot(t, s["printed"] / 1e6, "k:")
    other.set_ylabel("Eq. 45 as printed / MN")
    other.set_ylim(0, 360)
    left.legend(fontsize=11, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)
    right.grid(axis="y", visible=False)
    values = [s[name][-1] / 1e6 for name in CHAIN]
    for i, value in enumerate(values):
        before = values[i - 1] if i else 0
        right.barh(-i, value - before, left=before, color="0.5" if i == 0 else "C3" if value < before else "C0", height=0.6)
        right.plot([value, value], [-i - 0.7, -i + 0.3], "k", lw=0.8)
        right.text(max(value, before) + 0.08, -i, f"{value:.2f}", va="center", fontsize=11)
    right.set_yticks([-i for i in range(len(CHAIN))], CHAIN, fontsize=11)
    right.set_xlim(0, 6)
    right.set_xlabel(f"$K_{{TS}}$ at {t[-1]:g} N m / (MN m/rad)")
    figure.savefig(ROOT / "docs/figures/coupled.png")


def show(s, rear):
    """Tables of the page, K_TS and what each line changes, and the figure."""
    rows = [[str(i), name, *(f"{v / 1e6:.2f}" for v in s[name]), f"{100 * (s[name][-1] / s[before][-1] - 1):+.0f} %".replace("-0 %", "0 %") if before else ""]
            for i, (name, before) in enumerate(zip(CHAIN, (None, *CHAIN)), 1)]
    rows.append(["", "Eq. 45 as printed / MN", *(f"{v / 1e6:.0f}" for v in s["printed"]), ""])
    put("coupled", table(("", "K_TS / (MN m/rad)", *(f"{t:g} N m" for t in s["torque_nm"]), "step at 5 N m"), rows) + "\n\n"
        + "\n".join(f"{i}. {why.format(*rear)}" for i, why in enumerate(WHY, 1)), "evidence/causes")
    draw(s)


def main():
    """Solve, write, draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", help="folder for the runs")
    parser.add_argument("--redraw", action="store_true", help="figure and tables from the record")
    options = parser.parse_args()
    if options.redraw:
        record = read_record("coupled_law")
        show({name: np.array(values) for name, values in record["86 x 15"].items()}, record["rear_row_percent_of_k_t_and_torque"])
        return
    work = Path(options.work or tempfile.mkdtemp())
    warnings.simplefilter("ignore", hdengine.JointWarning)
    found = {name: runs(work, mesh, name) for name, mesh in MESHES.items()}
    results = {name: separate(f) for name, f in found.items()}
    rear = rear_row(found["86 x 15"]["joint", False])
    write_record("coupled_law", {
        "rear_row_percent_of_k_t_and_torque": rear, "unloading_percent_of_k_t_and_masing_mean_and_most":
         unloading(found["86 x 15"]["joint", True]), **{name: {k: v.tolist() for k, v in s.items()} for name, s in results.items()}})
    show(results["86 x 15"], rear)


if __name__ == "__main__":
    main()
