#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# The Fortran tests, small scenes and damaged input under ASan and UBSan, then with -fcheck=all and traps of division by zero and overflow:
# tools/sanitize.sh [--suite] [EXECUTIONS]; --suite: the Python tests too, of program and extension so built. Needs ./hd test once; builds in
# build-sanitize and build-trap, half an hour the first time.
# With traps the Fortran tests and damaged input are left out: they read 1e999, which overflows on purpose; and the extension has only the checks, for traps would be those of all Python. Not watched: null pointers, which gfortran loads to pass on an absent array (a read through one ends in ASan); not trapped: invalid operations, which each comparison with the NaN of an absent value is.
set -eu
cd "$(dirname "$0")/.."
PATH="$PWD/.venv/bin:$PATH"
suite=
[ "${1:-}" != --suite ] || { suite=yes; shift; }
export ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 OMP_NUM_THREADS=2 OPENBLAS_NUM_THREADS=1
small='mesh.divisions=16 mesh.band_facets=3 load.assembly_steps=1 load.torque_steps=2'

run() {
  echo "$*" >"$folder/scene"
  # shellcheck disable=SC2086
  "$exe" "$@" --out "$folder/out" --force -q || { echo "failed: $*" >&2; exit 1; }
}

# The Python tests, but those that read the sources, submit jobs, measure or bound bytes or instructions, preload a library or compare the package's
# version; and two where rounding is another here: a load step is halved, a gradient is off by 2.1e-5 for a limit of 2e-5. Under ASan a plan on
# a full disk is left out too: there libgfortran 12 flushes more than its own buffer holds.
run_suite() {
  preload='' left_out='few_addresses or leave_no_memory or record_allows or old_kernels or one_version'
  if [ $kind = sanitize ]; then
    left_out="$left_out or is_foretold or limit_of_the_shell or takes_no_more_steps or (full_disk and planned)"
    left_out="$left_out or (test_summaries and (press or drive or teeth or surface))"
    for l in libasan.so libubsan.so libstdc++.so; do preload=$preload:$(gcc -print-file-name=$l); done
  else
    left_out="$left_out or central_differences[data/paper.nml-keys1"
  fi
  LD_PRELOAD=$preload HDENGINE_EXE=$exe PYTHONPATH=$site OMP_NUM_THREADS=1 .venv/bin/python -m pytest -q -n 2 --dist loadfile --no-loadscope-reorder \
    --ignore=tests/python/test_house.py --ignore=tests/python/test_slurm.py -k "not ($left_out)"
}

for kind in sanitize trap; do
  if [ "$kind" = sanitize ]; then
    options="-Db_sanitize=address,undefined -Db_lundef=false -Dfortran_args=['-fno-var-tracking','-fno-sanitize=null']"
  else
    options="-Dfortran_args=['-fno-var-tracking','-fcheck=all,no-array-temps','-ffpe-trap=zero,overflow']"
  fi
  site=$PWD/build-$kind/site
  [ -d build-$kind/python ] || rm -rf build-$kind  # of another commit, which would install elsewhere
  # shellcheck disable=SC2086
  [ -f build-$kind/build.ninja ] || meson setup build-$kind --buildtype=debugoptimized -Dpython.platlibdir="$site" -Dpython.purelibdir="$site" $options >.venv/$kind.log
  ninja -C build-$kind --quiet
  meson install -C build-$kind --quiet --no-rebuild --tags runtime,python-runtime
  [ $kind = trap ] || { ninja -C build-$kind --quiet tests/fortran/hd_tester tests/fortran/hd_fuzz && build-$kind/tests/fortran/hd_tester; }
  exe=$site/hdengine_x/hdengine.x folder=$(mktemp -d)
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
  run data/drive14.nml $small run.tolerance=0.2
  run data/surface.nml surface.nx=40 surface.ny=30
  [ $kind = trap ] || .venv/bin/python tools/fuzz.py --exe "$exe" --count "${1:-200}" --many "${1:-200}00" --build build-sanitize
  [ -z "$suite" ] || run_suite
  rm -r "$folder"
  echo "$kind: nothing found"
done
