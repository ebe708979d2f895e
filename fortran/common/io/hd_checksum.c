/* SPDX-License-Identifier: GPL-3.0-or-later */
/* CRC-64 of xz (ECMA-182, reflected): a changed file passes once in 2e19 times. Not made to withstand a forger. */
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#define POLYNOMIAL UINT64_C(0xC96C5795D7870F42)

/* table[k][c]: of the byte c with k zero bytes behind it, so that eight bytes are taken at once. */
static uint64_t table[8][256];

static void fill_table(void)
{
  for (int i = 0; i < 256; i++) {
    uint64_t c = (uint64_t)i;
    for (int k = 0; k < 8; k++) c = (c >> 1) ^ (c & 1 ? POLYNOMIAL : 0);
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

/* Product of two polynomials, the highest bit being that of x^0. */
static uint64_t product(uint64_t a, uint64_t b)
{
  uint64_t p = 0;
  for (; a; a <<= 1) {
    if (a >> 63) p ^= b;
    b = (b >> 1) ^ (b & 1 ? POLYNOMIAL : 0);
  }
  return p;
}

/* Checksum of bytes that follow those of `before`, from the checksum of these n alone. */
uint64_t hd_joined_checksum(uint64_t before, uint64_t sum, long long n)
{
  for (uint64_t power = UINT64_C(1) << 55; n > 0; n >>= 1, power = product(power, power))
    if (n & 1) before = product(power, before);
  return before ^ sum;
}

/* Checksum of the first n bytes of a file, of all if n < 0, which go into a new file `copy` too unless that is empty. 0: done,
   -1: it cannot be read or is shorter, else the system's error of writing. */
int hd_file_checksum(const char *path, const char *copy, long long n, uint64_t *sum)
{
  enum { piece = 1 << 17, pieces = 32 }; /* bytes that a thread takes, of so many that are read at once */
  uint64_t sums[pieces];
  struct stat s;
  int status = 0, to = -1, from = open(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  unsigned char *buffer = malloc((size_t)piece * pieces);
  *sum = 0;
  if (!buffer) status = ENOMEM;
  if (!table[7][255]) fill_table();
  if (from < 0 || fstat(from, &s) != 0 || !S_ISREG(s.st_mode) || s.st_size < n) status = -1;
  if (status == 0 && n < 0) n = s.st_size;
  if (status == 0 && *copy) {
    unlink(copy);
    if ((to = open(copy, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) < 0) status = errno;
  }
  while (status == 0 && n > 0) {
    ssize_t got = read(from, buffer, n < piece * pieces ? (size_t)n : (size_t)piece * pieces);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      status = -1;
      break;
    }
#pragma omp parallel for if (got > 2 * piece)
    for (ssize_t i = 0; i < (got + piece - 1) / piece; i++)
      sums[i] = hd_bytes_checksum(0, buffer + i * piece, got < (i + 1) * piece ? got - i * piece : piece);
    for (ssize_t i = 0; i * piece < got; i++)
      *sum = hd_joined_checksum(*sum, sums[i], got < (i + 1) * piece ? got - i * piece : piece);
    n -= (long long)got;
    for (ssize_t done = 0, put; to >= 0 && status == 0 && done < got; done += put > 0 ? put : 0)
      if ((put = write(to, buffer + done, (size_t)(got - done))) <= 0 && errno != EINTR) status = put < 0 ? errno : ENOSPC;
  }
  if (to >= 0 && close(to) != 0 && status == 0) status = errno;
  if (from >= 0) close(from);
  free(buffer);
  if (to >= 0 && status != 0) unlink(copy);
  return status;
}
