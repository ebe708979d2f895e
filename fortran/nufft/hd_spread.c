/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Inner loops of the non-uniform FFT, compiled for several widths of vector register; the processor picks at load time. */
#include "../waves/hd_cis.h"

#define REAL double
#define NAME(name) name
#include "hd_spread_kernels.h"
#undef REAL
#undef NAME
#define REAL float
#define NAME(name) name##_single
#include "hd_spread_kernels.h"
