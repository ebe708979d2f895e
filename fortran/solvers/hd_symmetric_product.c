/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Two products y = A x with a symmetric matrix, of which the upper triangle is read once. Products of this size wait for memory:
   half the entries take half the time. */
#include <limits.h>
#define KERNEL "../solvers/hd_symmetric_product.h"
#include "../base/hd_lanes.h"

/* most: bytes of a vector register, 0: any; n: order, a multiple of 8; a: columns down to the end of their 8 x 8 block on the
   diagonal, one behind the other; x, y (n, 2) */
void hd_symmetric_product(int most, int n, const double *restrict a, const double *restrict x, double *restrict y)
{
  PICK(most, hd_symmetric_product, n, a, x, y);
}
