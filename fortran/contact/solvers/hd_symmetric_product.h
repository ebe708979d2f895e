/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Kernel of hd_symmetric_product.c for one width of register: as many numbers of REAL as are double ones, four at least. */
#undef OF
#undef WIDTH
#undef LANES
#undef VECTOR
#undef SUM
#define OF(f) NAME(f)
#define WIDTH (BYTES * sizeof(REAL) / 8 > 16 ? BYTES * sizeof(REAL) / 8 : 16)
#define LANES OF(LANES_OF)
#define VECTOR(p) (*(LANES *)(p))
#define SUM(v) ((((v)[0] + (v)[1]) + ((v)[2] + (v)[3])) + (((v)[4] + (v)[5]) + ((v)[6] + (v)[7])))

typedef REAL LANES __attribute__((vector_size(WIDTH), aligned(sizeof(REAL))));

TARGET static void OF(PRODUCT)(int n, const int *restrict top, const REAL *restrict a, const REAL *restrict x, REAL *restrict y)
{
  enum { wide = WIDTH / sizeof(REAL), piece = wide < 8 ? 256 : INT_MAX / 2 };
  const REAL *x1 = x, *x2 = x + n;
  REAL *y1 = y, *y2 = y + n;
  for (int j = 0; j < n; j += 4) { /* four columns at once */
    const int last = j / 8 * 8, first = top[j / 8], m = last + 8 - first;
    const REAL *p = x1 + j, *q = x2 + j;
    REAL sums[8][8] __attribute__((aligned(64))) = {{0}};
    for (int from = first; from < last; from += piece) { /* rows that stay in the cache for all parts of eight sums */
      const int to = last - from > piece ? from + piece : last;
      for (int part = 0; part < 8; part += wide) {
        LANES s0 = VECTOR(sums[0] + part), s1 = VECTOR(sums[1] + part), s2 = VECTOR(sums[2] + part), s3 = VECTOR(sums[3] + part);
        LANES t0 = VECTOR(sums[4] + part), t1 = VECTOR(sums[5] + part), t2 = VECTOR(sums[6] + part), t3 = VECTOR(sums[7] + part);
        for (int i = from + part; i < to; i += 8) {
          const REAL *b = a + (i - first);
          const LANES b0 = VECTOR(b), b1 = VECTOR(b + m), b2 = VECTOR(b + 2 * m), b3 = VECTOR(b + 3 * m);
          const LANES u = VECTOR(x1 + i), v = VECTOR(x2 + i);
          VECTOR(y1 + i) += b0 * p[0] + b1 * p[1] + b2 * p[2] + b3 * p[3];
          VECTOR(y2 + i) += b0 * q[0] + b1 * q[1] + b2 * q[2] + b3 * q[3];
          s0 += b0 * u; s1 += b1 * u; s2 += b2 * u; s3 += b3 * u;
          t0 += b0 * v; t1 += b1 * v; t2 += b2 * v; t3 += b3 * v;
        }
        VECTOR(sums[0] + part) = s0; VECTOR(sums[1] + part) = s1; VECTOR(sums[2] + part) = s2; VECTOR(sums[3] + part) = s3;
        VECTOR(sums[4] + part) = t0; VECTOR(sums[5] + part) = t1; VECTOR(sums[6] + part) = t2; VECTOR(sums[7] + part) = t3;
      }
    }
    if (j == last)
      for (int i = 0; i < 8; i++) y1[j + i] = y2[j + i] = 0;
    for (int part = last; part < last + 8; part += wide) {
      const REAL *b = a + (part - first);
      const LANES b0 = VECTOR(b), b1 = VECTOR(b + m), b2 = VECTOR(b + 2 * m), b3 = VECTOR(b + 3 * m);
      VECTOR(y1 + part) += b0 * p[0] + b1 * p[1] + b2 * p[2] + b3 * p[3];
      VECTOR(y2 + part) += b0 * q[0] + b1 * q[1] + b2 * q[2] + b3 * q[3];
    }
    for (int k = 0; k < 4; k++) {
      y1[j + k] += SUM(sums[k]);
      y2[j + k] += SUM(sums[4 + k]);
    }
    a += 4 * m;
  }
}
