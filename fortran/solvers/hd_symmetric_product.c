/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Two products y = A x with a symmetric matrix, of which the upper triangle is read once. Products of this size wait for memory:
   half the entries take half the time. */
#include "../base/hd_clones.h"
#define SUM(v) (((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7])))

/* n: order, a multiple of 8; a: columns down to the end of their 8 x 8 block on the diagonal, one behind the other; x, y (n, 2) */
CLONES void hd_symmetric_product(int n, const double *restrict a, const double *restrict x, double *restrict y)
{
  const double *x1 = x, *x2 = x + n;
  double *y1 = y, *y2 = y + n;
  for (int j = 0; j < n; j += 4) { /* four columns at once */
    const int last = j / 8 * 8, m = last + 8;
    const double *p = x1 + j, *q = x2 + j;
    const lanes zero = {0};
    lanes s0 = zero, s1 = zero, s2 = zero, s3 = zero, t0 = zero, t1 = zero, t2 = zero, t3 = zero;
    for (int i = 0; i < last; i += 8) {
      const lanes b0 = READ(a + i), b1 = READ(a + m + i), b2 = READ(a + 2 * m + i), b3 = READ(a + 3 * m + i);
      const lanes u = READ(x1 + i), v = READ(x2 + i);
      LANES(y1 + i) += b0 * p[0] + b1 * p[1] + b2 * p[2] + b3 * p[3];
      LANES(y2 + i) += b0 * q[0] + b1 * q[1] + b2 * q[2] + b3 * q[3];
      s0 += b0 * u; s1 += b1 * u; s2 += b2 * u; s3 += b3 * u;
      t0 += b0 * v; t1 += b1 * v; t2 += b2 * v; t3 += b3 * v;
    }
    if (j == last)
      LANES(y1 + j) = LANES(y2 + j) = zero;
    const lanes b0 = READ(a + last), b1 = READ(a + m + last), b2 = READ(a + 2 * m + last), b3 = READ(a + 3 * m + last);
    LANES(y1 + last) += b0 * p[0] + b1 * p[1] + b2 * p[2] + b3 * p[3];
    LANES(y2 + last) += b0 * q[0] + b1 * q[1] + b2 * q[2] + b3 * q[3];
    y1[j] += SUM(s0); y1[j + 1] += SUM(s1); y1[j + 2] += SUM(s2); y1[j + 3] += SUM(s3);
    y2[j] += SUM(t0); y2[j + 1] += SUM(t1); y2[j + 2] += SUM(t2); y2[j + 3] += SUM(t3);
    a += 4 * m;
  }
}
