/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Kernel of hd_sector_product.c for one width of register: eight sectors at once, their sums stay in registers. */
typedef double NAME(lanes) __attribute__((vector_size(BYTES), aligned(8)));

TARGET static void NAME(hd_sector_product)(int n, int blocks, const double *restrict a, const int *restrict col,
                                           const int *restrict shift, const double *restrict v, double *restrict s)
{
  enum { wide = BYTES / 8, parts = 8 / wide };
  const long m = n + 2;
  for (int i = 0; i < n; i += 8) {
    NAME(lanes) p[parts] = {0}, q[parts] = {0}, r[parts] = {0};
    for (int k = 0; k < blocks; k++) {
      const double *x = v + 3 * m * (col[k] - 1) + 1 + shift[k] + i, *b = a + 9 * k;
#pragma GCC unroll 4
      for (int l = 0; l < parts; l++) {
        const NAME(lanes) f = *(const NAME(lanes) *)(x + l * wide), g = *(const NAME(lanes) *)(x + m + l * wide),
                          h = *(const NAME(lanes) *)(x + 2 * m + l * wide);
        p[l] += b[0] * f + b[3] * g + b[6] * h;
        q[l] += b[1] * f + b[4] * g + b[7] * h;
        r[l] += b[2] * f + b[5] * g + b[8] * h;
      }
    }
#pragma GCC unroll 4
    for (int l = 0; l < parts; l++) {
      *(NAME(lanes) *)(s + i + l * wide) = p[l];
      *(NAME(lanes) *)(s + n + i + l * wide) = q[l];
      *(NAME(lanes) *)(s + 2 * n + i + l * wide) = r[l];
    }
  }
}
