/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions compiled for several widths of vector register. CLONES: the compiler makes the vectors, the processor picks at load
   time. Kernels that spell out their vectors: hd_lanes.h. -DHD_WIDEST=32 leaves out the registers of 64 bytes. */
#ifndef HD_CLONES_H
#define HD_CLONES_H

#ifndef HD_WIDEST
#define HD_WIDEST 64
#endif

#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#if HD_WIDEST >= 64
#define CLONES __attribute__((target_clones("avx512f", "fma", "default")))
#else
#define CLONES __attribute__((target_clones("fma", "default")))
#endif
#else
#define CLONES
#endif

/* Bytes of the widest register that the processor has, at most `most` where that is not 0. */
static inline int register_bytes(int most)
{
#if defined(__x86_64__) && defined(__GNUC__)
  const int limit = most > 0 && most < HD_WIDEST ? most : HD_WIDEST;
  if (limit >= 64 && __builtin_cpu_supports("avx512f")) return 64;
  if (limit >= 32 && __builtin_cpu_supports("fma")) return 32;
#endif
  (void)most;
  return 16;
}

/* Calls f for the widest registers of at most `most` bytes (0: any). */
#if defined(__x86_64__) && defined(__GNUC__)
#define PICK(most, f, ...) \
  switch (register_bytes(most)) { \
  case 64: f##_64(__VA_ARGS__); break; \
  case 32: f##_32(__VA_ARGS__); break; \
  default: f##_16(__VA_ARGS__); \
  }
#else
#define PICK(most, f, ...) f##_16(__VA_ARGS__)
#endif

#endif
