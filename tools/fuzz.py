#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Damaged input for every reader: python tools/fuzz.py [--exe hdengine.x] [--count 300] [--seed 1] [--many 1000000 --build build]

A good file of each kind is changed at random (bytes turned, cut out, doubled, numbers of bad kinds put in) and given to the program (namelist,
command line, SDF, npy, columns, cam, tables, spectrum, fit, checkpoint) or, in this process, to the package (study, record, specimen). Each must
answer or end with a message and an exit code of the program, within 20 s, without a memory fault, backtrace or report of a sanitizer.
`--many` reads that many copies in one process a reader, by tests/fortran/hd_fuzz, which ninja builds on request, and a hundredth
by each of the package's.
"""
import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

import hdengine
from hdengine.record import Record
from hdengine.surfaces import specimen

ROOT = Path(__file__).resolve().parents[1]
SMALL = ["mesh.divisions=16", "mesh.band_facets=3", "load.torque_steps=1", "load.assembly_steps=1", "output.vtu=none"]
ODD = [b"nan", b"-1", b"1e999", b"2*5", b"/", b",", b";", b"'", b"99999999999999999999", b"\x00", b"\xff\xfe", b"&", b"=", b"\n", b"1+13", b"inf", b"0", b" "]
WORST = ("ERROR: AddressSanitizer", "runtime error", "Backtrace for", "Segmentation", "Traceback", "At line ")


def changed(data, lot):
    """A copy of the bytes with one to four changes."""
    data = bytearray(data)
    for _ in range(lot.randint(1, 4)):
        at = lot.randrange(len(data) + 1)
        kind = lot.randrange(4)
        if kind == 0 and at < len(data):
            data[at] ^= 1 << lot.randrange(8)
        elif kind == 1:
            del data[at:at + lot.choice((1, 2, 8, len(data) // 2))]
        elif kind == 2:
            data[at:at] = lot.choice(ODD)
        else:
            data[at:at] = data[at:at + lot.choice((1, 9, 100))]
    return bytes(data)


def seeds(folder, exe):
    """Good files by kind, and the words with which the program reads each."""
    scene, heights = ROOT / "data/cd14.nml", np.random.default_rng(1).normal(size=(12, 14)) * 1e-7
    specimen.save(folder / "a.sdf", specimen.Specimen(heights, (1e-6, 1e-6)))
    np.save(folder / "a.npy", heights)
    np.savetxt(folder / "a.csv", heights[:, :2], delimiter=",")
    angle = np.arange(0, 360, 10)
    (folder / "cam.csv").write_text("theta_deg,radius_m\n" + "".join(f"{a},{16.4e-3 + 2e-4 * np.cos(2 * np.radians(a)):.9f}\n" for a in angle))
    (folder / "table.csv").write_text("pressure_pa,k_n_pa_per_m\n1e5,1e12\n1e7,5e13\n1e9,1e15\n")
    (folder / "spectrum.csv").write_text("q_per_m,height_variance_m2\n1e4,1e-14\n1e5,1e-15\n1e6,1e-16\n")
    (folder / "fit").mkdir()
    (folder / "fit/scene.nml").write_text("&joint fractal_dimension = 2.5, roughness = 2e-7, sample_length = 5e-4, shortest_wavelength = 1e-6 /\n")
    run = folder / "run"
    subprocess.run([exe, scene, *SMALL, "load.torque_steps=9", "--out", run, "-q"], stderr=subprocess.DEVNULL)
    whole = subprocess.run([exe, scene, *SMALL, "load.torque_steps=400", "solver.time_limit_s=0.3", "--out", run, "-q", "--force"], stderr=subprocess.DEVNULL)
    known = {
        "namelist": (scene.read_bytes(), "in.nml", ["{f}", *SMALL, "--check"]),
        "command line": (b"geometry.wall_thickness=3.6e-4", None, [str(scene), *SMALL, "{d}", "--check"]),
        "SDF": ((folder / "a.sdf").read_bytes(), "in.sdf", ["{g}", "fit.first_file={f}"]),
        "npy": ((folder / "a.npy").read_bytes(), "in.npy", ["{g}", "fit.first_file={f}", "fit.dx=1e-6"]),
        "columns": ((folder / "a.csv").read_bytes(), "in.csv", ["{g}", "fit.first_file={f}", "fit.dx=1e-6"]),
        "cam": ((folder / "cam.csv").read_bytes(), "in.csv", [str(scene), *SMALL, "wave_generator.cam=table", "wave_generator.cam_file={f}"]),
        "table": ((folder / "table.csv").read_bytes(), "in.csv", [str(scene), *SMALL, "joint.model=table", "joint.table_file={f}"]),
        "spectrum": ((folder / "spectrum.csv").read_bytes(), "in.csv", [str(scene), *SMALL, "joint.model=spectrum", "joint.spectrum_file={f}"]),
        "fit": ((folder / "fit/scene.nml").read_bytes(), "fit/scene.nml", [str(scene), *SMALL, "joint.from_fit={p}"])}
    if whole.returncode == 7 and (run / "checkpoint.bin").exists():
        known["checkpoint"] = ((run / "checkpoint.bin").read_bytes(), "run/checkpoint.bin", [str(scene), *SMALL, "load.torque_steps=400",
                                                                                            "solver.time_limit_s=0.2", "--resume"])
    (folder / "good.nml").write_text("&fit first_lag = 1 /\n")
    return known


def by_program(exe, folder, name, known, lot):
    """What is wrong with how the program ends on one damaged file; '' if nothing."""
    data, place, words = known[name]
    damaged = changed(data, lot)
    path = folder / (place or "none")
    if place:
        path.write_bytes(damaged)
    text = damaged.replace(b"\0", b"")
    out = folder / ("run" if name == "checkpoint" else "out")
    command = [os.fsencode(w.format(f=path, g=folder / "good.nml", p=path.parent, d="{d}")).replace(b"{d}", text) for w in words]
    try:
        done = subprocess.run([os.fsencode(exe), *command, b"--out", os.fsencode(out), b"-q", *([] if "--resume" in words else [b"--force"])],
                              capture_output=True, timeout=100, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        return "no end within 100 s"
    said = (done.stdout + done.stderr).decode(errors="replace")
    if done.returncode not in (0, 2, 3, 4, 5, 6, 7) or any(word in said for word in WORST):
        return f"code {done.returncode}: {said[-600:]}"
    return "" if done.returncode == 0 or said.strip() else f"code {done.returncode} without a word"


def by_package(folder, name, lot):
    """The same of the package, in this process."""
    good = {"study": (ROOT / "data/fig11_torque.toml", "s.toml", hdengine.Study.read), "record": (ROOT / "data/torque_record.csv", "r.csv", Record.read),
            "specimen": (folder / "a.sdf", "s.sdf", specimen.read)}
    source, place, reader = good[name]
    (folder / place).write_bytes(changed(source.read_bytes()[:4000], lot))
    start = time.process_time()  # a busy machine is no fault
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            reader(folder / place)
    except hdengine.HdengineError:
        pass
    except Exception as error:  # noqa: BLE001  (which is what is looked for)
        return f"{type(error).__name__}: {error}"
    return "" if time.process_time() - start < 20 else "no end within 20 s"


def by_process(build, folder, known, many, seed):
    """Copies that each Fortran reader takes in one process; what it says where it fails."""
    slow = ("namelist", "command line")     # milliseconds a copy, for a scene has 250 keys
    readers = {r: many // 20 if r in slow else 9 * many // 40 for r in (*slow, "SDF", "npy", "columns", "cam")}
    for reader, count in readers.items():
        (folder / "good").write_bytes(known[reader][0])
        done = subprocess.run([Path(build) / "tests/fortran/hd_fuzz", reader, folder / "good", str(count), str(seed), folder / "copy"],
                              capture_output=True, text=True, errors="replace")
        print(done.stdout.strip(), flush=True)
        if done.returncode or any(word in done.stderr for word in WORST):
            shutil.copy(folder / "copy", f"fuzz-{reader.replace(' ', '-')}")
            yield f"{reader}: code {done.returncode}, copy kept as fuzz-{reader.replace(' ', '-')}: {done.stderr[-600:]}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--exe", default=None)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--many", type=int, default=0)
    parser.add_argument("--build", default=ROOT / "build")
    args = parser.parse_args()
    import hdengine_x
    exe, lot = args.exe or hdengine_x.PROGRAM, random.Random(args.seed)
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    folder, found, counts = Path(tempfile.mkdtemp()), [], {}
    try:
        known = seeds(folder, exe)
        package = ["study", "record", "specimen"]
        kinds = [*known, *package]
        if args.many:
            found += (wrong := list(by_process(args.build, folder, known, args.many, args.seed)))
            for line in wrong:
                print(line, flush=True)
            kinds, args.count = package, max(args.count, args.many // 100 * len(package))
        for k in range(args.count):
            name = kinds[k % len(kinds)]
            wrong = by_program(exe, folder, name, known, lot) if name in known else by_package(folder, name, lot)
            counts[name] = counts.get(name, 0) + 1
            if wrong:
                found.append(name)
                print(f"{name}, execution {k}, seed {args.seed}: {wrong}", flush=True)
    finally:
        shutil.rmtree(folder)
    print(f"{sum(counts.values())} executions of {len(counts)} readers, {len(found)} wrong")
    return min(1, len(found))


if __name__ == "__main__":
    sys.exit(main())
