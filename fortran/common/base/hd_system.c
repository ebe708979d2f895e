/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Signals that ask for an orderly stop only set a flag; the load-step loop reads it. */
#include <dirent.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <signal.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <errno.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

static volatile sig_atomic_t stop_requested = 0;
static const int signals[] = {SIGINT, SIGQUIT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGALRM, SIGXCPU};
enum { n_signals = sizeof signals / sizeof *signals };
static struct sigaction others[n_signals]; /* handlers of the program that this is a library of */
static int watching = 0;

static void request_stop(int number) { stop_requested = number; }

/* The i-th of them, from 0; 0: there is none. */
int hd_stop_signal(int i) { return i >= 0 && i < n_signals ? signals[i] : 0; }

/* For hdengine.x. What is ignored stays so (nohup, jobs in the background); a second SIGINT or SIGQUIT ends the process. A reader
   that is gone and a limit of file sizes are errors of writing. */
void hd_catch_signals(void)
{
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);
  for (int i = 0; i < n_signals; i++) {
    struct sigaction now;
    if (sigaction(signals[i], NULL, &now) == 0 && now.sa_handler == SIG_IGN) continue;
    memset(&now, 0, sizeof now);
    now.sa_handler = request_stop;
    now.sa_flags = SA_RESTART | (signals[i] == SIGINT || signals[i] == SIGQUIT ? (int)SA_RESETHAND : 0);
    sigaction(signals[i], &now, NULL);
  }
}

/* Set the flag and let the program know too. */
static void request_and_pass(int number, siginfo_t *info, void *context)
{
  stop_requested = number;
  for (int i = 0; i < n_signals; i++) {
    if (signals[i] != number) continue;
    if (others[i].sa_flags & SA_SIGINFO) others[i].sa_sigaction(number, info, context);
    else others[i].sa_handler(number);
  }
}

/* For a program that calls the engine: from here on signals that it has handlers for stop the engine too. */
void hd_watch_signals(void)
{
  stop_requested = 0;
  watching = 1;
  for (int i = 0; i < n_signals; i++) {
    struct sigaction now;
    if (sigaction(signals[i], NULL, &others[i]) != 0) others[i].sa_handler = SIG_DFL;
    if (others[i].sa_handler == SIG_DFL || others[i].sa_handler == SIG_IGN) continue;
    memset(&now, 0, sizeof now);
    now.sa_sigaction = request_and_pass;
    now.sa_flags = others[i].sa_flags | SA_SIGINFO;
    now.sa_mask = others[i].sa_mask;
    sigaction(signals[i], &now, NULL);
  }
}

/* The end of that; the signal that stopped the engine, or 0. */
int hd_unwatch_signals(void)
{
  int number = stop_requested;
  if (!watching) return 0;
  watching = 0;
  for (int i = 0; i < n_signals; i++)
    if (others[i].sa_handler != SIG_DFL && others[i].sa_handler != SIG_IGN) sigaction(signals[i], &others[i], NULL);
  stop_requested = 0;
  return number;
}

/* Between two calls a stop waits: what it would tear apart is finished first. */
static int waits = 0;
void hd_hold_stop(int on) { waits = on; }

int hd_stop_requested(void) { return waits ? 0 : stop_requested; }

/* The process may not take all addresses (ulimit -v, ulimit -d). */
int hd_addresses_limited(void)
{
  struct rlimit all, data;
  return (getrlimit(RLIMIT_AS, &all) == 0 && all.rlim_cur != RLIM_INFINITY) ||
         (getrlimit(RLIMIT_DATA, &data) == 0 && data.rlim_cur != RLIM_INFINITY);
}

int hd_make_directory(const char *path) { return mkdir(path, 0777) == 0 ? 0 : errno; }

int hd_rename(const char *from, const char *to) { return rename(from, to) == 0 ? 0 : errno; }

/* Standard streams that are closed lead nowhere: the next file opened would get their place, and the log in it. */
void hd_fill_streams(void)
{
  int file;
  while ((file = open("/dev/null", O_RDWR)) >= 0 && file <= 2) continue;
  if (file > 2) close(file);
}

/* 1: nothing stands at a path, or a file that is no link. */
int hd_writable_kind(const char *path)
{
  struct stat s;
  return lstat(path, &s) != 0 || S_ISREG(s.st_mode);
}

/* Why no file can be begun at a path, -1: one can. The compiler's library looks for other files before it hands on the error. */
int hd_begin_error(const char *path)
{
  int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0) return errno;
  unlink(path);
  close(file);
  return -1;
}

/* Bytes of a file on the disk, -1: there is none. */
long long hd_file_bytes(const char *path)
{
  struct stat s;
  return stat(path, &s) == 0 ? (long long)s.st_size : -1;
}

/* Bring a closed file to the disk. 0: done and as long as it was written, -1: shorter or longer, else the system's error. */
int hd_settle(const char *path, long long bytes)
{
  struct stat s;
  int file = open(path, O_RDONLY | O_NOFOLLOW | O_CLOEXEC), status = 0;
  if (file < 0) return errno;
  if (fsync(file) != 0 && errno != EINVAL && errno != EROFS && errno != ENOTSUP) status = errno; /* some systems know none */
  if (status == 0 && fstat(file, &s) != 0) status = errno;
  if (status == 0 && s.st_size != bytes) status = -1;
  close(file);
  return status;
}

/* The system's words for its error, padded with blanks. */
void hd_system_text(int number, char *text, int size)
{
  const char *words = strerror(number);
  size_t n = strlen(words);
  memset(text, ' ', (size_t)size);
  memcpy(text, words, n < (size_t)size ? n : (size_t)size);
}

int hd_remove(const char *path) { return unlink(path); }

/* Remove the files of a folder whose names match a pattern. */
void hd_remove_matching(const char *folder, const char *pattern)
{
  DIR *d = opendir(folder);
  for (struct dirent *entry; d && (entry = readdir(d));)
    if (fnmatch(pattern, entry->d_name, 0) == 0) unlinkat(dirfd(d), entry->d_name, 0);
  if (d) closedir(d);
}

int hd_remove_directory(const char *path) { return rmdir(path); }

/* 0 absent, 1 file, 2 directory, 3 anything else. */
int hd_path_kind(const char *path)
{
  struct stat s;
  if (stat(path, &s) != 0) return 0;
  return S_ISDIR(s.st_mode) ? 2 : S_ISREG(s.st_mode) ? 1 : 3;
}

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

/* Threads of OpenMP that wait spin for long, and take the processor from others; here they sleep after SPINS turns, some 50 us. One
   that sleeps at once takes as long to wake (16 threads: 45 us a loop in place of 5). The environment is read only as the
   library is loaded, so the program begins again. */
#define SPINS "1000"
enum { most_threads = 1024, least_stack = 1 << 20 };
void omp_set_num_threads(int n) __attribute__((weak));
int omp_get_max_threads(void) __attribute__((weak));
void hd_set_libraries(void)
{
  struct rlimit stack; /* of this process, which may grow, and of the threads of the next one */
  if (omp_get_max_threads && omp_get_max_threads() > most_threads) omp_set_num_threads(most_threads);
  if (getrlimit(RLIMIT_STACK, &stack) == 0 && stack.rlim_cur < least_stack) {
    stack.rlim_cur = stack.rlim_max < 8 * least_stack ? stack.rlim_max : 8 * least_stack;
    if (stack.rlim_cur < least_stack || setrlimit(RLIMIT_STACK, &stack) != 0) {
      fprintf(stderr, "error: the stack may take %lld kB (ulimit -s); valid: 1024 or more\n", (long long)stack.rlim_cur / 1024);
      _exit(6);
    }
  }
  static char path[PATH_MAX], *words[4096];
  if (getenv("OMP_WAIT_POLICY") || getenv("GOMP_SPINCOUNT")) return;
  ssize_t n = readlink("/proc/self/exe", path, sizeof path - 1);
  FILE *file = fopen("/proc/self/cmdline", "rbe");
  if (n > 0 && file) {
    static char text[1 << 20];
    size_t size = fread(text, 1, sizeof text, file);
    int count = 0;
    for (size_t i = 0; i < size && count < 4095; i += strlen(text + i) + 1) words[count++] = text + i;
    words[count] = NULL;
    path[n] = 0;
    if (size < sizeof text && count > 0 && count < 4095 &&
        setenv("OMP_WAIT_POLICY", "passive", 1) == 0 && setenv("GOMP_SPINCOUNT", SPINS, 1) == 0) execv(path, words);
  }
  if (file) fclose(file);
}

void hd_renew_lines(void);
void hd_renew_planner(void) __attribute__((weak));

/* In a forked child: the threads that OpenMP believes in are the parent's; a team of one waits for none of them. */
void hd_renew_after_fork(void)
{
  if (omp_set_num_threads) omp_set_num_threads(1);
  hd_renew_lines();
  if (hd_renew_planner) hd_renew_planner();
}

/* A factorisation takes and gives back hundreds of MB each time; keep them (saves a fifth of the time, measured). */
void hd_keep_memory(void)
{
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, 2147483647);
  mallopt(M_MXFAST, 0); /* else each large block waits until small ones are merged */
#endif
}
