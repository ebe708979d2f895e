#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Submit the jobs of hpc/ to a real Slurm of one node, started for this purpose. As root, after
#   apt-get install slurm-wlm munge;  ./hd setup
# Proves: a run and a study finish; a job that is cancelled leaves a summary that says so; a study submitted again goes on.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
node=$(hostname -s)
mkdir -p /run/munge "$work/state" "$work/spool"
chown munge: /run/munge
pgrep -x munged >/dev/null || sudo -u munge munged 2>/dev/null || su -s /bin/sh munge -c munged
cat > "$work/slurm.conf" <<CONF
ClusterName=proof
SlurmctldHost=$node
SlurmUser=root
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/ctld.pid
SlurmdPidFile=$work/d.pid
SlurmctldLogFile=$work/ctld.log
SlurmdLogFile=$work/d.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
KillWait=20
NodeName=$node CPUs=$(nproc) RealMemory=4096 State=UNKNOWN
PartitionName=all Nodes=$node Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm.conf
slurmctld
slurmd
trap 'scontrol shutdown >/dev/null 2>&1 || true' EXIT
sleep 3
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

cat > "$work/small.nml" <<STUDY
&study title = 'proof', scene = '$PWD/data/cd14.nml', rows = 'last' /
&fixed mesh.divisions = 24, mesh.band_facets = 4, load.assembly_steps = 1, load.torque_steps = 1 /
&grid load.torque = 1, 2, 3 /
STUDY
for pass in first second; do
  study=$(submit hpc/study.slurm "$work/small.nml")
  wait_for "$study"
  test "$(wc -l < small.out/study.csv)" = 4 || fail "study, $pass"
done
rm -rf "cd14-$run.out" "cd14-$long.out" small.out
echo "passed: run, cancelled run, study, study again; $(sinfo --version)"
