#define _GNU_SOURCE /* getopt_long */

#include "options.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "option_names.h"
#include "option_values.h"

enum {
    OPTION_SPP = 256,
    OPTION_TIME,
    OPTION_THREADS,
    OPTION_SEED,
    OPTION_MAX_DEPTH,
    OPTION_FIRST_VERTEX,
    OPTION_SHIFT,
    OPTION_SHIFT_COUNT,
    OPTION_SHIFT_RADIUS,
    OPTION_SHIFT_KERNEL,
    OPTION_SHIFT_RUN,
    OPTION_SHIFT_EXACT,
    OPTION_SHIFT_ALPHA,
    OPTION_SHIFT_CLAMP,
    OPTION_INTEGRATOR,
    OPTION_HEURISTIC,
    OPTION_GUIDE,
    OPTION_LIGHT_VERTICES,
    OPTION_ROULETTE,
    OPTION_DEBUG_TECHNIQUES,
    OPTION_DEBUG_CHAIN,
    OPTION_MUTATIONS,
    OPTION_CHAINS,
    OPTION_CHAIN_LENGTHS,
    OPTION_BOOTSTRAP,
    OPTION_BURN_IN,
    OPTION_LARGE_STEP,
    OPTION_SHIFT_EVERY,
    OPTION_CROP,
    OPTION_QUIET,
    OPTION_STATS,
    OPTION_VERSION,
    OPTION_HELP
};

static const struct option LONG_OPTIONS[] = {
    {"output", required_argument, NULL, 'o'},
    {"spp", required_argument, NULL, OPTION_SPP},
    {"time", required_argument, NULL, OPTION_TIME},
    {"threads", required_argument, NULL, OPTION_THREADS},
    {"seed", required_argument, NULL, OPTION_SEED},
    {"max-depth", required_argument, NULL, OPTION_MAX_DEPTH},
    {"first-vertex", required_argument, NULL, OPTION_FIRST_VERTEX},
    {"shift", required_argument, NULL, OPTION_SHIFT},
    {"shift-count", required_argument, NULL, OPTION_SHIFT_COUNT},
    {"shift-radius", required_argument, NULL, OPTION_SHIFT_RADIUS},
    {"shift-kernel", required_argument, NULL, OPTION_SHIFT_KERNEL},
    {"shift-run", required_argument, NULL, OPTION_SHIFT_RUN},
    {"shift-exact", required_argument, NULL, OPTION_SHIFT_EXACT},
    {"shift-alpha", required_argument, NULL, OPTION_SHIFT_ALPHA},
    {"shift-clamp", required_argument, NULL, OPTION_SHIFT_CLAMP},
    {"integrator", required_argument, NULL, OPTION_INTEGRATOR},
    {"heuristic", required_argument, NULL, OPTION_HEURISTIC},
    {"guide", required_argument, NULL, OPTION_GUIDE},
    {"light-vertices", required_argument, NULL, OPTION_LIGHT_VERTICES},
    {"roulette", required_argument, NULL, OPTION_ROULETTE},
    {"debug-techniques", required_argument, NULL, OPTION_DEBUG_TECHNIQUES},
    {"debug-chain", required_argument, NULL, OPTION_DEBUG_CHAIN},
    {"mutations", required_argument, NULL, OPTION_MUTATIONS},
    {"chains", required_argument, NULL, OPTION_CHAINS},
    {"chain-lengths", required_argument, NULL, OPTION_CHAIN_LENGTHS},
    {"bootstrap", required_argument, NULL, OPTION_BOOTSTRAP},
    {"burn-in", required_argument, NULL, OPTION_BURN_IN},
    {"large-step", required_argument, NULL, OPTION_LARGE_STEP},
    {"shift-every", required_argument, NULL, OPTION_SHIFT_EVERY},
    {"crop", required_argument, NULL, OPTION_CROP},
    {"quiet", no_argument, NULL, OPTION_QUIET},
    {"stats", no_argument, NULL, OPTION_STATS},
    {"version", no_argument, NULL, OPTION_VERSION},
    {"help", no_argument, NULL, OPTION_HELP},
    {NULL, 0, NULL, 0},
};

/* ---- one option ---- */

/* Most that volgrad_chain_plan takes. */
enum { MOST_CHAINS = 1 << 24 };

static int complain(const char *option, const char *value, const char *expected)
{
    fprintf(stderr, "volgrad-render: --%s %s: expected %s\n", option, value, expected);
    return 0;
}

static int read_max_depth(const char *text, options *out)
{
    out->has_max_depth = 1;
    if (strcmp(text, "-1") == 0) {
        out->max_depth = 0; /* volgrad's "no limit" */
        return 1;
    }
    return read_whole32(text, 1, INT32_MAX, &out->max_depth);
}

/* Options that mean nothing without --shift, --integrator bdpt, either, --integrator mmlt, path, or with bdpt: the last one seen of each,
   or NULL. */
typedef struct {
    const char *needs_shift;
    const char *needs_bdpt;
    const char *needs_lights; /* --integrator bdpt or mmlt, whose subpaths start at lights too */
    const char *needs_mmlt;
    const char *needs_path;
    const char *not_for_bdpt;
    int integrator, shift; /* whether they were given */
} usage;

static int take_chain_option(int option, const char *value, chain_settings *out, usage *seen)
{
    switch (option) {
    case OPTION_MUTATIONS:
        seen->needs_mmlt = "--mutations";
        return read_whole(value, 1, UINT32_MAX, &out->mutations_per_pixel) ||
               complain("mutations", value, "a whole number from 1 to 4294967295");
    case OPTION_CHAINS:
        seen->needs_mmlt = "--chains";
        return read_whole32(value, 1, MOST_CHAINS, &out->chains) || complain("chains", value, "a whole number from 1 to 16777216");
    case OPTION_CHAIN_LENGTHS:
        seen->needs_mmlt = "--chain-lengths";
        return read_range(value, 2, VOLGRAD_MAX_LENGTH, &out->options.min_length, &out->options.max_length) ||
               complain("chain-lengths", value, "A-B with 2 <= A <= B <= 64, numbers of edges");
    case OPTION_BOOTSTRAP:
        seen->needs_mmlt = "--bootstrap";
        return read_whole(value, 1, UINT32_MAX, &out->bootstrap) ||
               complain("bootstrap", value, "a whole number from 1 to 4294967295");
    case OPTION_BURN_IN:
        seen->needs_mmlt = "--burn-in";
        return read_whole32(value, 0, UINT32_MAX, &out->options.burn_in) ||
               complain("burn-in", value, "a whole number from 0 to 4294967295");
    case OPTION_LARGE_STEP:
        seen->needs_mmlt = "--large-step";
        return (read_share(value, &out->options.large_step) && out->options.large_step > 0.0f) ||
               complain("large-step", value, "a probability: > 0 and <= 1");
    default:
        seen->needs_mmlt = seen->needs_shift = "--shift-every";
        return read_whole32(value, 1, UINT32_MAX, &out->options.shift_every) ||
               complain("shift-every", value, "a whole number from 1 to 4294967295");
    }
}

static int take_shift_option(int option, const char *value, options *out, usage *seen)
{
    switch (option) {
    case OPTION_SHIFT:
        seen->shift = 1;
        return read_shift(value, &out->shift.mode) ||
               complain("shift", value,
                        "none, first_order, half_order, log_linear, linear_depth, exact, two_level, exchangeable, thesis or "
                        "thesis_printed");
    case OPTION_SHIFT_COUNT:
        seen->needs_shift = "--shift-count";
        return read_whole32(value, 1, UINT16_MAX, &out->shift.count) ||
               complain("shift-count", value, "a whole number from 1 to 65535");
    case OPTION_SHIFT_RADIUS:
        seen->needs_shift = "--shift-radius";
        return read_radius(value, &out->shift) ||
               complain("shift-radius", value, "a number > 0 of pixels, as in 4px, or of world units, as in 0.1");
    case OPTION_SHIFT_RUN:
        seen->needs_shift = seen->not_for_bdpt = "--shift-run";
        return read_whole32(value, 1, UINT16_MAX, &out->shift.run) ||
               complain("shift-run", value, "a whole number from 1 to 65535");
    case OPTION_SHIFT_EXACT:
        seen->needs_shift = "--shift-exact";
        return read_whole32(value, 1, UINT16_MAX, &out->shift.exact_count) ||
               complain("shift-exact", value, "a whole number from 1 to 65535");
    case OPTION_SHIFT_ALPHA:
        seen->needs_shift = "--shift-alpha";
        return read_share(value, &out->shift.alpha) || complain("shift-alpha", value, "a number from 0 to 1");
    case OPTION_SHIFT_CLAMP:
        seen->needs_shift = "--shift-clamp";
        return read_clamp(value, &out->shift.clamp) || complain("shift-clamp", value, "a number > 0");
    case OPTION_SHIFT_KERNEL:
        seen->needs_shift = "--shift-kernel";
        return read_kernel(value, &out->shift.kernel) ||
               complain("shift-kernel", value, "tile, disk or ball");
    default:
        return take_chain_option(option, value, &out->chains, seen);
    }
}

static int take_option(int option, const char *value, options *out, usage *seen)
{
    uint32_t threads;
    switch (option) {
    case 'o':
        out->output = value;
        return 1;
    case OPTION_SPP:
        return read_whole(value, 1, UINT32_MAX, &out->spp) || complain("spp", value, "a whole number from 1 to 4294967295");
    case OPTION_TIME:
        return read_positive(value, "", &out->seconds) || complain("time", value, "a number of seconds > 0");
    case OPTION_THREADS:
        if (!read_whole32(value, 1, 4096, &threads)) {
            return complain("threads", value, "a whole number from 1 to 4096");
        }
        out->threads = threads;
        return 1;
    case OPTION_SEED:
        return read_whole(value, 0, UINT64_MAX, &out->seed) || complain("seed", value, "a whole number from 0 to 2^64 - 1");
    case OPTION_MAX_DEPTH:
        return read_max_depth(value, out) || complain("max-depth", value, "a whole number from 1 on, or -1 for no limit");
    case OPTION_FIRST_VERTEX:
        seen->needs_path = "--first-vertex";
        return read_first_vertex(value, &out->first_vertex) ||
               complain("first-vertex", value, "medium, surface, specular or none");
    case OPTION_INTEGRATOR:
        seen->integrator = 1;
        return read_integrator(value, &out->integrator) ||
               complain("integrator", value, "path, bdpt, mmlt or auto");
    case OPTION_HEURISTIC:
        seen->needs_bdpt = "--heuristic";
        return read_heuristic(value, &out->heuristic) ||
               complain("heuristic", value, "balance or power");
    case OPTION_GUIDE:
        seen->needs_lights = "--guide";
        out->has_guide = 1;
        return read_whole(value, 0, UINT32_MAX, &out->guide) ||
               complain("guide", value, "a whole number from 0 to 4294967295");
    case OPTION_LIGHT_VERTICES:
        seen->needs_bdpt = "--light-vertices";
        return read_whole32(value, 1, VOLGRAD_MAX_LENGTH, &out->light_vertices) ||
               complain("light-vertices", value, "a whole number from 1 to 64");
    case OPTION_ROULETTE:
        seen->needs_bdpt = "--roulette";
        return read_factor(value, &out->roulette) || complain("roulette", value, "a number >= 0");
    case OPTION_DEBUG_TECHNIQUES:
        seen->needs_bdpt = "--debug-techniques";
        out->techniques = value;
        return *value != '\0' || complain("debug-techniques", value, "a folder");
    case OPTION_DEBUG_CHAIN:
        seen->needs_mmlt = "--debug-chain";
        out->has_debug_chain = 1;
        return read_mutation(value, &out->debug_chain.chain, &out->debug_chain.number) ||
               complain("debug-chain", value, "CHAIN:MUTATION, both whole numbers from 0 on");
    case OPTION_CROP:
        out->has_crop = 1;
        return read_crop(value, out->crop) || complain("crop", value, "X0,Y0,X1,Y1 in pixels with X0 < X1 and Y0 < Y1");
    case OPTION_QUIET:
        out->quiet = 1;
        return 1;
    case OPTION_STATS:
        out->stats = 1;
        return 1;
    default:
        return take_shift_option(option, value, out, seen);
    }
}

/* ---- the line ---- */

static unsigned processors(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count > 0 ? (unsigned)count : 1;
}

static int set_defaults(options *out)
{
    memset(out, 0, sizeof *out);
    out->threads = processors();
    out->roulette = -1.0;
    out->integrator = INTEGRATOR_AUTO;
    volgrad_status status = volgrad_shift_options_default(&out->shift, sizeof out->shift);
    if (status == VOLGRAD_OK) {
        status = volgrad_chain_options_default(&out->chains.options, sizeof out->chains.options);
    }
    if (status != VOLGRAD_OK) {
        fprintf(stderr, "volgrad-render: default options: %s\n", volgrad_status_message(status));
    }
    out->shift.mode = VOLGRAD_SHIFT_NONE;
    return status == VOLGRAD_OK;
}

static int ends_in(const char *text, const char *ending)
{
    size_t length = strlen(text), tail = strlen(ending);
    return length > tail && strcmp(text + length - tail, ending) == 0;
}

static options_result refuse(const char *subject, const char *problem)
{
    fprintf(stderr, "volgrad-render: %s%s\nTry volgrad-render --help.\n", subject, problem);
    return OPTIONS_ERROR;
}

int options_is_thesis(uint32_t mode)
{
    return mode == VOLGRAD_SHIFT_THESIS || mode == VOLGRAD_SHIFT_THESIS_PRINTED;
}

static options_result check_thesis(const options *out)
{
    if (out->integrator != INTEGRATOR_MMLT) {
        return refuse("", "--shift thesis goes with --integrator mmlt alone: only there a path has a technique");
    }
    if (out->shift.kernel != VOLGRAD_KERNEL_BALL || out->shift.radius_unit != VOLGRAD_RADIUS_WORLD) {
        return refuse("", "--shift thesis needs --shift-kernel ball and a --shift-radius in world units, as in 0.1");
    }
    return OPTIONS_RUN;
}

/* What only the whole line can tell. */
static options_result check_line(const options *out, const usage *seen, int scenes)
{
    if (scenes != 1) {
        return refuse("", scenes == 0 ? "no scene given" : "more than one scene given");
    }
    if (out->output == NULL) {
        return refuse("", "no output given: -o IMAGE.exr");
    }
    if (!ends_in(out->output, ".exr")) {
        return refuse(out->output, ": the output's name must end in .exr");
    }
    if (seen->needs_shift != NULL && out->shift.mode == VOLGRAD_SHIFT_NONE) {
        return refuse(seen->needs_shift, " means nothing without a --shift MODE");
    }
    if (seen->needs_bdpt != NULL && out->integrator != INTEGRATOR_BDPT) {
        return refuse(seen->needs_bdpt, " means nothing without --integrator bdpt");
    }
    if (seen->needs_lights != NULL && (out->integrator == INTEGRATOR_PATH || out->integrator == INTEGRATOR_AUTO)) {
        return refuse(seen->needs_lights, " means nothing without --integrator bdpt or mmlt");
    }
    if (seen->needs_mmlt != NULL && out->integrator != INTEGRATOR_MMLT) {
        return refuse(seen->needs_mmlt, " means nothing without --integrator mmlt");
    }
    if (seen->needs_path != NULL && out->integrator != INTEGRATOR_PATH) {
        return refuse(seen->needs_path, " means nothing without --integrator path");
    }
    if (out->integrator == INTEGRATOR_AUTO && out->shift.mode != VOLGRAD_SHIFT_NONE) {
        return refuse("", "--integrator auto chooses shifts itself: no --shift");
    }
    if (seen->not_for_bdpt != NULL && out->integrator == INTEGRATOR_BDPT) {
        return refuse(seen->not_for_bdpt, " means nothing with --integrator bdpt, which moves one vertex");
    }
    if (out->shift.mode != VOLGRAD_SHIFT_NONE && out->light_vertices > VOLGRAD_MAX_SHIFTED_LIGHT_VERTICES) {
        return refuse("", "--light-vertices: at most 3 with --shift");
    }
    if (out->shift.clamp > 0.0f && out->shift.mode != VOLGRAD_SHIFT_FIRST_ORDER && out->shift.mode != VOLGRAD_SHIFT_HALF_ORDER &&
        !options_is_thesis(out->shift.mode)) {
        return refuse("--shift-clamp", " goes with --shift first_order, half_order and thesis alone");
    }
    if (options_is_thesis(out->shift.mode)) {
        return check_thesis(out);
    }
    return OPTIONS_RUN;
}

options_result options_parse(int argc, char **argv, options *out)
{
    usage seen = {.needs_shift = NULL};
    int option;
    if (!set_defaults(out)) {
        return OPTIONS_ERROR;
    }
    while ((option = getopt_long(argc, argv, "o:", LONG_OPTIONS, NULL)) != -1) {
        if (option == OPTION_HELP) {
            return OPTIONS_HELP;
        }
        if (option == OPTION_VERSION) {
            return OPTIONS_VERSION;
        }
        if (option == '?' || !take_option(option, optarg, out, &seen)) {
            return OPTIONS_ERROR; /* getopt or take_option has said why */
        }
    }
    out->scene = optind < argc ? argv[optind] : NULL;
    if (!seen.integrator && (seen.shift || seen.needs_path != NULL)) {
        out->integrator = INTEGRATOR_PATH;
    }
    return check_line(out, &seen, argc - optind);
}
