/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Kernels of the non-uniform FFT for numbers of kind REAL; hd_spread.c includes them twice. */

/* out = a exp(2 pi i (phase + step u)), n waves. */
CLONES void NAME(hd_phases)(int n, const double *restrict phase, const double *restrict high, const double *restrict low, int step,
                            const double *restrict a, REAL *restrict out)
{
  for (int j = 0; j < n; j++) {
    double c, s;
    cis(turns(phase[j], high[j], low[j], step), &c, &s);
    out[2 * j] = (REAL)(a[j] * c);
    out[2 * j + 1] = (REAL)(a[j] * s);
  }
}

/* Piecewise polynomials (padded width, 0..degree) at s in [-1, 1]: weights (padded width, n). */
typedef REAL NAME(four) __attribute__((vector_size(4 * sizeof(REAL)), aligned(sizeof(REAL))));

#undef WEIGHTS
#define WEIGHTS(W) \
  for (int j = 0; j < n; j += 2) { /* two at once: each waits for its own sums */ \
    int m = j + 1 < n ? j + 1 : j; \
    const NAME(four) *row = (const NAME(four) *)(piece + degree * W); \
    NAME(four) u[W / 4], v[W / 4]; \
    _Pragma("GCC unroll 8") for (int i = 0; i < W / 4; i++) u[i] = v[i] = row[i]; \
    for (int l = degree - 1; l >= 0; l--) { \
      row -= W / 4; \
      _Pragma("GCC unroll 8") for (int i = 0; i < W / 4; i++) { \
        u[i] = u[i] * (REAL)s[j] + row[i]; \
        v[i] = v[i] * (REAL)s[m] + row[i]; \
      } \
    } \
    _Pragma("GCC unroll 8") for (int i = 0; i < W / 4; i++) { \
      ((NAME(four) *)(weight + (long)j * W))[i] = u[i]; \
      ((NAME(four) *)(weight + (long)m * W))[i] = v[i]; \
    } \
  }

CLONES void NAME(hd_weights)(int n, int padded, int degree, const REAL *restrict piece, const double *restrict s,
                             REAL *restrict weight)
{
  switch (padded) {
  case 4: WEIGHTS(4) break;
  case 8: WEIGHTS(8) break;
  case 12: WEIGHTS(12) break;
  case 16: WEIGHTS(16) break;
  case 20: WEIGHTS(20) break;
  case 24: WEIGHTS(24) break;
  case 28: WEIGHTS(28) break;
  }
}

/* Add the waves c (complex) to the fine points f (complex, rows `height` apart): the row of weights in x, once for each in y. */
typedef REAL NAME(eight) __attribute__((vector_size(8 * sizeof(REAL)), aligned(sizeof(REAL))));

#undef SPREAD
#define SPREAD(W) \
  for (int j = 0; j < n; j++) { \
    NAME(eight) g[W / 4]; \
    REAL re = c[2 * j], im = c[2 * j + 1]; \
    NAME(eight) both = {re, im, re, im, re, im, re, im}; \
    const NAME(four) *w = (const NAME(four) *)(wx + (long)j * W); \
    _Pragma("GCC unroll 8") for (int i = 0; i < W / 4; i++) \
      g[i] = both * __builtin_shufflevector(w[i], w[i], 0, 0, 1, 1, 2, 2, 3, 3); \
    int q = ky[j]; \
    REAL *start = f + 2L * kx[j]; \
    for (int k = 0; k < width_y; k++) { \
      NAME(eight) *row = (NAME(eight) *)(start + 2L * height * q); \
      REAL v = wy[(long)j * padded_y + k]; \
      _Pragma("GCC unroll 8") for (int i = 0; i < W / 4; i++) row[i] += v * g[i]; \
      if (++q == fine_y) q = 0; \
    } \
  }

CLONES void NAME(hd_spread_rows)(int n, int padded_x, int padded_y, int width_y, int fine_y, int height,
                                 const int *restrict kx, const int *restrict ky, const REAL *restrict c,
                                 const REAL *restrict wx, const REAL *restrict wy, REAL *restrict f)
{
  switch (padded_x) {
  case 4: SPREAD(4) break;
  case 8: SPREAD(8) break;
  case 12: SPREAD(12) break;
  case 16: SPREAD(16) break;
  case 20: SPREAD(20) break;
  case 24: SPREAD(24) break;
  case 28: SPREAD(28) break;
  }
}
