#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Waves and heights of the direct sum are the same bits on every processor: compiles them for x86-64 and (where the cross compiler
# is installed) aarch64, runs them natively and on emulated processors with and without AVX, FMA and AVX-512, compares SHA-256.
# Debian: apt-get install gfortran qemu-user gfortran-aarch64-linux-gnu
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

compile() { # gfortran, gcc, program, more flags
  fortran=$1 c=$2 out=$3
  shift 3
  $c -O3 "$@" -c "$root/fortran/base/hd_threefry.c" -o "$out.threefry.o"
  $c -O3 -ffp-contract=off "$@" -c "$root/fortran/surface/hd_exact.c" -o "$out.exact.o"
  mkdir -p "$out.mod"
  (cd "$root/fortran" && $fortran -O3 -ffp-contract=off -ffree-line-length-132 "$@" -fopenmp -J"$work/$out.mod" -o "$work/$out" \
    base/hd_kinds.f90 base/hd_text.f90 base/hd_error.f90 base/hd_random.f90 surface/hd_exact.f90 surface/hd_waves.f90 \
    surface/hd_direct.f90 ../tools/surface_bits.f90 "$work/$out.threefry.o" "$work/$out.exact.o")
}

sums=""
show() { # name, command
  name=$1
  shift
  "$@" heights.bin
  sum=$(sha256sum < heights.bin | cut -c1-64)
  rm heights.bin
  printf '%-42s %s\n' "$name" "$sum"
  sums="$sums$sum
"
}

compile gfortran gcc plain
show "this processor" ./plain
show "1 thread" env OMP_NUM_THREADS=1 ./plain
show "3 threads" env OMP_NUM_THREADS=3 ./plain
show "no AVX2, FMA for the C library" env GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-FMA4 ./plain
if compile gfortran gcc native -march=native; then show "compiled for this processor" ./native; fi
compile gfortran gcc low -O1
show "compiled with -O1" ./low
if command -v qemu-x86_64 > /dev/null; then
  for cpu in qemu64 Nehalem Haswell max; do show "x86-64, emulated $cpu" qemu-x86_64 -cpu $cpu ./plain; done
fi
if command -v aarch64-linux-gnu-gfortran > /dev/null && command -v qemu-aarch64 > /dev/null; then
  compile aarch64-linux-gnu-gfortran aarch64-linux-gnu-gcc arm
  for cpu in cortex-a53 max; do show "aarch64, emulated $cpu" qemu-aarch64 -L /usr/aarch64-linux-gnu -cpu $cpu ./arm; done
fi
if [ "$(printf '%s' "$sums" | sort -u | wc -l)" -ne 1 ]; then
  echo "the bits differ" >&2
  exit 1
fi
echo "the same bits everywhere"
