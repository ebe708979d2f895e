#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Submit the jobs of hpc/ to a real Slurm of one node, as root, after  apt-get install slurm-wlm munge;  ./hd setup
# Proves beyond the tests (tests/python/test_slurm.py): a job that is cancelled leaves a summary that says so; a study submitted again goes on.
set -euo pipefail
cd "$(dirname "$0")/.."
if [ -z "${SLURM_CONF:-}" ]; then
  exec tools/slurm_node.sh "$(mktemp -d)" "$0"
fi
work=$(dirname "$SLURM_CONF")
sinfo
mesh="mesh.divisions=24 mesh.band_facets=4"
submit() { sbatch --parsable --mem=1G --output="$work/%j.log" "$@"; }
wait_for() { while squeue -h -j "$1" 2>/dev/null | grep -q .; do sleep 1; done; }
fail() { echo "failed: $1"; tail -n 20 "$work"/*.log; exit 1; }

run=$(submit hpc/run.slurm data/cd14.nml $mesh)
wait_for "$run"
grep -q '"status": "complete"' "cd14-$run.out/summary.json" || fail "run"
test -f "cd14-$run.out/pressure_band.png" || fail "figures of the run"

long=$(submit hpc/run.slurm data/cd14.nml load.torque_steps=400 output.vtu=none solver.method=newton)
until test -f "cd14-$long.out/history.csv" -o -f "cd14-$long.out/history.csv.part"; do sleep 1; done
sleep 5
scancel --signal=TERM "$long"
wait_for "$long"
grep -q '"status": "stopped' "cd14-$long.out/summary.json" || fail "cancelled run"

cat > "$work/small.toml" <<STUDY
[study]
scene = "$PWD/data/cd14.nml"
rows = "last"
[fixed]
mesh.divisions = 24
mesh.band_facets = 4
load.assembly_steps = 1
load.torque_steps = 1
[grid]
load.torque = [1, 2, 3]
STUDY
for pass in first second; do
  study=$(submit hpc/study.slurm "$work/small.toml")
  wait_for "$study"
  test "$(wc -l < small.out/study.csv)" = 4 || fail "study, $pass"
done
rm -rf "cd14-$run.out" "cd14-$long.out" small.out
echo "passed: run, cancelled run, study, study again; $(sinfo --version)"
