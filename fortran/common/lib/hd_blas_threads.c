/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Threads of OpenBLAS; other BLAS libraries lack these symbols and keep their own number. */
extern void openblas_set_num_threads(int n) __attribute__((weak));
extern int openblas_get_num_threads(void) __attribute__((weak));

/* Use n threads from now on; returns the number before. */
int hd_blas_threads(int n)
{
  int before = n;
  if (openblas_set_num_threads && openblas_get_num_threads) {
    before = openblas_get_num_threads();
    openblas_set_num_threads(n);
  }
  return before;
}
