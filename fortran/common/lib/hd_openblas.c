/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Threads and kernels of OpenBLAS; other BLAS libraries lack these symbols, keep their own number, and name no kernels. */
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
extern void openblas_set_num_threads(int n) __attribute__((weak));
extern int openblas_get_num_threads(void) __attribute__((weak));
extern char *openblas_get_corename(void) __attribute__((weak));
extern void gotoblas_dynamic_init(void) __attribute__((weak));
extern void gotoblas_dynamic_quit(void) __attribute__((weak));

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

/* An OpenBLAS older than the processor takes kernels without AVX2 (its issue 4267): the name of better ones, or NULL. */
static const char *better_kernels(void)
{
#ifdef __x86_64__
  static const char *const old[] = {"Prescott", "Nehalem", "Sandybridge", "Barcelona", "Bulldozer"};
  if (openblas_get_corename && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    for (size_t i = 0; i < sizeof old / sizeof *old; i++)
      if (strcmp(openblas_get_corename(), old[i]) == 0)
        return __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")
          ? "SkylakeX" : "Haswell";
#endif
  return NULL;
}

/* Let OpenBLAS, loaded but at rest, choose its kernels anew if there are better ones, unless the environment names some. It reads
   the environment as it is loaded, in Python also with a numpy that shares it: both come before us. */
void hd_choose_kernels(void)
{
  const char *better = getenv("OPENBLAS_CORETYPE") ? NULL : better_kernels();
  if (!better || !gotoblas_dynamic_init || !gotoblas_dynamic_quit || setenv("OPENBLAS_CORETYPE", better, 1) != 0) return;
  gotoblas_dynamic_quit();
  gotoblas_dynamic_init();
  unsetenv("OPENBLAS_CORETYPE");
}
