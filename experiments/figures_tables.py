"""The tables of `make figures`, from the CSV files alone: each a header, rows, and to each row the commands that it was made by."""
import numpy as np
from figures_data import TARGETS, part, products, ratio, time_to
from figures_plan import ALPHA, LAYERS, MODES, SCENES, UNBIASED
from measures import TILES, still_text, student
from tables import shown

OURS = ["path", "path exchangeable", "bdpt", "bdpt exchangeable", "mmlt", "mmlt exchangeable", "mmlt thesis"]
ROUNDING = 1e-6  # of images, relative: what is less is the same energy
QUALITY = ["noise", "bias", "energy", "z", "z paired", "blocks > 2"]
GOAL = 4  # times less squared error with shifts than without, in equal time
NEAR = 1.2  # what sets nothing may cost, over the best measured setting
SUSPICIOUS = 3  # |z|
UNTOLD = "not told apart"
WIDE = 8  # times more samples, from which on a slope says something


def text(interval, missing="–"):
    return shown(*interval) if np.isfinite(interval).all() else missing


def time_text(interval, extrapolated):
    return ("~ " if extrapolated and np.isfinite(interval).all() else "") + text(interval)


def pair(data, **wanted):
    return [data.column(c, **wanted) for c in ("relative_mse", "cpu_seconds")]


# ---- the thesis' claims ----


def modes(data, integrator):
    """Each mode against the same paths, or mutations, without shifts."""
    header = ["scene", "mode", "per pixel", "gain, equal samples", "cost", "gain, equal time", "the same, blurred", "FLIP : without"]
    header += ["slope", *QUALITY]
    rows = []
    for scene in SCENES:
        wanted = {"experiment": "convergence", "scene": scene, "integrator": integrator}
        top = data.counts(**wanted)[-1]
        plain = {"count": top, "mode": "none", **wanted}
        for m in [m for m in ["none", *MODES] if data.find(**wanted, mode=m)]:
            this = {"count": top, "mode": m, **wanted}
            slope = fitted_slope(data, **wanted, mode=m)
            cells = [scene, f"`{m}`", f"{top}", *gains(data, plain, this), slope, *quality(data.cell(**this))]
            rows.append((cells, data.command(**this)))
    return header, rows


def gains(data, plain, this):
    if plain == this:
        return ["1"] * 5
    measures = ("relative_mse", "cpu_seconds", "blurred_mse", "flip")
    squared, seconds, blurred, flips = ([data.column(c, **w) for w in (plain, this)] for c in measures)
    equal_time = products(pair(data, **plain), pair(data, **this))
    after_blur = products([blurred[0], seconds[0]], [blurred[1], seconds[1]])
    return [text(ratio(*squared)), text(ratio(*seconds[::-1])), text(equal_time), text(after_blur), text(ratio(*flips[::-1]))]


def fitted_slope(data, **wanted):
    """Exponent of the samples that RMSE goes by: -0.5 without bias."""
    counts = data.counts(**wanted)
    squared = [data.column("relative_mse", **wanted, count=c).mean() for c in counts]
    if counts[-1] < WIDE * counts[0] or not np.min(squared) > 0:
        return "–"
    return f"{np.polynomial.Polynomial.fit(np.log(counts), np.log(squared) / 2, 1).convert().coef[1]:.2f}"


def quality(cell):
    """Noise and bias of one image, relative; z of its mean."""
    (bias2, reach), (variance, _) = part(cell, "bias2"), part(cell, "variance")
    bias = f"{np.sqrt(bias2):.1%}" if bias2 > reach else f"< {np.sqrt(max(reach, bias2 + reach)):.1%}"
    energy = f"{float(cell['energy']):+.2%}" if cell["energy"] else "–"
    paired = cell["z_paired"] if cell["energy"] and abs(float(cell["energy"])) > ROUNDING else ""
    z = [marked(of or "–") for of in (cell["z_reference"], paired)]
    return [f"{np.sqrt(variance):.1%}", bias, energy, *z, f"{float(cell['blocks_beyond_2']):.1%}"]


def marked(z):
    return z if z == "–" or abs(float(z)) < SUSPICIOUS else f"**{z}**"


def claims(data):
    """Whether gradient batches beat plain MMLT at equal samples: the thesis' estimator, and ours."""
    header = ["scene", "mode", "mutations per pixel", "gain at equal mutations", "verdict"]
    rows = []
    for scene in SCENES:
        wanted = {"experiment": "convergence", "scene": scene, "integrator": "mmlt"}
        top = data.counts(**wanted)[-1]
        for m in [m for m in ("thesis", "thesis_printed", "first_order", "exchangeable") if data.find(**wanted, mode=m)]:
            found = ratio(*(data.column("relative_mse", **wanted, count=top, mode=x) for x in ("none", m)))
            rows.append(([scene, f"`{m}`", f"{top}", text(found), verdict(found)], data.command(**wanted, count=top, mode=m)))
    return header, rows


def verdict(gain):
    if not np.isfinite(gain).all() or gain[1] < 1 < gain[2]:
        return UNTOLD
    return "better" if gain[0] > 1 else "worse"


def schedules(data):
    """Error and bias over the counts, of radii that shrink with the samples of the image, that do not, and that begin anew in each batch."""
    counts = data.counts(experiment="alpha")
    rows = []
    last = data.find(data.cells, experiment="alpha", count=counts[-1])
    for cell in [r for r in last if r["setting"] in (f"alpha {ALPHA.get(r['mode'])}", "alpha 1")]:
        wanted = {"experiment": "alpha", "program": cell["program"]}
        errors = [f"{np.sqrt(max(0, data.column('relative_mse', **wanted, count=c).mean())):.1%}" for c in counts]
        biases = [quality(data.cell(**wanted, count=c)) for c in counts]
        rows.append(([f"`{cell['mode']}`", cell["setting"], *errors, *(b[1] for b in biases), *(b[2] for b in biases)], data.command(**wanted)))
    return ["mode", "schedule", *(f"{what}, {c}" for what in ("RMSE", "bias", "energy") for c in counts)], rows


def best_alpha(data):
    """The alpha of the least error, and of the least at each of the counts, beside theory's."""
    wanted = {"experiment": "alpha", "integrator": "path"}
    counts = data.counts(**wanted)
    rows = []
    for m in [m for m in data.values("mode", **wanted) if m != "none"]:
        settings = data.values("setting", **wanted, mode=m)
        best = [min(settings, key=lambda s: positive(data.column("relative_mse", **wanted, mode=m, setting=s, count=c).mean())) for c in counts]
        rows.append(([f"`{m}`", f"{ALPHA[m]}", *(b.split()[1] for b in best)], data.command(**wanted, mode=m, count=counts[-1])))
    return ["mode", "theory", *(f"best at {c} per pixel" for c in counts)], rows


def with_outside(data):
    """Scenes in which some camera rays meet no medium."""
    return [s for s in SCENES if np.isfinite(data.column("outside_mse", experiment="convergence", scene=s)).any()]


# ---- beyond ----


def surfaces(data):
    header = ["scene", "first vertices on surfaces", "shifts per path", "gain, equal samples", "gain, equal time"]
    rows = []
    for scene in SCENES:
        wanted = {"experiment": "surfaces", "scene": scene}
        plain = {**wanted, "mode": "none"}
        for setting, name in (("in media only", "stay"), ("everywhere", "move")):
            this = {**wanted, "setting": setting}
            shifts = data.column("shifts_per_path", **this).mean()
            squared = [data.column("relative_mse", **w) for w in (plain, this)]
            cells = [scene, name, f"{shifts:.1f}", text(ratio(*squared)), text(products(pair(data, **plain), pair(data, **this)))]
            rows.append((cells, data.command(**this)))
    return header, rows


def layers(data):
    """Shares of the image's light and of the path sampler's variance, of paths by their first vertex."""
    header = ["scene", *(f"{what}, {kind}" for kind in LAYERS for what in ("light", "noise"))]
    rows = []
    for scene in SCENES:
        wanted = {"experiment": "surfaces", "scene": scene, "mode": "layer"}
        cells = [scene]
        for layer in [data.cell(**wanted, setting=kind) for kind in LAYERS if data.find(**wanted)]:
            reach = student(int(layer["seeds"])) * float(layer["share_error"])
            cells += [f"{1 + float(layer['energy']):.1%}", f"{float(layer['share']):.1%} ± {reach:.1%}"]
        rows.append((cells, data.command(**wanted, setting="surface")))
    return header, rows


def repeated(data):
    """Whether the bits are the same again, on two threads."""
    rows = []
    for r in data.find(experiment="repeated"):
        first = data.find(**{c: r[c] for c in ("scene", "program", "count", "seed")})[0]
        same = "the same" if r["bits"] == first["bits"] else "**different**"
        rows.append(([r["scene"], r["program"], first["bits"], r["bits"], same], r["command"]))
    return ["scene", "program", "one thread", "two threads", ""], rows


# ---- peers, and defaults ----


def our_contenders(data):
    return [p for p in OURS if data.find(experiment="convergence", program=p)]


def contenders(data, scene):
    """Experiment and program of all that is compared by time."""
    return [("convergence", p) for p in our_contenders(data)] + [("peers", p) for p in data.values("program", experiment="peers", scene=scene)]


def peers(data):
    header = ["program", *(f"{scene}, to {t:.0%}" for scene in SCENES for t in TARGETS)]
    times = {}
    for scene in SCENES:
        for experiment, program in contenders(data, scene):
            for t in TARGETS:
                times[program, scene, t] = time_to(data, t, experiment=experiment, scene=scene, program=program)
    programs = list(dict.fromkeys(p for p, _, _ in times))
    rows = []
    for p in programs:
        cells = [p]
        for scene in SCENES:
            found = [v[0][0] for (_, s, t), v in times.items() if s == scene and t == TARGETS[0]]
            for t in TARGETS:
                cell = time_text(*times[p, scene, t])
                least = t == TARGETS[0] and times[p, scene, t][0][0] == np.nanmin(found)
                cells.append(f"**{cell}**" if least else cell)
        experiment = "peers" if p.startswith("vol") else "convergence"
        all_scenes = [{"experiment": experiment, "scene": s, "program": p} for s in SCENES]
        rows.append((cells, "; ".join(data.command(**w, count=data.counts(**w)[-1]) for w in all_scenes)))
    return header, rows


def cost(data, **wanted):
    """Squared error times CPU time."""
    squared, seconds = pair(data, **wanted)
    return positive(squared.mean()) * seconds.mean()


def positive(squared):
    """What the reference's noise hides is no best."""
    return squared if squared > 0 else np.inf


def best_setting(data, scene):
    """Of the unbiased ones: the one with the least error times CPU time."""
    wanted = {"experiment": "settings", "scene": scene}
    programs = [p for p in data.values("program", **wanted) if p != "default" and data.find(**wanted, program=p)[0]["mode"] in UNBIASED]
    return min(programs, key=lambda p: cost(data, **wanted, program=p))


def defaults(data):
    header = ["scene", "best measured", "nothing set : best", f"within {NEAR - 1:.0%}", "nothing set, time to 10 %", "path : path + shifts",
              "mmlt : mmlt + shifts", f"goal {GOAL} x", "path : nothing set", "z of nothing set"]  # fmt: skip
    rows = []
    for scene in SCENES:
        wanted = {"experiment": "settings", "scene": scene}
        best, nothing = best_setting(data, scene), pair(data, **wanted, program="default")
        over = products(nothing, pair(data, **wanted, program=best))
        gains = [products(pair(data, **wanted, program=i), pair(data, **wanted, program=best_shift(data, scene, i))) for i in ("path", "mmlt")]
        reached = answer(any(g[1] >= GOAL for g in gains), all(g[2] < GOAL for g in gains))
        near = answer(over[2] <= NEAR, over[1] > NEAR)
        seconds = time_text(*time_to(data, TARGETS[0], **wanted, program="default"))
        cells = [scene, f"`{best}`", text(over), near, seconds, *map(text, gains), reached]
        cells += [text(products(pair(data, **wanted, program="path"), nothing)), marked(data.cell(**wanted, program="default")["z_reference"])]
        rows.append((cells, f"{data.command(**wanted, program='default')}; best: {data.command(**wanted, program=best)}"))
    return header, rows


def answer(yes, no):
    """By whole intervals; those that are not known say neither."""
    return "yes" if yes else "no" if no else UNTOLD


def best_shift(data, scene, integrator):
    wanted = {"experiment": "settings", "scene": scene, "integrator": integrator, "mode": "exchangeable"}
    return min(data.values("program", **wanted), key=lambda p: cost(data, **wanted, program=p))


def where(data):
    """Where time and variance go in each scene: with the best shifts of each sampler, per sample."""
    header = ["scene", "sampler", "best shifts", "cost of a sample", "error of a sample less by", "starting up", "error that no tile takes away"]
    rows = []
    for scene in SCENES:
        for integrator in ("path", "mmlt"):
            wanted = {"experiment": "settings", "scene": scene, "integrator": integrator}
            best = best_shift(data, scene, integrator)
            plain, this = ({**wanted, "program": p} for p in (integrator, best))
            counts = [data.counts(**w)[0] for w in (plain, this)]
            squared = [data.column("relative_mse", **w) * n for w, n in zip((plain, this), counts)]
            seconds = [data.column("cpu_seconds", **w) / n for w, n in zip((plain, this), counts)]
            cells = [scene, integrator, f"`{best}`", text(ratio(*seconds[::-1])), text(ratio(*squared)), starting_up(data, scene, integrator)]
            rows.append(([*cells, error_of_still(data, scene) if integrator == "path" else "–"], data.command(**this)))
    return header, rows


def starting_up(data, scene, integrator):
    """CPU-seconds, by the straight line through the convergence's counts."""
    wanted = {"experiment": "convergence", "scene": scene, "program": integrator}
    counts = data.counts(**wanted)
    if len(counts) < 2:
        return "–"
    seconds = [np.median(data.column("cpu_seconds", count=c, **wanted)) for c in counts]
    start = np.polynomial.Polynomial.fit(counts, seconds, 1, w=1 / np.array(seconds)).convert().coef[0]
    return f"{max(0, start):.1f} s"


def error_of_still(data, scene):
    """Its share, of squared errors per sample without tiles and over two sizes of them."""
    wanted = {"experiment": "settings", "scene": scene, "integrator": "path"}
    programs = ["path", *(f"path exchangeable n {m - 1} run 2" for m in TILES)]
    return still_text(*(data.column("relative_mse", **wanted, program=p) * data.counts(**wanted, program=p)[0] for p in programs))
