"""The plots of `make figures`, from the CSV files alone."""
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from figures_data import part, products, rmse  # noqa: E402
from figures_plan import ALPHA, MODES, SCENES  # noqa: E402
from matplotlib.ticker import LogLocator, NullFormatter  # noqa: E402

# Okabe and Ito's colours, which colour-blind people can tell apart; one per mode everywhere, one line style per integrator.
COLOUR = {
    "none": "#000000", "thesis": "#D55E00", "thesis_printed": "#7A3000", "first_order": "#E69F00", "half_order": "#B5A800",
    "log_linear": "#CC79A7", "linear_depth": "#8C8C8C", "exact": "#56B4E9", "two_level": "#009E73", "exchangeable": "#0072B2",
}  # fmt: skip
STYLE = {
    "path": ("-", "o"), "mmlt": ("--", "s"), "bdpt": (":", "^"), "default": ("-", "*"), "volpath": ("-.", "D"), "volpathmis": ("-.", "v"),
}  # fmt: skip
PEER_COLOUR = {"scalar_rgb": "#7F4F24", "llvm_ad_rgb": "#B08968"}
DPI = 110
WIDTH = 13  # inches


# ---- curves ----


def look(row):
    """Colour and line of a program."""
    line, marker = STYLE[row["integrator"]]
    variant = next((v for v in PEER_COLOUR if f" {v.split('_')[0]}" in row["program"]), None)
    colour = PEER_COLOUR[variant] if variant else COLOUR[row["mode"]]
    return {"color": colour, "linestyle": line, "marker": marker, "markersize": 4, "linewidth": 1.2}


def curve(axes, x, intervals, **style):
    """With bars of 95 %; what could not be measured is left out."""
    middle, low, high = np.array(intervals).T
    good = np.isfinite(middle)
    bars = [np.maximum(0, middle - low)[good], np.maximum(0, high - middle)[good]]
    axes.errorbar(np.asarray(x, float)[good], middle[good], bars, capsize=2, elinewidth=0.7, **style)


def error_curve(data, axes, against, measure="relative_mse", **wanted):
    counts = data.counts(**wanted)
    squared = [data.column(measure, count=c, **wanted) for c in counts]
    x = counts if against == "count" else [np.median(data.column(against, count=c, **wanted)) for c in counts]
    curve(axes, x, [rmse(s) for s in squared], label=wanted["program"], **look(data.find(**wanted)[0]))


def logarithmic(axes, both=True):
    """The range is that of the values: bars may leave it."""
    axes.set_yscale("log")
    curves = [bars[0] for bars in axes.containers] or axes.lines
    values = [v for c in curves for v in c.get_ydata()]
    if values:
        axes.set_ylim(min(values) / 1.6, max(values) * 1.6)
    if both:
        axes.set_xscale("log")
        label(axes.xaxis)
    label(axes.yaxis)
    axes.grid(alpha=0.25, linewidth=0.5)


def label(axis):
    """Of a logarithmic axis: 1, 2, 5, 10 ..."""
    axis.set_major_formatter("{x:g}")
    axis.set_minor_locator(LogLocator(subs=(2, 5)))
    axis.set_minor_formatter("{x:g}" if np.ptp(np.log10(axis.get_view_interval())) < 2 else NullFormatter())


def legend_below(figure, axes, columns=6):
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=columns, frameon=False)


def panels(rows, columns, height):
    return plt.subplots(rows, columns, figsize=(WIDTH, height), layout="constrained", squeeze=False)


def save(figure, file):
    figure.savefig(file, dpi=DPI, facecolor="white", metadata={"Software": None})
    plt.close(figure)


# ---- figures ----


def convergence(data, programs, experiments=("convergence",), rows=("count", "cpu_seconds")):
    """Relative RMSE against samples and CPU time."""
    figure, grid = panels(len(rows), len(SCENES), 3.4 * len(rows) + 0.6)
    for line, against in zip(grid, rows):
        for axes, scene in zip(line, SCENES):
            for experiment in experiments:
                for p in data.values("program", experiment=experiment, scene=scene):
                    if p in programs or (experiment == "peers" and against != "count"):
                        error_curve(data, axes, against, experiment=experiment, scene=scene, program=p)
            axes.set(title=scene, xlabel="samples or mutations per pixel" if against == "count" else "CPU-seconds")
            logarithmic(axes)
        line[0].set_ylabel("relative RMSE")
    legend_below(figure, grid[-1][0])
    return figure


def family(data, integrator):
    integrators = [integrator, "bdpt"] if integrator == "path" else [integrator]
    return [p for p in data.values("program", experiment="convergence") if p.split()[0] in integrators]


def flip(data, programs):
    """A perceptual error against CPU time: the noise of batches is correlated."""
    figure, grid = panels(2, len(SCENES), 7)
    for line, measure in zip(grid, ("blurred_mse", "flip")):
        for axes, scene in zip(line, SCENES):
            for p in programs:
                wanted = {"experiment": "convergence", "scene": scene, "program": p}
                if measure == "blurred_mse":
                    error_curve(data, axes, "cpu_seconds", measure, **wanted)
                    continue
                counts = data.counts(**wanted)
                x, y = (np.array([data.column(c, count=n, **wanted).mean() for n in counts]) for c in ("cpu_seconds", "flip"))
                axes.plot(x, y, label=p, **look(data.find(**wanted)[0]))
            axes.set(title=scene, xlabel="CPU-seconds")
            logarithmic(axes)
        line[0].set_ylabel("relative RMSE, blurred" if measure == "blurred_mse" else "FLIP")
    legend_below(figure, grid[0][0])
    return figure


def parts(cell):
    """Bias and noise of one image, with what they are known to: roots of the squares and of the ends of their intervals."""
    for name in ("bias2", "variance"):
        value, error = part(cell, name)
        ends = np.sqrt(np.maximum(0, [value, value - error, value + error]))
        yield ends if value > 0 else np.array([np.nan, 0, ends[2]])


def bias(data):
    """Bias apart from noise, at the highest count."""
    figure, grid = panels(2, len(SCENES), 7)
    for line, integrator in zip(grid, ("mmlt", "path")):
        for axes, scene in zip(line, SCENES):
            wanted = {"experiment": "convergence", "scene": scene, "integrator": integrator}
            top = data.counts(**wanted)[-1]
            modes = [m for m in ["none", *MODES] if data.find(**wanted, mode=m)]
            for y, m in enumerate(reversed(modes)):
                of_bias, of_noise = parts(data.cell(**wanted, count=top, mode=m))
                draw_parts(axes, y, of_bias, of_noise, COLOUR[m])
            axes.set(title=f"{scene}, {integrator}, {top} per pixel", yticks=range(len(modes)), xscale="log")
            axes.set_yticklabels(reversed(modes) if scene == SCENES[0] else [])
            label(axes.xaxis)
            axes.grid(alpha=0.25, axis="x")
    figure.supxlabel("relative to the reference, rms over the pixels:  ○ noise of one image   ● bias   ◂ bias below")
    return figure


def draw_parts(axes, y, of_bias, of_noise, colour):
    axes.plot(of_noise[0], y, "o", color=colour, markerfacecolor="white")
    if of_bias[1] > 0:
        axes.plot(of_bias[1:], [y, y], "-", color=colour, linewidth=1)
        axes.plot(of_bias[0], y, "o", color=colour)
    else:  # no more than an upper limit
        axes.plot(of_bias[2], y, 4, color=colour)


def radius(data):
    """[Lu20, figure 24]: the initial radius."""
    figure, grid = panels(1, 3, 3.8)
    modes = [m for m in data.values("mode", experiment="radius") if m != "none"]
    for m in modes:
        rows = data.find(data.cells, experiment="radius", mode=m)
        x = [float(r["setting"].split()[1]) for r in rows]
        errors = [rmse(data.column("relative_mse", experiment="radius", program=r["program"])) for r in rows]
        style = {"color": COLOUR[m], "marker": "o", "markersize": 4, "label": m}
        for axes, values in zip(grid[0], (errors, *zip(*map(parts, rows)))):
            curve(axes, x, values, **style)
    plain = rmse(data.column("relative_mse", experiment="radius", mode="none"))[0]
    for axes, title in zip(grid[0], ("relative RMSE", "bias", "noise")):
        if title != "bias":
            axes.axhline(plain, color="black", linewidth=1, linestyle="--", label="no shifts")
        axes.set(title=title, xlabel="radius after one mutation per pixel, pixels")
        logarithmic(axes)
    legend_below(figure, grid[0][0])
    return figure


def alpha(data):
    """[Lu20, figure 25]: left alpha; middle what its theory promises; right the error outside the medium."""
    figure, grid = panels(1, 3, 4.2)
    left, middle, right = grid[0]
    wanted = {"experiment": "alpha", "integrator": "path"}
    top = data.counts(**wanted)[-1]
    for m in [m for m in data.values("mode", **wanted) if m != "none"]:
        rows = [r for r in data.find(data.cells, **wanted, mode=m, count=top)]
        x = [float(r["setting"].split()[1]) for r in rows]
        curve(left, x, [rmse(data.column("relative_mse", **wanted, program=r["program"], count=top)) for r in rows],
              color=COLOUR[m], marker="o", markersize=4, label=f"{m} (theory: {ALPHA[m]})")  # fmt: skip
        left.axvline(ALPHA[m], color=COLOUR[m], linewidth=0.7, linestyle=":")
    left.set(title=f"path, {top} per pixel", xlabel="alpha (1: constant radius)", ylabel="relative RMSE")
    logarithmic(left, both=False)
    left.legend(frameon=False, fontsize=8)
    schedules(data, middle)
    for p in family(data, "mmlt"):
        error_curve(data, right, "count", "outside_mse", experiment="convergence", scene="smoke", program=p)
    right.set(title="mmlt in smoke, outside of the medium", xlabel="mutations per pixel")
    right.legend(frameon=False, fontsize=7)
    logarithmic(right)
    return figure


def schedules(data, axes):
    """Bias over the counts: radii that shrink, those that do not, and those of the printed schedule."""
    for m in [m for m in data.values("mode", experiment="alpha") if m != "none"]:
        for setting, line in ((f"alpha {ALPHA[m]}", "--"), ("alpha 1", ":")):
            rows = data.find(data.cells, experiment="alpha", mode=m, setting=setting)
            if rows:
                style = {"color": COLOUR[m], "linestyle": line, "marker": "o", "markersize": 4, "label": f"{m}, {setting}"}
                curve(axes, [int(r["count"]) for r in rows], [next(parts(r)) for r in rows], **style)
    axes.set(title="bias over the samples", xlabel="samples or mutations per pixel", ylabel="relative bias")
    axes.legend(frameon=False, fontsize=7)
    logarithmic(axes)


def settings(data):
    """Squared error times CPU time, without shifts over with them: members of a batch, moving vertices, how often."""
    figure, grid = panels(1, len(SCENES), 4)
    for axes, scene in zip(grid[0], SCENES):
        wanted = {"experiment": "settings", "scene": scene, "mode": "exchangeable"}
        rows = [r for r in data.find(data.cells, **wanted) if r["setting"]]
        gains = np.array([gain(data, r) for r in rows])
        for at, (value, low, high), r in zip(range(len(rows)), gains, rows):
            axes.plot([low, high], [at, at], color=COLOUR["exchangeable"], linewidth=1)
            axes.plot(value, at, STYLE[r["integrator"]][1], color=COLOUR["exchangeable"])
        axes.axvline(1, color="black", linewidth=0.7)
        axes.set(title=scene, xscale="log", yticks=range(len(rows)), xlim=(np.nanmin(gains[:, 0]) / 3, np.nanmax(gains[:, 0]) * 3))
        axes.set_yticklabels([f"{r['integrator']} {r['setting']}" for r in rows] if scene == SCENES[0] else [])
        axes.invert_yaxis()
        label(axes.xaxis)
        axes.grid(alpha=0.25, axis="x", which="both")
    figure.supxlabel("gain of shifts at equal CPU time")
    return figure


def gain(data, row):
    """Of shifts over none."""
    wanted = {"experiment": "settings", "scene": row["scene"]}
    pairs = [[data.column(c, **wanted, **which) for c in ("relative_mse", "cpu_seconds")]
             for which in ({"integrator": row["integrator"], "mode": "none"}, {"program": row["program"]})]
    return products(*pairs)
