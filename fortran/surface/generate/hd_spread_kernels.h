/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Kernels of hd_spread.c for numbers of kind REAL and one width of register. Rows of weights are whole fours, those of complex
   fine points whole eights: wider vectors have no use. */
typedef REAL OF_KIND(four) __attribute__((vector_size(4 * sizeof(REAL) < BYTES ? 4 * sizeof(REAL) : BYTES), aligned(sizeof(REAL))));
typedef REAL OF_KIND(eight) __attribute__((vector_size(8 * sizeof(REAL) < BYTES ? 8 * sizeof(REAL) : BYTES), aligned(sizeof(REAL))));

#undef WEIGHTS
#define WEIGHTS(W) \
  { \
    enum { parts = W * sizeof(REAL) / sizeof(OF_KIND(four)) }; \
    for (int j = 0; j < n; j += 2) { /* two at once: each waits for its own sums */ \
      int m = j + 1 < n ? j + 1 : j; \
      const OF_KIND(four) *row = (const OF_KIND(four) *)(piece + degree * W); \
      OF_KIND(four) u[parts], v[parts]; \
      _Pragma("GCC unroll 14") for (int i = 0; i < parts; i++) u[i] = v[i] = row[i]; \
      for (int l = degree - 1; l >= 0; l--) { \
        row -= parts; \
        _Pragma("GCC unroll 14") for (int i = 0; i < parts; i++) { \
          u[i] = u[i] * (REAL)s[j] + row[i]; \
          v[i] = v[i] * (REAL)s[m] + row[i]; \
        } \
      } \
      _Pragma("GCC unroll 14") for (int i = 0; i < parts; i++) { \
        ((OF_KIND(four) *)(weight + (long)j * W))[i] = u[i]; \
        ((OF_KIND(four) *)(weight + (long)m * W))[i] = v[i]; \
      } \
    } \
  }

TARGET static void OF_KIND(hd_weights)(int n, int padded, int degree, const REAL *restrict piece, const double *restrict s,
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

/* out = weights w[0..3], each twice, times re, im: eight numbers. */
TARGET static inline __attribute__((always_inline)) void OF_KIND(twice)(const REAL *restrict w, REAL re, REAL im, OF_KIND(eight) *out)
{
  if (sizeof(OF_KIND(eight)) == 8 * sizeof(REAL)) {
    typedef REAL whole_four __attribute__((vector_size(4 * sizeof(REAL)), aligned(sizeof(REAL))));
    typedef REAL whole_eight __attribute__((vector_size(8 * sizeof(REAL)), aligned(sizeof(REAL))));
    const whole_four f = *(const whole_four *)w;
    const whole_eight both = {re, im, re, im, re, im, re, im};
    *(whole_eight *)out = both * __builtin_shufflevector(f, f, 0, 0, 1, 1, 2, 2, 3, 3);
  } else if (sizeof(OF_KIND(eight)) == 4 * sizeof(REAL)) {
    typedef REAL whole_four __attribute__((vector_size(4 * sizeof(REAL)), aligned(sizeof(REAL))));
    const whole_four f = *(const whole_four *)w, both = {re, im, re, im};
    ((whole_four *)out)[0] = both * __builtin_shufflevector(f, f, 0, 0, 1, 1);
    ((whole_four *)out)[1] = both * __builtin_shufflevector(f, f, 2, 2, 3, 3);
  } else {
    typedef REAL whole_two __attribute__((vector_size(2 * sizeof(REAL)), aligned(sizeof(REAL))));
    const whole_two both = {re, im};
    _Pragma("GCC unroll 4") for (int i = 0; i < 4; i++) ((whole_two *)out)[i] = both * w[i];
  }
}

#undef SPREAD
#define SPREAD(W) \
  { \
    enum { parts = 2 * W * sizeof(REAL) / sizeof(OF_KIND(eight)), of_four = 4 * parts / W }; \
    for (int j = 0; j < n; j++) { \
      OF_KIND(eight) g[parts]; \
      _Pragma("GCC unroll 7") for (int i = 0; i < W / 4; i++) \
        OF_KIND(twice)(wx + (long)j * W + 4 * i, c[2 * j], c[2 * j + 1], g + of_four * i); \
      int q = ky[j]; \
      REAL *start = f + 2L * kx[j]; \
      for (int k = 0; k < width_y; k++) { \
        OF_KIND(eight) *row = (OF_KIND(eight) *)(start + 2L * height * q); \
        REAL v = wy[(long)j * padded_y + k]; \
        _Pragma("GCC unroll 28") for (int i = 0; i < parts; i++) row[i] += v * g[i]; \
        if (++q == fine_y) q = 0; \
      } \
    } \
  }

TARGET static void OF_KIND(hd_spread_rows)(int n, int padded_x, int padded_y, int width_y, int fine_y, int height,
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
