"""What `make figures` renders: programs (integrator and options), and jobs (scene, program, samples per pixel, seed).

A plan depends on minutes, resolution, the renderer's modes and the Mitsuba variants that run here, never on a clock: the same plan renders
the same bits. Sample counts come from the costs below, which were measured once; on another machine the plan takes more or less time, but
is the same.

Radii of the thesis' kernel, a ball in the world, are in pixels' footprints at the middle of the scene, and are those after one sample per
pixel; where they shrink as i^((alpha - 1)/3), i counts the samples of the whole image, and the first of all has a larger one.
"""
import re
from dataclasses import dataclass, field, replace

SCENES = ["smoke", "room", "cloud", "caustic"]
FOOTPRINT = {"smoke": 0.0386, "room": 0.028, "cloud": 0.0296, "caustic": 0.0204}  # world units per pixel, of 128, at the scene's middle
PEERS = ["volpath", "volpathmis"]
VARIANTS = ["scalar_rgb", "llvm_ad_rgb"]

# Each biased mode with the alpha that theory wants, 1 + 3·exponent: bias O(r^2) shrinks best with i^(-1/4), O(r^4) with i^(-1/8).
ALPHA = {"thesis": 0.25, "thesis_printed": 0.25, "first_order": 0.25, "half_order": 0.625, "log_linear": 0.25}
RADIUS = 1  # pixels
RADII = [0.25, 0.5, 1, 2, 4]
LARGE_RADIUS = 2  # whose bias shows
FIRST_RADIUS = 8  # of the first sample of all, as in [Lu20 5.3], to compare the thesis' schedules
CLAMP = 4  # of weights where radii or schedules are compared: without, outliers hide the bias
ALPHAS = [0, 0.25, 0.5, 0.625, 0.75, 1]
SURFACE_RADIUS = 2
LAYERS = ["medium", "surface", "specular", "none"]  # by first vertices
GRADIENT = ["first_order", "half_order", "log_linear"]
LINEAR = ["thesis", "thesis_printed", "first_order", "half_order"]  # in the gradient: weights without bound
MODES = ["thesis", "thesis_printed", *GRADIENT, "linear_depth", "exact", "two_level", "exchangeable"]
UNBIASED = ["none", "exact", "two_level", "exchangeable"]
CHAINS_ONLY = ["thesis", "thesis_printed"]
RESTARTS = ["thesis_printed"]  # radii as in [Lu20 alg. 2], which shrink within a batch and begin anew with each

# CPU-seconds per sample per pixel of 128 x 128 (mmlt: per mutation), and of starting up (guides, bootstrap), without shifts.
COST = {
    "path": {"smoke": 0.04, "room": 0.18, "cloud": 0.10, "caustic": 0.08},
    "bdpt": {"smoke": 0.07, "room": 0.55, "cloud": 0.50, "caustic": 0.20},
    "mmlt": {"smoke": 0.07, "room": 0.32, "cloud": 0.23, "caustic": 0.13},
    "scalar_rgb": {"smoke": 0.10, "room": 0.27, "cloud": 0.25, "caustic": 0.11},
    "default": {"smoke": 0.07, "room": 0.60, "cloud": 0.20, "caustic": 0.30},
    "llvm_ad_rgb": {"smoke": 0.13, "room": 0.24, "cloud": 0.24, "caustic": 0.07},
}
START = {"smoke": 0.2, "room": 1.3, "cloud": 0.5, "caustic": 1.0}
SHIFTED = 2.5  # times the cost of a sample without shifts

# Of the CPU time. What is left is for the pictures, the repeated renders and Mitsuba's compiler.
SHARES = {"convergence": 0.44, "peers": 0.14, "settings": 0.21, "radius": 0.04, "alpha": 0.06, "surfaces": 0.03}
WEIGHT = {"smoke": 0.8, "room": 1.4, "cloud": 0.8, "caustic": 1.0}  # of a scene, relative to the mean
PROCESSORS = 2
SEEDS, FEW_SEEDS, LONG = 5, 3, 15  # few for a look, in less than LONG minutes
USUAL = 64  # samples per pixel of who sets nothing else: the renderer then tries several ways, which takes some
RUNGS, STEP = 3, 3  # of the ladder of sample counts: N/9, N/3, N
FIRST_SEED = 1000  # others than those of peers.py, chains.py and of trials; Mitsuba's references were made with 0, 1, 2 ...


@dataclass(frozen=True)
class Program:
    integrator: str
    mode: str = "none"
    setting: str = ""  # what tells it from others of the same integrator and mode
    options: str = ""  # volgrad-render's
    variant: str = ""  # Mitsuba's

    @property
    def name(self):
        mode = "" if self.mode == "none" else self.mode
        return " ".join(p for p in (self.integrator, self.variant.split("_")[0], mode, self.setting) if p)

    def cost(self, scene, count, pixels):
        """CPU-seconds, roughly."""
        start = START[scene] if self.integrator in ("mmlt", "bdpt", "default") else 0
        each = COST[self.variant or self.integrator][scene] * (1 if self.mode in ("none", "layer") else SHIFTED)
        return start + count * each * pixels / 128**2


@dataclass(frozen=True)
class Job:
    experiment: str
    scene: str
    program: Program
    count: int
    seed: int

    @property
    def options(self):
        """Of volgrad-render's command line."""
        integrator = self.program.integrator
        named = "" if integrator == "default" else f"--integrator {integrator} "
        return f"{named}{'--mutations' if integrator == 'mmlt' else '--spp'} {self.count} {self.program.options}".strip()

    @property
    def command(self):
        """What tells jobs apart, but for scene files in another resolution."""
        p = self.program
        if p.variant:
            return f"mitsuba -m {p.variant} scenes/{self.scene}.xml spp={self.count} seed={self.seed} integrator={p.integrator}"
        return f"volgrad-render scenes/{self.scene}.xml --threads 1 --seed {self.seed} {self.options}"


def plain(integrator):
    return Program(integrator, options="--shift none")


def ball(mode, scene, resolution, radius=RADIUS, alpha=None, clamp=None):
    """Of a mode with the thesis' kernel."""
    alpha = ALPHA[mode] if alpha is None else alpha
    samples = 1 if mode in RESTARTS else resolution**2
    first = radius * FOOTPRINT[scene] * 128 / resolution * samples ** ((1 - alpha) / 3)
    return with_clamp(f"--shift {mode} --shift-kernel ball --shift-radius {first:.4g} --shift-alpha {alpha}", mode, clamp)


def with_clamp(options, mode, clamp):
    return f"{options} --shift-clamp {clamp}" if clamp and mode in LINEAR else options


def scheduled(mode, scene, resolution, alpha):
    radius = FIRST_RADIUS * FOOTPRINT[scene] * 128 / resolution
    return with_clamp(f"--shift {mode} --shift-kernel ball --shift-radius {radius:.4g} --shift-alpha {alpha}", mode, CLAMP)


def shifted(integrator, mode, scene, resolution):
    """A mode as a user would set it: the thesis' kernel and the best alpha where it is biased, else the defaults."""
    return Program(integrator, mode, "", ball(mode, scene, resolution) if mode in ALPHA else f"--shift {mode}")


@dataclass
class Plan:
    minutes: float
    resolution: int
    help: str  # of the renderer: tells the modes
    variants: list  # of Mitsuba, that run here
    jobs: list = field(default_factory=list)

    @property
    def seeds(self):
        return range(FIRST_SEED, FIRST_SEED + (SEEDS if self.minutes >= LONG else FEW_SEEDS))

    @property
    def modes(self):
        return [m for m in MODES if re.search(rf"\b{m}\b", self.help)]

    def seconds(self, experiment, scene=None):
        whole = 60 * PROCESSORS * self.minutes * SHARES[experiment]
        return whole if scene is None else whole * WEIGHT[scene] / sum(WEIGHT.values())

    def add(self, experiment, scene, program, counts):
        self.jobs += [Job(experiment, scene, program, c, s) for c in counts for s in self.seeds]

    def ladder(self, programs, scene, seconds, rungs=RUNGS):
        """The counts, the same for all programs, whose renders take so long together."""
        def cost(counts):
            return sum(p.cost(scene, c, self.resolution**2) for p in programs for c in counts) * len(self.seeds)

        top = 1
        while cost(steps(top + 1, rungs)) <= seconds:
            top += 1
        return steps(top, rungs)

    def alike(self, experiment, scene, programs, seconds):
        """To each program the count that takes it as long as the others."""
        for p in programs:
            self.add(experiment, scene, p, self.ladder([p], scene, seconds / len(programs), 1))


def steps(top, rungs):
    return sorted({max(1, round(top / STEP**k)) for k in range(rungs)})


# ---- experiments ----


def convergence(plan):
    """Figures 21 to 23: every mode of both samplers that have shifts, and the others, at equal counts."""
    for scene in SCENES:
        unshifted = [plain(i) for i in ("path", "bdpt", "mmlt")]
        pairs = [(i, m) for i in ("path", "mmlt") for m in plan.modes if i == "mmlt" or m not in CHAINS_ONLY]
        pairs.append(("bdpt", "exchangeable"))
        programs = unshifted + [shifted(*pair, scene, plan.resolution) for pair in pairs]
        counts = plan.ladder(programs, scene, plan.seconds("convergence", scene))
        for p in programs:
            plan.add("convergence", scene, p, counts)


def peers(plan):
    """What people would use instead. A first render of each count, which compiles, is left out."""
    for scene in SCENES:
        programs = [Program(integrator, variant=variant) for integrator in PEERS for variant in plan.variants]
        for p in programs:
            seconds = plan.seconds("peers", scene) / len(PEERS) / len(VARIANTS) * len(plan.seeds) / (len(plan.seeds) + PROCESSORS)
            plan.add("peers", scene, p, plan.ladder([p], scene, seconds, 2))


def radius(plan):
    """Figure 24, on smoke: of the gradient's estimate, and of one without bias."""
    modes = [m for m in ("thesis", "first_order") if m in plan.modes]
    programs = [plain("mmlt")]
    for r in RADII:
        programs += [Program("mmlt", m, f"r {r}", ball(m, "smoke", plan.resolution, r, clamp=CLAMP)) for m in modes]
        exchangeable = f"--shift exchangeable --shift-kernel ball --shift-radius {r * FOOTPRINT['smoke'] * 128 / plan.resolution:.4g}"
        programs.append(Program("mmlt", "exchangeable", f"r {r}", exchangeable))
    counts = plan.ladder(programs, "smoke", plan.seconds("radius"), 1)
    for p in programs:
        plan.add("radius", "smoke", p, counts)


def alpha(plan):
    """Figure 25, left, on smoke: a large radius, whose bias shows, and paths, whose noise is small; the thesis' two schedules."""
    choices = [("path", m, ALPHAS) for m in GRADIENT]
    choices += [("mmlt", m, [ALPHA[m]] if m in RESTARTS else [ALPHA[m], 1]) for m in CHAINS_ONLY if m in plan.modes]
    programs = [plain(i) for i in dict.fromkeys(i for i, _, _ in choices)]
    for i, m, of_mode in choices:
        options = scheduled if m in CHAINS_ONLY else lambda *args: ball(*args[:3], LARGE_RADIUS, args[3], CLAMP)
        programs += [Program(i, m, f"alpha {a}", options(m, "smoke", plan.resolution, a)) for a in of_mode]
    counts = plan.ladder(programs, "smoke", plan.seconds("alpha"))
    for p in programs:
        plan.add("alpha", "smoke", p, counts)


def settings(plan):
    """Single vertex against rigid run, how many members, how often; the best of them against what a user gets who sets nothing."""
    tile = "--shift exchangeable --shift-count {} --shift-run {}"
    programs = [plain(i) for i in ("path", "bdpt", "mmlt")]
    programs += [Program(i, "exchangeable", "", "--shift exchangeable") for i in ("path", "mmlt")]
    for n, run in [(n, run) for n in (3, 8, 15, 35) for run in (1, 2)] + [(8, 8)]:
        programs.append(Program("path", "exchangeable", f"n {n} run {run}", tile.format(n, run)))
    for n in (8, 35):
        programs.append(Program("bdpt", "exchangeable", f"n {n}", f"--shift exchangeable --shift-count {n}"))
    for n, run, every in [(3, 2, 4), (8, 2, 1), (8, 2, 16), (15, 2, 4), (8, 1, 4), (8, 8, 4)]:
        options = f"{tile.format(n, run)} --shift-every {every}"
        programs.append(Program("mmlt", "exchangeable", f"n {n} run {run} T {every}", options))
    for scene in SCENES:
        default = Program("default")
        usual = [USUAL if plan.minutes >= LONG else 1]
        tried = default.cost(scene, usual[0], plan.resolution**2) * len(plan.seeds)
        plan.add("settings", scene, default, usual)
        plan.alike("settings", scene, programs, max(plan.seconds("settings", scene) - tried, 0))


def surfaces(plan):
    """A disk in pixels moves first vertices on surfaces, too; the same disk in world units does not. What such paths carry of light and
    noise: layers of the image without shifts."""
    for scene in SCENES:
        world = SURFACE_RADIUS * FOOTPRINT[scene] * 128 / plan.resolution
        programs = [plain("path")]
        programs += [Program("path", "layer", kind, f"--first-vertex {kind}") for kind in LAYERS]
        programs += [Program("path", "exchangeable", where, f"--shift exchangeable --shift-kernel disk --shift-radius {r}")
                     for where, r in (("everywhere", f"{SURFACE_RADIUS}px"), ("in media only", f"{world:.4g}"))]
        counts = plan.ladder(programs, scene, plan.seconds("surfaces", scene), 1)
        for p in programs:
            plan.add("surfaces", scene, p, counts)


def repeated(plan):
    """One render of each of some programs once more, on two threads: the bits must be the same. What is set by trials, too."""
    again = [("convergence", scene, name) for scene in SCENES for name in ("path exchangeable", "mmlt exchangeable")]
    for which in [*again, ("settings", "room", "default")]:
        job = next(j for j in plan.jobs if (j.experiment, j.scene, j.program.name) == which)
        program = replace(job.program, options=f"{job.program.options} --threads 2".strip())
        plan.jobs.append(Job("repeated", job.scene, program, job.count, job.seed))


def make_plan(minutes, resolution, help, variants):
    plan = Plan(minutes, resolution, help, variants)
    for experiment in (convergence, peers, radius, alpha, settings, surfaces, repeated):
        experiment(plan)
    return plan
