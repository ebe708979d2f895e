/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Inner loops of the sums of waves, compiled for several widths of vector register; the processor picks at load time. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#define CLONES __attribute__((target_clones("avx512f", "fma", "default")))
#else
#define CLONES
#endif

/* cos and sin of 2 pi r, r in [-1/2, 1/2]: Taylor polynomials on a quarter turn each way, the next terms are below 1e-17. */
static inline __attribute__((always_inline)) void cis(double r, double *cosine, double *sine)
{
  double q = rint(2 * r); /* half turns: -1, 0, 1 */
  double x = (r - 0.5 * q) * 6.283185307179586476925, y = x * x, c, s, sign = 1 - 2 * fabs(q);
  s = -7.6471637318198164759e-13 * (1 - y * (1 / 272.0) * (1 - y * (1 / 342.0) * (1 - y * (1 / 420.0))));
  s = 1.6059043836821614599e-10 + y * s;
  s = -2.5052108385441718775e-08 + y * s;
  s = 2.7557319223985890653e-06 + y * s;
  s = -1.9841269841269841270e-04 + y * s;
  s = 8.3333333333333333333e-03 + y * s;
  s = -1.6666666666666666667e-01 + y * s;
  *sine = sign * (x + x * y * s);
  c = -1.1470745597729724714e-11 * (1 - y * (1 / 240.0) * (1 - y * (1 / 306.0) * (1 - y * (1 / 380.0))));
  c = 2.0876756987868098979e-09 + y * c;
  c = -2.7557319223985890653e-07 + y * c;
  c = 2.4801587301587301587e-05 + y * c;
  c = -1.3888888888888888889e-03 + y * c;
  c = 4.1666666666666666667e-02 + y * c;
  *cosine = sign * (1 - 0.5 * y + y * y * c);
}

/* phase + step (high + low) in turns, reduced: high is a multiple of 2^-29, so its product with a step below 2^23 is exact. */
static inline __attribute__((always_inline)) double turns(double phase, double high, double low, double step)
{
  double t = high * step;
  t = (t - rint(t)) + (low * step + phase);
  return t - rint(t);
}

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

static inline __attribute__((always_inline)) double upper_half(double a)
{
  uint64_t bits;
  memcpy(&bits, &a, 8);
  bits &= ~(uint64_t)134217727;
  memcpy(&a, &bits, 8);
  return a;
}

/* (a + a_2) (b + b_2) = p + p_2 to about 100 bits: products of upper halves are exact. */
static inline __attribute__((always_inline)) double exact_product(double a, double a_2, double b, double b_2, double *p_2)
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
    ux[j] = p - 2 * rint(0.5 * p);
    ux_2[j] = p_2;
    p = exact_product(fy[j], fy_2[j], dy, 0, &p_2);
    uy[j] = p - 2 * rint(0.5 * p);
    uy_2[j] = p_2;
    p = exact_product(fx[j], fx_2[j], x, x_2, &p_2);
    q = exact_product(fy[j], fy_2[j], y, y_2, &q_2);
    p = (p - rint(p)) + (q - rint(q)) + phase[j] + (p_2 + q_2);
    at[j] = p - rint(p);
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
