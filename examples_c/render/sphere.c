#include "sphere.h"

int sphere_roots(vec3d center, double radius, vec3d origin, vec3d direction, double *entry, double *exit)
{
    vec3d to_center = vec3d_sub(center, origin);
    double length2 = vec3d_dot(direction, direction);
    double middle = vec3d_dot(to_center, direction) / length2;
    /* The distance of the centre from the line by its own vector: b*b - c of the school formula cancels from afar. */
    vec3d miss = vec3d_along(to_center, -middle, direction);
    double half_chord2 = (radius * radius - vec3d_dot(miss, miss)) / length2;
    if (!(half_chord2 > 0.0)) {
        return 0;
    }
    double half_chord = sqrt(half_chord2);
    *entry = middle - half_chord;
    *exit = middle + half_chord;
    return 1;
}
