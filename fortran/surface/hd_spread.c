/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Inner loops of the sums of waves, compiled for several widths of vector register; the processor picks at load time. */
#include "hd_cis.h"

/* even += a cos, odd += b sin of 2 pi (phase + step u) at the steps first, first + 2, ...: n points of one wave. */
CLONES void hd_add_row(int n, double phase, double high, double low, int first, double a, double b, double *restrict even,
                       double *restrict odd)
{
  for (int i = 0; i < n; i++) {
    double c, s;
    cis(turns(phase, high, low, first + 2 * i), &c, &s);
    even[i] += a * c;
    odd[i] += b * s;
  }
}

#define REAL double
#define NAME(name) name
#include "hd_spread_kernels.h"
#undef REAL
#undef NAME
#define REAL float
#define NAME(name) name##_single
#include "hd_spread_kernels.h"
