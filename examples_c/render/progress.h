/* How far the rendering is, on stderr: a bar on a terminal, a few lines `NN%` elsewhere. */
#ifndef RENDER_PROGRESS_H
#define RENDER_PROGRESS_H

#include <stdint.h>

typedef enum { PROGRESS_NONE, PROGRESS_BAR, PROGRESS_LINES } progress_style;

typedef struct {
    progress_style style;
    double max_passes;     /* 0: no limit */
    double max_seconds;    /* 0: no limit */
    double paths_per_pass;
    const char *unit; /* what there are so many of */
    double drawn_at;       /* seconds */
    int last_percent;
} progress;

void progress_start(progress *p, int quiet, uint64_t max_passes, double max_seconds, uint32_t paths_per_pass, const char *unit);

/* For render_job.report: `user` is the progress. */
void progress_report(void *user, double passes, double seconds);

/* For render_job.note: a line of text. */
void progress_note(void *user, const char *text);

/* Ends the bar's line. */
void progress_end(progress *p);

#endif
