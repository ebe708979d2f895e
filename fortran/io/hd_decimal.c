/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Decimal text of a number with all its digits (17), in any locale; three times as fast as a Fortran write. */
#define _GNU_SOURCE
#include <locale.h>
#include <stdio.h>

/* Length of text, which holds at least 25 characters. */
int hd_decimal(double x, char *text)
{
  static locale_t plain = 0;
  if (!plain) plain = newlocale(LC_NUMERIC_MASK, "C", 0);
  locale_t users = uselocale(plain);
  int length = snprintf(text, 25, "%.17g", x);
  uselocale(users);
  return length;
}
