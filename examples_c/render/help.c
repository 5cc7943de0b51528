/* The text of --help. */
#include <stdio.h>

#include "options.h"

static const char HELP[] =
    "Usage: volgrad-render SCENE.xml -o IMAGE.exr [options]\n"
    "Renders a scene in Mitsuba 3's XML. Writes IMAGE.exr (linear RGB) and a preview IMAGE.png.\n"
    "\n"
    "  -o, --output FILE      the image; its name ends in .exr\n"
    "      --integrator I     path, bdpt: bidirectional paths, mmlt: Metropolis light transport; auto (default; with --shift or\n"
    "                         --first-vertex path): path or bdpt, with or without shifts, whichever small trials of each find best for the\n"
    "                         scene; path in less than 32 samples per pixel\n"
    "      --spp N            paths per pixel (default: the scene's sample_count)\n"
    "      --time SECONDS     stop after the whole pass, or round of mutations, that passes this time; with --spp, whichever is first\n"
    "      --threads N        (default: all processors)\n"
    "      --seed N           random seed; same seed, same image (default 0)\n"
    "      --max-depth N      longest path in edges, -1 for no limit (default: the scene's)\n"
    "      --first-vertex V   a layer of the image: only paths whose first vertex is in a medium, on a scattering surface, or\n"
    "                         specular, or (none) light that the camera sees directly: medium, surface, specular or none.\n"
    "                         With the same seed they are the same paths, so layers add up to the image\n"
    "      --crop X0,Y0,X1,Y1 render only the pixels X0 <= x < X1, Y0 <= y < Y1\n"
    "\n"
    "  Sharing paths between pixels by gradients:\n"
    "      --shift MODE       none (default), exact, two_level, exchangeable; biased: first_order, half_order, log_linear,\n"
    "                         linear_depth; and for mmlt alone, with a ball: thesis, thesis_printed\n"
    "      --shift-count N    offsets tried per path\n"
    "      --shift-radius R   of the kernel: in pixels as in 4px, in world units as in 0.1\n"
    "      --shift-kernel K   tile (of count + 1 pixels, a square number; no radius), disk or ball\n"
    "      --shift-run N      most vertices that move together\n"
    "      --shift-exact N    two_level: offsets that are evaluated exactly\n"
    "      --shift-alpha A    the radius shrinks as samples^((A - 1)/3)\n"
    "      --shift-clamp W    first_order, half_order, thesis: greatest absolute weight; adds a bias of its own (default: none)\n"
    "\n";

/* A compiler need not take longer texts in one piece. */
static const char MORE_HELP[] =
    "  --integrator bdpt:\n"
    "      --heuristic H      weights of techniques: balance (default) or power\n"
    "      --light-vertices N most vertices of a path from a light (default 64; with --shift 3, and at most 3)\n"
    "      --roulette R       connections and batches worth less than R times the image's brightness, as far as guides know it, are\n"
    "                         made by chance (default 0.5; with --shift 6)\n"
    "      --debug-techniques DIR  afterwards also render DIR/sS_tT.exr and sS_tT_weighted.exr for each technique, S vertices from a\n"
    "                         light and T from the camera: what it makes without and with its weight, with as many samples.\n"
    "                         For paths of up to 8 edges (84 images), or --max-depth if given\n"
    "\n"
    "  --integrator bdpt or mmlt:\n"
    "      --guide N          passes from which lights learn where to send light, which are not in the image; 0: none\n"
    "                         (default: 50000 paths or more; with --time, a tenth of it at most)\n"
    "\n"
    "  --integrator mmlt; --spp, if given, is that of the paths that chains leave out:\n"
    "      --mutations N      per pixel (default: the scene's sample_count, if there is no --time)\n"
    "      --chains N         (default: so many that burn-in takes few of the mutations)\n"
    "      --chain-lengths A-B  edges of the chains' paths; the others are traced (default 2-32)\n"
    "      --bootstrap N      samples to find brightness and starts from (default: until brightness is known to 0.3 %, but\n"
    "                         with --time not longer than a tenth of it, without at most one for two mutations)\n"
    "      --burn-in N        mutations of each chain before the first that counts (default 512)\n"
    "      --large-step P     probability of a new, independent path (default 0.3)\n"
    "      --shift-every N    mutations per batch of shifted paths (default 4)\n"
    "      --debug-chain C:M  no image: prints mutation M of chain C, both from 0 on, with both its paths factor by factor, and\n"
    "                         records it in FILE.record beside the image's name, for volgrad-replay; what has .nvdb volumes cannot be recorded\n"
    "\n"
    "      --quiet            no progress\n"
    "      --stats            print what was computed, to standard output\n"
    "      --version\n"
    "      --help\n"
    "\n"
    "Ctrl-C ends the current pass or round and writes the image; once more quits at once.\n"
    "Exit status: 0 done, 1 failure, 2 wrong usage or scene, 130 interrupted (the image is written).\n";

void options_print_help(void)
{
    fputs(HELP, stdout);
    fputs(MORE_HELP, stdout);
}
