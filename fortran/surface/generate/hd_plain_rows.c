/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rows of the plain product: factors of all waves at one point, and heights of the halves that are even and odd. */
#include "hd_cis.h"

/* even = a cos, odd = b sin of 2 pi (phase + step (high + low)), n waves. */
#define FACTORS(name, real, cis) \
  CLONES void name(int n, const double *restrict phase, const double *restrict high, const double *restrict low, double step, \
                   const double *restrict a, const double *restrict b, real *restrict even, real *restrict odd) \
  { \
    for (int j = 0; j < n; j++) { \
      real c, s; \
      cis(turns(phase[j], high[j], low[j], step), &c, &s); \
      even[j] = (real)a[j] * c; \
      odd[j] = (real)b[j] * s; \
    } \
  }
FACTORS(hd_factor_row, double, cis)
FACTORS(hd_factor_row_single, float, cis_single)

/* z = offset + unit (even -+ odd) left and right of the middle, n points. */
#define JOIN(name, real, kind) \
  CLONES void name(int n, const real *restrict even, const real *restrict odd, double offset, double unit, kind *restrict z) \
  { \
    const int half = (n + 1) / 2; \
    kind *right = z + n / 2; \
    for (int i = 0; i < n / 2; i++) z[i] = (kind)(offset + unit * (double)(even[half - 1 - i] - odd[half - 1 - i])); \
    for (int i = 0; i < half; i++) right[i] = (kind)(offset + unit * (double)(even[i] + odd[i])); \
  }
JOIN(hd_join_row, double, double)
JOIN(hd_join_row_single, float, double)
JOIN(hd_join_single_row, double, float)
JOIN(hd_join_single_row_single, float, float)
