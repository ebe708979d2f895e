/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Threads and kernels of OpenBLAS; other BLAS libraries lack these symbols, keep their own number, and name no kernels. */
#include <stddef.h>
#include <string.h>
extern void openblas_set_num_threads(int n) __attribute__((weak));
extern int openblas_get_num_threads(void) __attribute__((weak));
extern char *openblas_get_corename(void) __attribute__((weak));

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

/* The processor whose kernels are in use, padded with blanks. */
void hd_blas_kernels(char *text, int size)
{
  const char *name = openblas_get_corename ? openblas_get_corename() : "";
  size_t n = strlen(name);
  memset(text, ' ', (size_t)size);
  memcpy(text, name, n < (size_t)size ? n : (size_t)size);
}
