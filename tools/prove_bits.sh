#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Waves and heights of the direct sum and of products are the same bits on every processor: compiles them for x86-64 and (where the
# cross compiler is installed) aarch64, runs them natively, with every kernel of OpenBLAS this processor has, and on emulated
# processors with and without AVX, FMA and AVX-512, compares SHA-256. aarch64 gets a BLAS that sums from the last term to the first.
# Debian: apt-get install gfortran libopenblas-dev qemu-user gfortran-aarch64-linux-gnu
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

compile() { # gfortran, gcc, program, BLAS, more flags
  fortran=$1 c=$2 out=$3 blas=$4
  shift 4
  $c -O3 "$@" -c "$root/fortran/base/hd_threefry.c" -o "$out.threefry.o"
  $c -O3 -ffp-contract=off "$@" -c "$root/fortran/waves/hd_exact.c" -o "$out.exact.o"
  $c -O3 "$@" -c "$root/fortran/lib/hd_blas_threads.c" -o "$out.threads.o"
  mkdir -p "$out.mod"
  (cd "$root/fortran" && $fortran -O3 -ffp-contract=off -ffree-line-length-132 "$@" -fopenmp -J"$work/$out.mod" -o "$work/$out" \
    base/hd_kinds.f90 base/hd_text.f90 base/hd_error.f90 base/hd_random.f90 lib/hd_lapack.f90 waves/hd_exact.f90 \
    waves/hd_waves.f90 heights/hd_direct.f90 heights/hd_factors.f90 heights/hd_slices.f90 heights/hd_product.f90 ../tools/surface_bits.f90 \
    "$work/$out.threefry.o" "$work/$out.exact.o" "$work/$out.threads.o" $blas)
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

reversed="../tools/reversed_dgemm.f90 -ffunction-sections -Wl,--gc-sections"
compile gfortran gcc plain -lopenblas
show "this processor" ./plain
show "1 thread" env OMP_NUM_THREADS=1 ./plain
show "3 threads" env OMP_NUM_THREADS=3 ./plain
show "no AVX2, FMA for the C library" env GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-FMA4 ./plain
for core in Prescott Nehalem Sandybridge:avx Haswell:avx2 Zen:avx2 SkylakeX:avx512f; do
  if [ "${core#*:}" = "$core" ] || grep -qw "${core#*:}" /proc/cpuinfo; then
    show "OpenBLAS for ${core%:*}" env OPENBLAS_CORETYPE="${core%:*}" ./plain
  fi
done
compile gfortran gcc reversed "$reversed"
show "products summed backwards" ./reversed
if compile gfortran gcc native -lopenblas -march=native; then show "compiled for this processor" ./native; fi
compile gfortran gcc low -lopenblas -O1
show "compiled with -O1" ./low
if command -v qemu-x86_64 > /dev/null; then
  for cpu in qemu64:Prescott Nehalem:Nehalem Haswell:Haswell max:Zen; do # OpenBLAS's own choice for qemu64 is no code for it
    show "x86-64, emulated ${cpu%:*}" env OPENBLAS_CORETYPE="${cpu#*:}" qemu-x86_64 -cpu "${cpu%:*}" ./plain
  done
fi
if command -v aarch64-linux-gnu-gfortran > /dev/null && command -v qemu-aarch64 > /dev/null; then
  compile aarch64-linux-gnu-gfortran aarch64-linux-gnu-gcc arm "$reversed"
  for cpu in cortex-a53 max; do show "aarch64, emulated $cpu" qemu-aarch64 -L /usr/aarch64-linux-gnu -cpu $cpu ./arm; done
fi
if [ "$(printf '%s' "$sums" | sort -u | wc -l)" -ne 1 ]; then
  echo "the bits differ" >&2
  exit 1
fi
echo "the same bits everywhere"
