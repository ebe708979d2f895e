/* SPDX-License-Identifier: GPL-3.0-or-later */
/* CRC-64 of xz (ECMA-182, reflected): a changed file passes once in 2e19 times. Not made to withstand a forger. */
#include <stdint.h>
#include <stdio.h>

/* table[k][c]: of the byte c with k zero bytes behind it, so that eight bytes are taken at once. */
static uint64_t table[8][256];

static void fill_table(void)
{
  for (int i = 0; i < 256; i++) {
    uint64_t c = (uint64_t)i;
    for (int k = 0; k < 8; k++) c = (c >> 1) ^ (c & 1 ? UINT64_C(0xC96C5795D7870F42) : 0);
    table[0][i] = c; /* threads that meet here write the same */
  }
  for (int i = 0; i < 256; i++)
    for (int k = 1; k < 8; k++) table[k][i] = table[0][table[k - 1][i] & 255] ^ (table[k - 1][i] >> 8);
}

/* Checksum of bytes that follow those of `before` (0: the first ones). */
uint64_t hd_bytes_checksum(uint64_t before, const unsigned char *bytes, long long n)
{
  if (!table[7][255]) fill_table();
  uint64_t c = ~before;
  for (; n >= 8; n -= 8, bytes += 8) {
    uint64_t next = 0;
    for (int k = 0; k < 8; k++) next ^= table[7 - k][((c >> 8 * k) ^ bytes[k]) & 255];
    c = next;
  }
  for (; n > 0; n--) c = table[0][(c ^ *bytes++) & 255] ^ (c >> 8);
  return ~c;
}

/* Checksum of the first n bytes of a file; 0: done, 1: it cannot be read or is shorter. */
int hd_file_checksum(const char *path, long long n, uint64_t *sum)
{
  unsigned char buffer[65536];
  FILE *file = fopen(path, "rb");
  *sum = 0;
  if (!file) return 1;
  while (n > 0) {
    size_t got = fread(buffer, 1, n < (long long)sizeof buffer ? (size_t)n : sizeof buffer, file);
    if (got == 0) break;
    *sum = hd_bytes_checksum(*sum, buffer, (long long)got);
    n -= (long long)got;
  }
  fclose(file);
  return n > 0;
}
