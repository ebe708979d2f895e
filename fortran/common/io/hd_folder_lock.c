/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One process at a time writes into a folder. The lock is the kernel's (flock) on a file that names its holder, so it ends with
   the process, however that ends; where the file system knows no such locks, the name of the holder decides. */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { taken = 0, held = 1, no_file = 2, held_elsewhere = 3, not_regular = 4 };

/* Ticks from boot to the start of a process, 0 if there is none: a number that is used again belongs to another process. */
static unsigned long long start_of(long pid)
{
  char path[64], text[1024];
  snprintf(path, sizeof path, "/proc/%ld/stat", pid);
  FILE *file = fopen(path, "r");
  if (!file) return 0;
  size_t n = fread(text, 1, sizeof text - 1, file);
  fclose(file);
  text[n] = 0;
  char *p = strrchr(text, ')');
  for (int field = 2; p && field < 22; field++) p = strchr(p + 1, ' ');
  return p ? strtoull(p + 1, NULL, 10) : 0;
}

/* Is the holder that a lock names at work? 0 no, 1 on this machine, 2 it may be, on another. */
static int at_work(const char *holder, const char *host)
{
  long pid;
  char where[256];
  unsigned long long start;
  if (sscanf(holder, "process %ld on %255[^,], start %llu", &pid, where, &start) != 3) return 0;
  if (strcmp(where, host) != 0) return 2;
  if (kill((pid_t)pid, 0) != 0 && errno != EPERM) return 0;
  return start == 0 || start_of(pid) == start;
}

/* Take the lock in the file `path`; `fd` is its handle, `holder` gets who has it where that is another. With `kernel` 0 the
   name alone decides. */
int hd_take_lock(const char *path, int kernel, int *fd, char *holder, int size)
{
  char host[256] = "", line[512], when[32];
  gethostname(host, sizeof host - 1);
  for (;;) {
    struct stat here, there;
    *fd = -1;
    *holder = 0;
    if (lstat(path, &here) == 0 && !S_ISREG(here.st_mode)) return not_regular;
    int f = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    if (f < 0) return no_file;
    int refused = kernel && flock(f, LOCK_EX | LOCK_NB) != 0;
    int busy = refused && (errno == EWOULDBLOCK || errno == EINTR);
    if (!busy && (stat(path, &there) != 0 || fstat(f, &here) != 0 || here.st_ino != there.st_ino)) {
      close(f); /* its holder has just removed it */
      continue;
    }
    ssize_t n = pread(f, holder, (size_t)size - 1, 0);
    holder[n > 0 ? n : 0] = 0;
    if (strchr(holder, '\n')) *strchr(holder, '\n') = 0;
    int named = !kernel || refused ? at_work(holder, host) : 0;
    if (busy || named) {
      close(f);
      return !busy && named == 2 ? held_elsewhere : held;
    }
    if (here.st_nlink > 1) { /* the file of a copy by hard links (cp -al) too */
      int gone = unlink(path) == 0;
      close(f);
      if (gone) continue;
      return no_file;
    }
    time_t now = time(NULL);
    strftime(when, sizeof when, "%Y-%m-%dT%H:%M:%S", localtime(&now));
    n = snprintf(line, sizeof line, "process %ld on %s, start %llu, since %s\n", (long)getpid(), host, start_of(getpid()), when);
    if (ftruncate(f, 0) != 0 || pwrite(f, line, (size_t)n, 0) != n) {
      unlink(path);
      flock(f, LOCK_UN);
      close(f);
      return no_file;
    }
    *holder = 0;
    *fd = f;
    return taken;
  }
}

/* Give a lock back; a process that was forked leaves it to its parent. */
void hd_give_lock(const char *path, int fd)
{
  char line[64] = "";
  long pid = 0;
  ssize_t n = pread(fd, line, sizeof line - 1, 0);
  line[n > 0 ? n : 0] = 0;
  if (sscanf(line, "process %ld", &pid) == 1 && pid == (long)getpid()) {
    unlink(path);
    flock(fd, LOCK_UN);
  }
  close(fd);
}
