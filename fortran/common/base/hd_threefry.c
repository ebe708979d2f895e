/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Threefry-2x32, 20 rounds: counters to random words under a key; words of 32 bits in 64-bit integers. */
#include <stdint.h>

#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#define CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define CLONES
#endif

#define ROUND(turns) \
  x += y; \
  y = (y << turns) | (y >> (32 - turns)); \
  y ^= x;
#define FOUR(a, b, c, d) ROUND(a) ROUND(b) ROUND(c) ROUND(d)
#define KEY(number, first, second) \
  x += first; \
  y += second + number;

CLONES void hd_threefry(int n, int64_t *restrict a, int64_t *restrict b, const int64_t *key)
{
  uint32_t k = (uint32_t)key[0], l = (uint32_t)key[1], m = 0x1BD11BDA ^ k ^ l;
  for (int j = 0; j < n; j++) {
    uint32_t x = (uint32_t)a[j] + k, y = (uint32_t)b[j] + l;
    FOUR(13, 15, 26, 6) KEY(1, l, m)
    FOUR(17, 29, 16, 24) KEY(2, m, k)
    FOUR(13, 15, 26, 6) KEY(3, k, l)
    FOUR(17, 29, 16, 24) KEY(4, l, m)
    FOUR(13, 15, 26, 6) KEY(5, m, k)
    a[j] = x;
    b[j] = y;
  }
}
