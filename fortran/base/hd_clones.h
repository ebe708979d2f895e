/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions compiled for several widths of vector register; the processor picks at load time. */
#ifndef HD_CLONES_H
#define HD_CLONES_H

#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#define CLONES __attribute__((target_clones("avx512f", "fma", "default")))
#else
#define CLONES
#endif

typedef double lanes __attribute__((vector_size(64), aligned(8)));
#define LANES(p) (*(lanes *)(p))
#define READ(p) (*(const lanes *)(p))

#endif
