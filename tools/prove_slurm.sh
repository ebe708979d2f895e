#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Submit the jobs of hpc/ to a real Slurm of three nodes, as root, after  apt-get install slurm-wlm munge;  ./hd setup
# Proves beyond the tests (tests/python/test_slurm.py): a job that is cancelled leaves a summary that says so; a study submitted again
# goes on; shards of 2000 points, two nodes of which die, are requeued and lose no point and solve none twice.
set -euo pipefail
cd "$(dirname "$0")/.."
if [ -z "${SLURM_CONF:-}" ]; then
  NODES=3 exec tools/slurm_node.sh "$(mktemp -d)" "$0"
fi
work=$(dirname "$SLURM_CONF")
sinfo
submit() { sbatch --parsable --mem=1G --output="$work/%j.log" "$@"; }
wait_for() { while squeue -h -j "$1" 2>/dev/null | grep -q .; do sleep 1; done; }
fail() { echo "failed: $1"; tail -n 20 "$work"/*.log; exit 1; }

long=$(submit hpc/run.slurm data/cd14.nml load.torque_steps=400 output.vtu=none solver.method=newton)
until test -f "cd14-$long.out/history.csv" -o -f "cd14-$long.out/history.csv.part"; do sleep 1; done
sleep 5
scancel --signal=TERM "$long"
wait_for "$long"
grep -q '"status": "interrupted"' "cd14-$long.out/summary.json" || fail "cancelled run"

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

# A node dies: its slurmd, and all that runs on it
die() {
  kill -9 "$(cat "$work/$1.pid")"
  for env in $(grep -slzFx "SLURMD_NODENAME=$1" /proc/[0-9]*/environ 2>/dev/null); do
    grep -qzFx "SLURM_CONF=$SLURM_CONF" "$env" || continue
    of=${env%/environ}
    parent=$(awk '/^PPid/ {print $2}' "$of/status")
    [ "$(cat "/proc/$parent/comm")" != slurmstepd ] || kill -9 "$parent" || true
    kill -9 "${of#/proc/}" || true
  done
  scontrol update nodename="$1" state=down reason=died
}
cat > "$work/shards.toml" <<STUDY
[study]
scene = "$PWD/data/cd14.nml"
rows = "last"
[fixed]
mesh.divisions = 12
mesh.band_facets = 2
load.assembly_steps = 1
load.torque_steps = 1
[grid]
load.torque = [$(seq -s , 0.01 0.01 20)]
STUDY
lines() { cat shards.out/part-*.jsonl 2>/dev/null | wc -l; }
began=$(date +%s)
shards=$(submit --array=1-8 --cpus-per-task=32 hpc/study_array.slurm "$work/shards.toml" --out shards.out --jobs 1)
until [ "$(lines)" -gt 300 ]; do sleep 0.1; done
die n1
die n2
before=$(lines)
slurmd -N n1
slurmd -N n2
wait_for "$shards"
.venv/bin/hdengine study "$work/shards.toml" --out shards.out --collect
requeued=$(scontrol -o show job "$shards" | grep -c 'Restarts=[1-9]')
echo "shards: two nodes died at $before lines, $requeued of 8 tasks requeued, done after $(($(date +%s) - began)) s"
test "$requeued" -gt 0 || fail "requeue"
.venv/bin/hdengine study "$work/shards.toml" --out one.out --jobs 2 2>/dev/null
cmp shards.out/study.csv one.out/study.csv || fail "table of shards"
.venv/bin/python - shards.out <<'END' || fail "shards"
import json, sys
from collections import Counter
from pathlib import Path
lines = [json.loads(line) for part in Path(sys.argv[1]).glob("part-*.jsonl") for line in open(part)]
count = Counter(line["point"] for line in lines if "point" in line)
print("points solved once:", sum(n == 1 for n in count.values()), "more than once:", sum(n > 1 for n in count.values()))
sys.exit(sorted(count) != list(range(2000)) or max(count.values()) > 1)
END
rm -rf "cd14-$long.out" small.out shards.out one.out
echo "passed: cancelled run, study, study again, shards; $(sinfo --version)"
