/* --debug-techniques: images of what each technique of the bidirectional sampler makes alone. */
#ifndef RENDER_TECHNIQUES_H
#define RENDER_TECHNIQUES_H

#include "image.h"

/* As many samples of each as made the source's image, the job's. Ends early, and well, when the job is stopped. Prints to stderr and
   returns 0 on failure. */
int techniques_write(const render_job *job, const image_source *source);

#endif
