/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Two or eight right-hand sides with a Cholesky factor of a band at once: each entry is read once for them. */
#include "../base/hd_clones.h"

/* n: order; kd: half width; u: upper band (n columns of kd + 1, the diagonal last) of A = U^T U; x (n, 2): right-hand sides,
   then solutions */
CLONES void hd_solve_band(int n, int kd, const double *restrict u, double *restrict x)
{
  double *restrict y = x + n;
  for (int j = 0; j < n; j++) { /* U^T */
    const int m = j < kd ? j : kd;
    const double *restrict a = u + (long)(kd + 1) * j + kd - m;
    double s = 0, t = 0;
#pragma omp simd reduction(+ : s, t)
    for (int i = 0; i < m; i++) {
      s += a[i] * x[j - m + i];
      t += a[i] * y[j - m + i];
    }
    x[j] = (x[j] - s) / a[m];
    y[j] = (y[j] - t) / a[m];
  }
  for (int j = n - 1; j >= 0; j--) { /* U */
    const int m = j < kd ? j : kd;
    const double *restrict a = u + (long)(kd + 1) * j + kd - m;
    const double s = x[j] /= a[m], t = y[j] /= a[m];
#pragma omp simd
    for (int i = 0; i < m; i++) {
      x[j - m + i] -= s * a[i];
      y[j - m + i] -= t * a[i];
    }
  }
}

typedef double octet __attribute__((vector_size(64), aligned(8)));

/* The same with x (8, n), the vectors across the right-hand sides. */
CLONES void hd_solve_band_octet(int n, int kd, const double *restrict u, double *restrict x)
{
  octet *y = (octet *)x;
  for (int j = 0; j < n; j++) { /* U^T */
    const int m = j < kd ? j : kd;
    const double *restrict a = u + (long)(kd + 1) * j + kd - m;
    const octet *z = y + j - m;
    octet s = {0}, t = {0};
    int i = 0;
    for (; i + 1 < m; i += 2) {
      s += a[i] * z[i];
      t += a[i + 1] * z[i + 1];
    }
    if (i < m) s += a[i] * z[i];
    y[j] = (y[j] - (s + t)) / a[m];
  }
  for (int j = n - 1; j >= 0; j--) { /* U */
    const int m = j < kd ? j : kd;
    const double *restrict a = u + (long)(kd + 1) * j + kd - m;
    octet *z = y + j - m;
    const octet s = y[j] /= a[m];
    for (int i = 0; i < m; i++) z[i] -= a[i] * s;
  }
}
