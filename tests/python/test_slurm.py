# SPDX-License-Identifier: GPL-3.0-or-later
"""The Slurm blocks of the pages run on a real Slurm of one node (tools/slurm_node.sh). They need root and Debian's slurm-wlm, which ./hd test installs."""
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from test_pages import blocks, on_slurm, shell

from conftest import ROOT, call, executable

pytestmark = pytest.mark.skipif(os.geteuid() != 0 or not all(Path("/usr/sbin", name).exists() for name in ("munged", "slurmctld", "slurmd")),
                                reason="needs root and slurm-wlm")
NODE = f"PATH=/usr/sbin:$PATH {ROOT}/tools/slurm_node.sh"
WAIT = "timeout 200 sh -c 'while squeue -h | grep -q .; do sleep 0.1; done'; scontrol -o show job"


@pytest.fixture(scope="module", autouse=True)
def node(tmp_path_factory):
    """Skip where Slurm itself cannot start, as without /sys, with what it says."""
    done = subprocess.run(["bash", "-c", f"{NODE} {tmp_path_factory.mktemp('node')} true"], capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"Slurm does not start here: {' '.join(done.stderr.split()[-20:])}")


def submitted(page, folder, more=""):
    """States of the jobs after the page's Slurm blocks and more ran in the folder."""
    for name in ("data", "hpc"):
        (folder / name).symlink_to(ROOT / name)
    (folder / ".venv").symlink_to(sys.prefix)
    (folder / "modules").mkdir()
    (folder / "modules/site").write_text('#%Module\nputs stderr "site is loaded"\n')   # where there is no `module`, a function of its name
    site = f"module() {{ echo site is loaded; }}\nexport -f module\nexport HDENGINE_MODULES=site MODULEPATH={folder}/modules\n"
    (folder / "block.sh").write_text(f"set -e\n{site}" + "".join(text for _, text, _ in blocks(page) if on_slurm(text)) + more + WAIT)
    printed = shell(f"{NODE} {folder}/node bash block.sh", folder)
    return printed.count("JobState=COMPLETED"), printed


def test_run_and_study_on_slurm(tmp_path):
    """The page of studies submits one run, one study with three rows for each of four points, and the study's shards: all complete, with one table."""
    page = "docs/howto/study.md"
    (tmp_path / "w.toml").write_text(next(text for _, text, _ in blocks(page) if text.startswith("# w.toml")))
    array = "sbatch --array=1-2 hpc/study_array.slurm w.toml"
    assert array.replace("1-2", "1-8") in (ROOT / page).read_text()
    done, printed = submitted(page, tmp_path, f"{array} --out shards.out\n")
    logs = "".join(log.read_text() for log in tmp_path.glob("slurm-*.out"))
    assert done == 4 and printed.count("Requeue=1") == 4 and logs.count("site is loaded") >= 4, printed + logs
    run, = tmp_path.glob("cd14-*.out")
    assert json.loads((run / "summary.json").read_text())["status"] == "complete" and (run / "pressure_band.png").exists(), logs
    assert len((tmp_path / "w.out/study.csv").read_text().splitlines()) == 1 + 4 * 3
    collected = shell(f"{sys.executable} -m hdengine study w.toml --out shards.out --collect", tmp_path)
    assert (tmp_path / "shards.out/study.csv").read_bytes() == (tmp_path / "w.out/study.csv").read_bytes(), collected


def test_job_resumes_on_slurm(tmp_path):
    """The page of resuming submits a stopped run again by the name of its folder: it goes on from its checkpoint and completes."""
    limit = 0.1
    while not (tmp_path / "cd14-4711.out/checkpoint.bin").exists():
        stopped = call(executable(), ROOT / "data/cd14.nml", f"solver.time_limit_s={limit}", "--out", tmp_path / "cd14-4711.out", "--force", "-q")
        assert stopped.returncode == 7
        limit *= 1.3
    done, printed = submitted("docs/howto/resume.md", tmp_path)
    log, = tmp_path.glob("slurm-*.out")
    assert done == 1 and "\nresumed " in log.read_text(), printed + log.read_text()
    assert json.loads((tmp_path / "cd14-4711.out/summary.json").read_text())["status"] == "complete"
