/* SPDX-License-Identifier: GPL-3.0-or-later */
/* FFTW's planner is not safe in threads: one lock for the process, whichever kind of thread calls. */
#include <pthread.h>

static pthread_mutex_t planner = PTHREAD_MUTEX_INITIALIZER;

void hd_lock_planner(void) { pthread_mutex_lock(&planner); }

void hd_unlock_planner(void) { pthread_mutex_unlock(&planner); }

void hd_renew_planner(void) { pthread_mutex_init(&planner, NULL); }
