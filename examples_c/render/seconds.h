/* The clocks. */
#ifndef RENDER_SECONDS_H
#define RENDER_SECONDS_H

/* On the wall, since some fixed time. */
double seconds_wall(void);

/* Of all threads of this process. */
double seconds_cpu(void);

#endif
