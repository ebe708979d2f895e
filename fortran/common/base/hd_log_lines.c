/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lines of the log for a program that calls the engine: one thread writes, another reads; the oldest are lost first. */
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

enum { n_lines = 256, length = 2048 };
static char lines[n_lines][length];
static unsigned first = 0, count = 0;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

/* A line on standard output; 0, or the system's error, which Fortran's own units keep to themselves. */
int hd_print_line(const char *text, int n)
{
  struct iovec parts[2] = {{(void *)text, (size_t)n}, {"\n", 1}};
  while (parts[1].iov_len > 0) {
    ssize_t done = writev(STDOUT_FILENO, parts, 2);
    if (done < 0 && errno == EAGAIN) poll(&(struct pollfd){STDOUT_FILENO, POLLOUT, 0}, 1, -1); /* others made it not wait */
    else if (done < 0 && errno != EINTR) return errno;
    for (int i = 0; i < 2 && done > 0; i++) {
      size_t part = (size_t)done < parts[i].iov_len ? (size_t)done : parts[i].iov_len;
      parts[i].iov_base = (char *)parts[i].iov_base + part;
      parts[i].iov_len -= part;
      done -= (ssize_t)part;
    }
  }
  return 0;
}

void hd_keep_line(const char *text, int n)
{
  pthread_mutex_lock(&lock);
  char *line = lines[(first + count) % n_lines];
  if (count < n_lines) count++;
  else first = (first + 1) % n_lines;
  int whole = n < length;
  if (!whole) n = length - 1;
  memcpy(line, text, (size_t)n);
  if (!whole) memcpy(line + n - 4, " ...", 4);
  line[n] = 0;
  pthread_mutex_unlock(&lock);
}

/* The oldest line into text, padded with blanks; 0: there is none. */
int hd_take_line(char *text, int size)
{
  int n = 0, found;
  memset(text, ' ', (size_t)size);
  pthread_mutex_lock(&lock);
  found = count > 0;
  if (found) {
    n = (int)strlen(lines[first]);
    memcpy(text, lines[first], (size_t)(n < size ? n : size));
    first = (first + 1) % n_lines;
    count--;
  }
  pthread_mutex_unlock(&lock);
  return found;
}

/* In a forked child: a lock that another thread of the parent held stays locked for ever. */
void hd_renew_lines(void) { pthread_mutex_init(&lock, NULL); }
