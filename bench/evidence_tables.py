#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of the pages of docs/evidence on elements, contact, meshes, solvers and the planner, made of the records of bench/results.

Every table ends with a line that names its record and the engine that made it. Usage: bench/evidence_tables.py; run it after a bench script
has written its record. tests/python/test_evidence.py holds pages and records together.
"""
import json

import evidence_elements as elements
import evidence_joint as joint
import evidence_scenes as scenes

from common import DATA, RESULTS, ROOT, put, table

# records that were written before records named their commit
EARLIER = {"peer_hub_80_slopes": "21 November 2026", "joint_calibration": "21 November 2026"}


def records(name):
    """Paths of a record, none if it was not made."""
    return [*RESULTS.glob(f"{name}.json*"), *DATA.glob(f"{name}.json")]


def origin(name):
    """The line below a table: its record, and the engine and the machine that made it."""
    path = records(name)[0]
    text = path.read_text()
    whole = json.loads(text.splitlines()[-1] if path.suffix == ".jsonl" else text)
    made = whole.get("provenance", {}) if isinstance(whole, dict) else {}
    return (f"Record: `{path.relative_to(ROOT)}`, engine `{made['commit']}`, {made['machine']}." if "commit" in made else
            f"Record: `{path.relative_to(ROOT)}`, engine of {EARLIER[name]}.")


TABLES = {  # marker: page, record, builder
    "joint-shear": ("joint_shear", "joint_shear", joint.shear),
    "joint-spot": ("joint_shear", "joint_shear", joint.spot),
    "joint-peers": ("joint_shear", "joint_shear", joint.peers),
    "joint-ten": ("joint_law", "joint_law", joint.ten),
    "measured-maps": ("joint_law", "joint_law", joint.measured_maps),
    "calibration": ("joint", "joint_calibration", joint.calibration),
    "joint-models": ("joint_k_ts", "joint_models", joint.models),
    "joint-bands": ("joint_k_ts_band", "joint_band", joint.bands),
    "joint-shares": ("joint_k_ts_band", "joint_band", joint.shares),
    "joint-measured": ("joint_measured", "joint_measured", joint.measured),
    "element-errors": ("elements", "elements", elements.element_errors),
    "element-agreement": ("elements", "elements", elements.element_agreement),
    "closed-solutions": ("contact_standards", "contact_standards", elements.closed_solutions),
    "newton": ("newton", "newton_history", scenes.newton),
    "torque-steps": ("numerical_parameters", "step_study", scenes.torque_steps),
    "parameters": ("numerical_parameters", "numerical_parameters", scenes.parameters),
    "balance": ("contact_scene", "balance_study", scenes.balance),
    "peer-hub": ("contact_scene", "peer_hub_215", scenes.peer_hub),
    "stick-slopes": ("contact_scene", "peer_hub_80_slopes", scenes.stick_slopes),
    "rim": ("contact_scene", "rim_study", scenes.rim),
    "slip": ("contact_scene", "slip_study", scenes.slip),
    "default-scene": ("contact_scene", "default_study", scenes.default_scene),
    "cam-orders": ("premises", "cam_orders", scenes.cam_orders),
    "load-path": ("premises", "explained", scenes.load_path),
    "kinematics": ("kinematics", "peer_scenes", scenes.kinematics),
    "kinematics-map": ("kinematics", "kinematics_map", scenes.kinematics_map),
    "drive-kinematics": ("kinematics_drive", "drive_kinematics", scenes.drive_kinematics),
    "meshes": ("meshes", "mesh_study", scenes.meshes),
    "settles": ("meshes", "mesh_study", scenes.settles),
    "layers": ("meshes", "layer_study", scenes.layers),
    "swap": ("mesh_orders", "swap_study", scenes.swap),
    "orders": ("mesh_orders", "mesh_orders", scenes.orders),
    "edges": ("meshes", "edge_study", scenes.edges),
    "cost": ("solvers", "cost_over_size", scenes.cost),
    "choice": ("solvers", "solver_choice", scenes.choice),
    "teeth": ("teeth_and_records", "teeth_study", scenes.teeth),
    "random-scenes": ("robustness", "random_scenes", scenes.random_scenes),
    "options": ("robustness", "random_scenes", scenes.options),
    "hard-scenes": ("robustness", "peer_scenes", scenes.hard_scenes),
    "promises": ("planner_promises", "promised_scenes", scenes.promises),
    "promised-groups": ("planner_promises", "promised_scenes", scenes.promised_groups),
    "promised-drives": ("planned_drives", "promised_drives", scenes.promised_drives),
    "promised-results": ("planner_results", "promised_scenes", scenes.promised_results),
}


def text_of(marker):
    """What stands between the markers of a table."""
    _, record, build = TABLES[marker]
    return f"{table(*build())}\n\n{origin(record)}"


if __name__ == "__main__":
    for marker, (page, record, _) in TABLES.items():
        if records(record):
            put(marker, text_of(marker), f"evidence/{page}")
        else:
            print(f"no record {record}")
