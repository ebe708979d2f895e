/* SPDX-License-Identifier: GPL-3.0-or-later */
/* glibc 2.35 has a new hypot and vector forms of it and of asin. The linker sends calls here (--wrap), to the hypot of every glibc,
   the same to the bit, so that a build starts on older systems too. */
#include <emmintrin.h>
#include <math.h>

double hd_hypot(double x, double y);
__asm__(".symver hd_hypot, hypot@GLIBC_2.2.5");

double __wrap_hypot(double x, double y) { return hd_hypot(x, y); }

__m128d __wrap__ZGVbN2vv_hypot(__m128d x, __m128d y) { return _mm_set_pd(hd_hypot(x[1], y[1]), hd_hypot(x[0], y[0])); }

__m128d __wrap__ZGVbN2v_asin(__m128d x) { return _mm_set_pd(asin(x[1]), asin(x[0])); }
