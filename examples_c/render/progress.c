#define _POSIX_C_SOURCE 200809L /* fileno, isatty */

#include "progress.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

enum { LINE_WIDTH = 79, BAR_WIDTH = 30, LINE_STEP = 5 /* percent; so there are at most 20 lines */ };

static const double REDRAW_SECONDS = 0.1;

void progress_start(progress *p, int quiet, uint64_t max_passes, double max_seconds, uint32_t paths_per_pass, const char *unit)
{
    progress_style style = isatty(fileno(stderr)) ? PROGRESS_BAR : PROGRESS_LINES;
    *p = (progress){.style = quiet ? PROGRESS_NONE : style,
                    .max_passes = (double)max_passes,
                    .max_seconds = max_seconds,
                    .paths_per_pass = paths_per_pass,
                    .unit = unit,
                    .drawn_at = -INFINITY};
}

/* The share that is done by whichever limit comes first, in [0, 1]. */
static double share_done(const progress *p, double passes, double seconds)
{
    double by_passes = p->max_passes > 0.0 ? passes / p->max_passes : 0.0;
    double by_seconds = p->max_seconds > 0.0 ? seconds / p->max_seconds : 0.0;
    return fmin(fmax(by_passes, by_seconds), 1.0);
}

/* As in 12.3M. Writes to `text`. */
static const char *with_prefix(double value, char *text, size_t size)
{
    static const char prefixes[] = {' ', 'k', 'M', 'G'};
    size_t i = 0;
    while (value >= 999.5 && i + 1 < sizeof prefixes) {
        value /= 1000.0;
        i++;
    }
    snprintf(text, size, "%.3g%c", value, prefixes[i]);
    return text;
}

static void draw_bar(const progress *p, double share, double paths_per_second, double seconds_left)
{
    char bar[BAR_WIDTH + 1], rate[32];
    int filled = (int)(share * BAR_WIDTH);
    for (int i = 0; i < BAR_WIDTH; ++i) {
        bar[i] = i < filled ? '#' : '.';
    }
    bar[BAR_WIDTH] = '\0';
    long left = (long)ceil(fmin(seconds_left, 360000.0));
    fprintf(stderr, "\r[%s] %3d%%  %s %s/s  ETA %ld:%02ld:%02ld ", bar, (int)(100.0 * share),
            with_prefix(paths_per_second, rate, sizeof rate), p->unit, left / 3600, left / 60 % 60, left % 60);
    fflush(stderr);
}

static void write_line(progress *p, double share)
{
    int percent = (int)(100.0 * share) / LINE_STEP * LINE_STEP;
    if (percent > p->last_percent) {
        p->last_percent = percent;
        fprintf(stderr, "%d%%\n", percent);
    }
}

void progress_report(void *user, double passes, double seconds)
{
    progress *p = user;
    double share = share_done(p, passes, seconds);
    if (p->style == PROGRESS_LINES) {
        write_line(p, share);
    } else if (p->style == PROGRESS_BAR && (seconds - p->drawn_at >= REDRAW_SECONDS || share >= 1.0)) {
        p->drawn_at = seconds;
        draw_bar(p, share, seconds > 0.0 ? passes * p->paths_per_pass / seconds : 0.0,
                 share > 0.0 ? seconds * (1.0 - share) / share : INFINITY);
    }
}

void progress_note(void *user, const char *text)
{
    const progress *p = user;
    if (p->style == PROGRESS_LINES) {
        fprintf(stderr, "%s\n", text);
    } else if (p->style == PROGRESS_BAR) {
        fprintf(stderr, "\r%-*s\n", LINE_WIDTH, text);
    }
}

void progress_end(progress *p)
{
    if (p->style == PROGRESS_BAR) {
        fputc('\n', stderr);
    }
}
