/* Ctrl-C: the first ends the rendering after the current pass, a second one ends the process at once. */
#ifndef RENDER_INTERRUPT_H
#define RENDER_INTERRUPT_H

#include <signal.h>

/* The exit status of an interrupted run: 128 + SIGINT, as shells have it. */
enum { EXIT_INTERRUPTED = 130 };

/* From now on SIGINT and SIGTERM set the flag. Returns it: non-zero once a signal has come. */
const volatile sig_atomic_t *interrupt_watch(void);

#endif
