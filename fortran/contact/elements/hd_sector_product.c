/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A row of 3 x 3 blocks of one sector times a field, for all sectors. */
#define KERNEL "../../contact/elements/hd_sector_product.h"
#include "../../common/base/hd_lanes.h"

/* most: bytes of a vector register, 0: any; n: sectors, filled up to a multiple of 8; blocks: of the row; a (3, 3, blocks); col,
   shift (blocks): column node from 1, sectors further on; v (-1:n, 3, nodes): field, sectors of a node one behind the other;
   s (n, 3): product */
void hd_sector_product(int most, int n, int blocks, const double *restrict a, const int *restrict col, const int *restrict shift,
                       const double *restrict v, double *restrict s)
{
  PICK(most, hd_sector_product, n, blocks, a, col, shift, v, s);
}
