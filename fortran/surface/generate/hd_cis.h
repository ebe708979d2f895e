/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sine and cosine of turns, of a few operations that compilers vectorise. */
#include <math.h>
#include <stdint.h>
#include <string.h>
#include "../../common/base/hd_clones.h"

#define INLINE static inline __attribute__((always_inline))

/* Nearest whole number, for sizes below 2^51. */
INLINE double whole(double x) { return (x + 6755399441055744.0) - 6755399441055744.0; }

/* cos and sin of 2 pi r, r in [-1/2, 1/2]: Taylor polynomials on a quarter turn each way, the next terms are below 1e-17. */
INLINE void cis(double r, double *cosine, double *sine)
{
  double q = whole(2 * r); /* half turns: -1, 0, 1 */
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

/* The same to single precision. */
INLINE void cis_single(double r, float *cosine, float *sine)
{
  double q = whole(2 * r);
  float x = (float)((r - 0.5 * q) * 6.283185307179586476925), y = x * x, c, s, sign = 1 - 2 * fabsf((float)q);
  s = 2.755731922e-06f + y * (-2.505210839e-08f + y * 1.605904384e-10f);
  s = -1.984126984e-04f + y * s;
  s = 8.333333333e-03f + y * s;
  s = -1.666666667e-01f + y * s;
  *sine = sign * (x + x * y * s);
  c = 2.480158730e-05f + y * (-2.755731922e-07f + y * 2.087675699e-09f);
  c = -1.388888889e-03f + y * c;
  c = 4.166666667e-02f + y * c;
  *cosine = sign * (1 - 0.5f * y + y * y * c);
}

/* phase + step (high + low) in turns, reduced: high is a multiple of 2^-29, so its product with a step below 2^23 is exact. */
INLINE double turns(double phase, double high, double low, double step)
{
  double t = high * step;
  t = (t - whole(t)) + (low * step + phase);
  return t - whole(t);
}
