#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# The Fortran tests, small scenes and damaged input under ASan and UBSan, then with -fcheck=all and traps of division by zero and overflow:
# tools/sanitize.sh [EXECUTIONS]. Needs ./hd test once; builds in build-sanitize and build-trap, minutes the first time.
# The latter runs scenes alone: tests and damaged input read 1e999, which overflows on purpose. Not watched: null pointers, which gfortran loads to pass on an absent array (a read through one ends in ASan); not trapped: invalid operations, which each comparison with the NaN of an absent value is.
set -eu
cd "$(dirname "$0")/.."
PATH="$PWD/.venv/bin:$PATH"
export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 OMP_NUM_THREADS=2 OPENBLAS_NUM_THREADS=1
small='mesh.divisions=16 mesh.band_facets=3 load.assembly_steps=1 load.torque_steps=2'

run() {
  echo "$*" >"$folder/scene"
  # shellcheck disable=SC2086
  "$exe" "$@" --out "$folder/out" --force -q || { echo "failed: $*" >&2; exit 1; }
}

for kind in sanitize trap; do
  if [ "$kind" = sanitize ]; then
    options='--buildtype=debugoptimized -Db_sanitize=address,undefined -Db_lundef=false -Dfortran_args=-fno-sanitize=null'
  else
    options="--buildtype=debug -Dfortran_args=['-fcheck=all,no-array-temps','-ffpe-trap=zero,overflow']"
  fi
  # shellcheck disable=SC2086
  [ -f build-$kind/build.ninja ] || meson setup build-$kind -Dpython=false $options >.venv/$kind.log
  ninja -C build-$kind --quiet
  [ $kind = trap ] || { ninja -C build-$kind --quiet tests/fortran/hd_tester tests/fortran/hd_fuzz && build-$kind/tests/fortran/hd_tester; }
  exe=$PWD/build-$kind/fortran/app/hdengine.x folder=$(mktemp -d)
  run data/cd14.nml $small output.vtu=all
  run data/cd14.nml $small output.vtu=all mesh.element=hex20r contact.law=joint mesh.edge_length=1e-4
  run data/cd14.nml $small solver.method=newton solver.factors=exact wave_generator.ring_contact=unilateral
  run data/cd14.nml $small solver.kinematics=nonlinear solver.factors=harmonic mesh.ring_divisions=20
  run data/cd14.nml $small load.support=teeth contact.mode=bonded contact.slave=cup
  run tests/cases/pressed_drive.nml $small output.vtu=all load.tooth_friction=0.1 turning.positions=2 bearing.cage_angle_deg=3
  run tests/cases/pressed_drive.nml $small load.tooth_friction=0.1 load.spline=free loop.torques=8,-3 load.torque_steps=3 solver.tolerance=1e-11 \
    wave_generator.eccentricity=5e-6 bearing.balls=11 load.tooth_pairs=12 mesh.divisions=24 mesh.band_facets=4
  run data/drive14_hat.nml $small solver.kinematics=nonlinear loop.torques=5
  run data/drive14_hat.nml $small cup.sections_fillet=0 loop.torques=5
  run data/drive14.nml $small run.gradient=.true. loop.torques=5
  run data/surface.nml surface.nx=40 surface.ny=30
  [ $kind = trap ] || .venv/bin/python tools/fuzz.py --exe "$exe" --count "${1:-200}" --many "${1:-200}00" --build build-sanitize
  rm -r "$folder"
  echo "$kind: nothing found"
done
