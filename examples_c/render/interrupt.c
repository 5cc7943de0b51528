#define _POSIX_C_SOURCE 200809L /* sigaction, write */

#include "interrupt.h"

#include <errno.h>
#include <stddef.h>
#include <unistd.h>

static volatile sig_atomic_t interrupted;

/* Calls only what POSIX allows in a signal handler. */
static void on_signal(int signal)
{
    static const char text[] = "\nvolgrad-render: ending this pass or round; once more to quit at once\n";
    int saved_errno = errno;
    (void)signal;
    if (interrupted || write(STDERR_FILENO, text, sizeof text - 1) < 0) {
        _exit(EXIT_INTERRUPTED);
    }
    interrupted = 1;
    errno = saved_errno;
}

const volatile sig_atomic_t *interrupt_watch(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    return &interrupted;
}
