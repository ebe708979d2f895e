/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Inner loops of the non-uniform FFT in double and in single precision. */
#include "hd_cis.h"
#define KERNEL "../../surface/generate/hd_spread_kernels.h"
#define OF_KIND(f) NAME(f)
#define REAL double
#include "../../common/base/hd_lanes.h"
#undef REAL
#undef OF_KIND
#define OF_KIND(f) NAME(f##_single)
#define REAL float
#include "../../common/base/hd_lanes.h"

/* out = a exp(2 pi i (phase + step u)), n waves. */
#define PHASES(name, real, cis) \
  CLONES void name(int n, const double *restrict phase, const double *restrict high, const double *restrict low, int step, \
                   const double *restrict a, real *restrict out) \
  { \
    for (int j = 0; j < n; j++) { \
      real c, s; \
      cis(turns(phase[j], high[j], low[j], step), &c, &s); \
      out[2 * j] = (real)a[j] * c; \
      out[2 * j + 1] = (real)a[j] * s; \
    } \
  }
PHASES(hd_phases, double, cis)
PHASES(hd_phases_single, float, cis_single)

/* Piecewise polynomials (padded width, 0..degree) at s in [-1, 1]: weights (padded width, n). most: bytes of a vector
   register, 0: any. */
#define WINDOW(name, real) \
  void name(int most, int n, int padded, int degree, const real *restrict piece, const double *restrict s, real *restrict weight) \
  { \
    PICK(most, name, n, padded, degree, piece, s, weight) \
  }
WINDOW(hd_weights, double)
WINDOW(hd_weights_single, float)

/* Add the waves c (complex) to the fine points f (complex, rows `height` apart): the row of weights in x, once for each in y. */
#define SPREADING(name, real) \
  void name(int most, int n, int padded_x, int padded_y, int width_y, int fine_y, int height, const int *restrict kx, \
            const int *restrict ky, const real *restrict c, const real *restrict wx, const real *restrict wy, real *restrict f) \
  { \
    PICK(most, name, n, padded_x, padded_y, width_y, fine_y, height, kx, ky, c, wx, wy, f) \
  }
SPREADING(hd_spread_rows, double)
SPREADING(hd_spread_rows_single, float)
