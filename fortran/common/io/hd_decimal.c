/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Decimal text of a number with all its digits (17) that reads back as the same number, in any locale; eight times as fast
   as a Fortran write. */
#define _GNU_SOURCE
#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { DIGITS = 17, FIRST = -330, LAST = 330 };
static const uint64_t LEAST = UINT64_C(10000000000000000); /* of 17 digits */

/* As "%.17g" in the C locale, exact to the last digit. */
static int slowly(double x, char *text)
{
  static locale_t plain = 0;
  if (!plain) plain = newlocale(LC_NUMERIC_MASK, "C", 0);
  locale_t users = uselocale(plain);
  int length = snprintf(text, 25, "%.17g", x);
  uselocale(users);
  return length;
}

/* 17 digits of x > 0 as an integer, and the power of ten of the first, which is that of x's power of two or one more. The product
   of x and a power of ten in 64 bits errs by at most 0.02 of the last digit beside the rounding; numbers of double precision lie
   1.1 of it apart or more. */
static uint64_t digits_of(double x, int *power)
{
  static long double tens[LAST - FIRST + 1];
  if (tens[LAST - FIRST] == 0)
    for (int i = 0; i <= LAST - FIRST; i++) tens[i] = powl(10, FIRST + i); /* threads that meet here write the same */
  int k = (int)floor(ilogb(x) * 0.30102999566398120);
  uint64_t m = (uint64_t)(x * tens[DIGITS - 1 - k - FIRST] + 0.5L);
  if (m >= 10 * LEAST) m = (uint64_t)(x * tens[DIGITS - 1 - ++k - FIRST] + 0.5L);
  *power = k;
  return m;
}

/* Length of text, which holds at least 25 characters. */
int hd_decimal(double x, char *text)
{
  if (x == 0) return (int)strlen(strcpy(text, signbit(x) ? "-0" : "0"));
  if (LDBL_MANT_DIG < 64 || !isnormal(x)) return slowly(x, text);
  int k, kept = DIGITS;
  uint64_t m = digits_of(fabs(x), &k);
  char digits[DIGITS], *t = text;
  uint32_t low = (uint32_t)(m % 1000000000), high = (uint32_t)(m / 1000000000);
  for (int i = DIGITS - 1; i >= DIGITS - 9; i--, low /= 10) digits[i] = (char)('0' + low % 10);
  for (int i = DIGITS - 10; i >= 0; i--, high /= 10) digits[i] = (char)('0' + high % 10);
  while (kept > 1 && digits[kept - 1] == '0') kept--;
  if (x < 0) *t++ = '-';
  int ahead = k >= -4 && k < DIGITS ? k + 1 : 1; /* digits before the point */
  if (k < 0 && ahead < 1) {
    memcpy(t, "0.000", (size_t)(2 - ahead));
    t += 2 - ahead;
    ahead = 0;
  } else {
    for (; ahead > kept; kept++) digits[kept] = '0';
    memcpy(t, digits, (size_t)ahead);
    t += ahead;
    if (kept > ahead) *t++ = '.';
  }
  memcpy(t, digits + ahead, (size_t)(kept - ahead));
  t += kept - ahead;
  if (k < -4 || k >= DIGITS) {
    int size = k < 0 ? -k : k;
    *t++ = 'e';
    *t++ = k < 0 ? '-' : '+';
    if (size >= 100) *t++ = (char)('0' + size / 100);
    *t++ = (char)('0' + size / 10 % 10);
    *t++ = (char)('0' + size % 10);
  }
  *t = 0;
  return (int)(t - text);
}

/* Lines of a table: each begins with n characters, numbers follow (columns, rows), joined by commas. Length of text, which holds
   n + 25 characters a number for each. */
long long hd_rows(const char *first, int n, const double *numbers, int columns, int rows, char *text)
{
  char *t = text;
  for (int i = 0; i < rows; i++) {
    memcpy(t, first, (size_t)n);
    t += n;
    for (int j = 0; j < columns; j++) {
      t += hd_decimal(*numbers++, t);
      *t++ = j < columns - 1 ? ',' : '\n';
    }
  }
  return t - text;
}
