/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Two products y = A x with a symmetric matrix, of which the upper triangle is read once. Products of this size wait for memory:
   half the entries take half the time, and so do entries of half the length. */
#include <limits.h>
#define KERNEL "../../contact/solvers/hd_symmetric_product.h"
#define PRODUCT hd_symmetric_product
#define LANES_OF lanes
#define REAL double
#include "../../common/base/hd_lanes.h"
#undef PRODUCT
#undef LANES_OF
#undef REAL
#define PRODUCT hd_symmetric_product_single
#define LANES_OF lanes_single
#define REAL float
#include "../../common/base/hd_lanes.h"

/* most: bytes of a vector register, 0: any; n: order, a multiple of 8; top: first row of every 8 columns, a multiple of 8; a:
   columns from there down to the end of their 8 x 8 block on the diagonal, one behind the other; x, y (n, 2) */
void hd_symmetric_product(int most, int n, const int *restrict top, const double *restrict a, const double *restrict x,
  double *restrict y)
{
  PICK(most, hd_symmetric_product, n, top, a, x, y);
}

/* The same in single precision. */
void hd_symmetric_product_single(int most, int n, const int *restrict top, const float *restrict a, const float *restrict x,
  float *restrict y)
{
  PICK(most, hd_symmetric_product_single, n, top, a, x, y);
}
