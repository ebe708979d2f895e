/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Waves and their direct sum, the same bits on every processor: plain sums and products in a fixed
 * order, compiled without fused multiply-add; several widths of vector register do the same operations. */
#include "hd_cis.h"

INLINE double upper_half(double a)
{
  uint64_t bits;
  memcpy(&bits, &a, 8);
  bits &= ~(uint64_t)134217727;
  memcpy(&a, &bits, 8);
  return a;
}

/* (a + a_2) (b + b_2) = p + p_2 to about 100 bits: products of upper halves are exact. */
INLINE double exact_product(double a, double a_2, double b, double b_2, double *p_2)
{
  double ah = upper_half(a), bh = upper_half(b), al = a - ah, bl = b - bh, p = a * b;
  double rest = (((ah * bh - p) + ah * bl + al * bh) + al * bl) + (a * b_2 + a_2 * b);
  double q = p + rest;
  *p_2 = rest - (q - p);
  return q;
}

/* p[j] + p_2[j] = (a + a_2) (b[j] + b_2[j]) */
CLONES void hd_products(int n, double a, double a_2, const double *restrict b, const double *restrict b_2,
                        double *restrict p, double *restrict p_2)
{
  for (int j = 0; j < n; j++) p[j] = exact_product(b[j], b_2[j], a, a_2, &p_2[j]);
}

/* Turns per step, reduced to [-1, 1], and phases at a point x + x_2, y + y_2, reduced to [-1/2, 1/2]. */
CLONES void hd_turns(int n, const double *restrict fx, const double *restrict fx_2, const double *restrict fy,
                     const double *restrict fy_2, const double *restrict phase, double dx, double dy, double x, double x_2,
                     double y, double y_2, double *restrict ux, double *restrict ux_2, double *restrict uy,
                     double *restrict uy_2, double *restrict at)
{
  for (int j = 0; j < n; j++) {
    double p, q, p_2, q_2;
    p = exact_product(fx[j], fx_2[j], dx, 0, &p_2);
    ux[j] = p - 2 * whole(0.5 * p);
    ux_2[j] = p_2;
    p = exact_product(fy[j], fy_2[j], dy, 0, &p_2);
    uy[j] = p - 2 * whole(0.5 * p);
    uy_2[j] = p_2;
    p = exact_product(fx[j], fx_2[j], x, x_2, &p_2);
    q = exact_product(fy[j], fy_2[j], y, y_2, &q_2);
    p = (p - whole(p)) + (q - whole(q)) + phase[j] + (p_2 + q_2);
    at[j] = p - whole(p);
  }
}

/* z -= a cos of 2 pi (phase + i u) at the steps i = 0, 1, ...: n points of one wave. */
CLONES void hd_direct_row(int n, double phase, double high, double low, double a, double *restrict z)
{
  for (int i = 0; i < n; i++) {
    double c, s;
    cis(turns(phase, high, low, i), &c, &s);
    z[i] -= a * c;
  }
}

/* c = cos of 2 pi phases in [-1/2, 1]. */
CLONES void hd_cosines(int n, const double *restrict phase, double *restrict cosine)
{
  for (int j = 0; j < n; j++) {
    double s;
    cis(phase[j] - whole(phase[j]), &cosine[j], &s);
  }
}
