/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A row of 3 x 3 blocks of one sector times a field, for all sectors: eight at once, their sums stay in registers. */
#include "../base/hd_clones.h"

/* n: sectors, filled up to a multiple of 8; blocks: of the row; a (3, 3, blocks); col, shift (blocks): column node from 1, sectors
   further on; v (-1:n, 3, nodes): field, sectors of a node one behind the other; s (n, 3): product */
CLONES void hd_sector_product(int n, int blocks, const double *restrict a, const int *restrict col, const int *restrict shift,
                              const double *restrict v, double *restrict s)
{
  const long m = n + 2;
  for (int i = 0; i < n; i += 8) {
    lanes p = {0}, q = {0}, r = {0};
    for (int k = 0; k < blocks; k++) {
      const double *x = v + 3 * m * (col[k] - 1) + 1 + shift[k] + i, *b = a + 9 * k;
      const lanes f = READ(x), g = READ(x + m), h = READ(x + 2 * m);
      p += b[0] * f + b[3] * g + b[6] * h;
      q += b[1] * f + b[4] * g + b[7] * h;
      r += b[2] * f + b[5] * g + b[8] * h;
    }
    LANES(s + i) = p;
    LANES(s + n + i) = q;
    LANES(s + 2 * n + i) = r;
  }
}
