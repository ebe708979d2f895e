/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Signals that ask for an orderly stop only set a flag; the load-step loop reads it. */
#include <signal.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <errno.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

static volatile sig_atomic_t stop_requested = 0;

static void request_stop(int number) { stop_requested = number; }

void hd_catch_signals(void)
{
  signal(SIGTERM, request_stop);
  signal(SIGUSR1, request_stop);
  signal(SIGXCPU, request_stop);
  signal(SIGINT, request_stop);
}

int hd_stop_requested(void) { return stop_requested; }

/* 0: done or already there. */
int hd_make_directory(const char *path)
{
  return mkdir(path, 0777) == 0 || errno == EEXIST ? 0 : errno;
}

int hd_rename(const char *from, const char *to) { return rename(from, to); }

int hd_truncate(const char *path, long long bytes) { return truncate(path, (off_t)bytes); }

int hd_remove(const char *path) { return unlink(path); }

/* 0 absent, 1 file, 2 directory. */
int hd_path_kind(const char *path)
{
  struct stat s;
  if (stat(path, &s) != 0) return 0;
  return S_ISDIR(s.st_mode) ? 2 : 1;
}

int hd_is_terminal(void) { return isatty(1); }

/* Become another program, the one beside this if there is one, else one of the search path; returns if neither is there. */
void hd_become(char *const words[])
{
  char path[PATH_MAX];
  ssize_t n = readlink("/proc/self/exe", path, sizeof path - 1);
  if (n > 0) {
    path[n] = 0;
    char *name = strrchr(path, '/') + 1;
    if ((size_t)snprintf(name, path + sizeof path - name, "%s", words[0]) < (size_t)(path + sizeof path - name)) execv(path, words);
  }
  execvp(words[0], words);
}

/* A factorisation takes and gives back hundreds of MB each time; keep them (saves a fifth of the time, measured). */
void hd_keep_memory(void)
{
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, 2147483647);
#endif
}
