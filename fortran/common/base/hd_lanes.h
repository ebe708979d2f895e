/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Compiles the file KERNEL for registers of 64, 32 and 16 bytes. A vector wider than the register would go through the stack.
   In KERNEL, BYTES is the width, NAME(f) the function f of that width and TARGET its attribute; PICK calls the widest that runs. */
#include "hd_clones.h"

#if defined(__x86_64__) && defined(__GNUC__)
#define BYTES 64
#define TARGET __attribute__((target("avx512f,fma")))
#define NAME(f) f##_64
#include KERNEL
#undef BYTES
#undef TARGET
#undef NAME
#define BYTES 32
#define TARGET __attribute__((target("fma")))
#define NAME(f) f##_32
#include KERNEL
#undef BYTES
#undef TARGET
#undef NAME
#endif
#define BYTES 16
#define TARGET
#define NAME(f) f##_16
#include KERNEL
#undef BYTES
#undef TARGET
#undef NAME
