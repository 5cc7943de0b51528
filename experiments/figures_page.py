"""The page of `make figures`: plots, pictures and tables in one HTML file, which needs no network; and README.md's part of them."""
import base64
import html
import shutil

import figures_plots as plots
import figures_tables as tables
from figures_data import Data
from figures_plan import CLAMP, FIRST_RADIUS, FOOTPRINT, RADIUS, SCENES, STEP
from measures import ALLOWANCE, BLUR, ROOT, reference_name
from tables import html_table, marked_up, markdown, replace_between_markers

README_PLOTS = ["beaten", "bias"]

STYLE = """body{font:15px/1.45 system-ui,sans-serif;max-width:1250px;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:1em 0;font-size:13px;font-variant-numeric:tabular-nums}
td,th{padding:2px 8px;border-bottom:1px solid #ddd;text-align:right}td:first-child,th:first-child,td:nth-child(2){text-align:left}
tr:hover td{background:#f2f6fa}img{max-width:100%}code{font-size:90%}summary{cursor:pointer;color:#555}figcaption{color:#555}"""


def draw_all(data):
    ours = tables.our_contenders(data)
    return {
        "mmlt": plots.convergence(data, plots.family(data, "mmlt")),
        "path": plots.convergence(data, plots.family(data, "path")),
        "beaten": plots.convergence(data, ours, ("convergence", "peers"), ("cpu_seconds",)),
        "flip": plots.flip(data, ours),
        "bias": plots.bias(data),
        "radius": plots.radius(data),
        "alpha": plots.alpha(data),
        "settings": plots.settings(data),
    }


# ---- parts of the page ----


def picture(folder, name, caption):
    if not (folder / f"{name}.png").exists():
        return paragraph(f"{caption} (Not drawn: the renders are not here.)")
    bits = base64.b64encode((folder / f"{name}.png").read_bytes()).decode()
    text = html.escape(caption)
    return f'<figure><img src="data:image/png;base64,{bits}" alt="{text}"><figcaption>{text}</figcaption></figure>'


def table(found):
    """With the commands of its rows below, folded."""
    header, rows = found
    commands = "".join(f"<li>{html.escape(', '.join(cells[:2]))}: <code>{html.escape(command)}</code></li>" for cells, command in rows)
    return f"{html_table(header, [cells for cells, _ in rows])}<details><summary>commands</summary><ul>{commands}</ul></details>"


def paragraph(text):
    return f"<p>{marked_up(text)}</p>"


OWN = [s for s in SCENES if reference_name(s) != s]
OURS_TEXT = f"; of {' and '.join(OWN)} our own, checked against those, scenes/README.md" if OWN else ""
ABOUT = f"""Errors are relative to the references (Mitsuba 3's `volpath`, 128 x 128{OURS_TEXT}), their noise taken out; RMSE is the root of the mean
over pixels and channels. Intervals are 95 %, over the seeds, by the jackknife; tests are at 95 % each, so that of twenty verdicts where
there is no difference one is wrong. Gains are ratios of squared errors: how many times more samples, or time, the other needs. Radii of
the thesis' kernel, a ball, are {RADIUS} pixels in the middle of the scene after one sample per pixel unless said otherwise (a pixel is
{", ".join(f"{FOOTPRINT[s]} in {s}" for s in SCENES)}, in world units), and shrink as i^((alpha - 1)/3). Counts of samples go up by factors
of {STEP}. One thread each; CPU-seconds are user + system time, start-up included (for Mitsuba: of the render call alone, compiled before)."""

ALLOWED = ", ".join(f"{ALLOWANCE[s]:.1%} in {s}" for s in SCENES if ALLOWANCE[s] > 0)
MODES_TEXT = f"""**gain**: squared error without shifts over that with them, at equal samples, and at equal CPU time, also after both
images were blurred. **FLIP : without**: perceptual error with shifts over that without, at equal samples. **slope**: of RMSE over samples,
both logarithmic, if those go up by {tables.WIDE} or more; -0.5 without bias. **noise**, **bias**: of one image, rms over the pixels; what
is below its own uncertainty and what the reference is known to be wrong by ({ALLOWED}) is an upper limit. **energy**: image mean over that
without shifts, from the same paths. **z**: of the image's mean against the reference's, beyond what the reference is known to be wrong by.
**z paired**: against the same seeds, and so the same paths, without shifts. Bold z: beyond 3. **blocks > 2**: share of blocks of 8 x 8
pixels whose z, less the same allowance, is beyond 2; no more than 4.6 % if unbiased (chains: more, since their noise comes in spots)."""

EXTRAPOLATED = """~: less than the shortest or more than the longest renders took, so extrapolated. –: not reached in the longest renders,
by an estimator whose bias stays, which more time need not make good; or too small an error to measure."""

FEW_TEXT = """At few mutations per pixel much of a chain's error is that of the image's brightness, which is the same with and without
shifts: it pulls gains towards 1."""

SURFACES_TEXT = """A disk of equal size, in pixels or in world units: only the former moves first vertices on surfaces. Shifts are offsets tried
for all contributions of a path; as many less as there are where surfaces stay belong to them. Below, what paths carry by the kind of their
first vertex, of the image's light and of the path sampler's noise without shifts (a layer's covariance with the image over the image's
variance, which add up to 1): specular ones never move, and what the camera sees directly (none) has no noise but that of edges."""

DEFAULTS_TEXT = f"""Squared error at equal CPU time: nothing set (the scene and an output alone) over the best unbiased setting measured;
without shifts over with the best of them. The best of several settings was picked by the same renders that it is judged by: it looks
better than it is, by part of its interval. **within {tables.NEAR - 1:.0%}** and **goal** are yes or no where the whole interval is on one
side; of the goal's two, one has to reach it."""


TRIED_TEXT = """Where the goal is missed: in `smoke` and `cloud` a path costs 2 to 4 microseconds, as much as 3 to 5 shifted ones, each of which takes
part of a line integral to be placed and one or two to be weighed. Tried there: tiles of 4 to 36 pixels, runs of 1 to 8 vertices, disks and balls, `exact`
and `two_level` (all above); batches made by chance where they are worth little, which pays in `room` alone, whose paths differ much; line integrals in 0.55 to
0.9 of their time. Renderers whose paths cost more gain more: examples_c/own_path_tracer.c, 3.6 times at 11 microseconds, 6 at 31. In
`caustic` the best sampler is `bdpt`, which finds most of the light by paths that lights' subpaths show the camera themselves: these cannot
move, so shifts gain with `path` and `mmlt`, where a tile takes most of the noise for 2 to 3 times the time."""


def sections(data, folder):
    """Title, then parts."""
    yield "The thesis' claims, measured again", [
        paragraph("Whether batches of gradients beat plain MMLT at equal mutations, and whether those without bias do."),
        paragraph(FEW_TEXT),
        table(tables.claims(data)),
    ]
    yield "Figure 21: smoke", [picture(folder, "details", "One render each; its difference from the reference; bias apart from noise; details.")]
    yield "Figure 22: the caustic", [picture(folder, "counts", "Mutations, or samples, per pixel above each picture.")]
    yield "Figure 23: convergence", [
        picture(folder, "scenes", "One render each, of the highest count."),
        picture(folder, "mmlt", "Metropolis chains: error against mutations, and against CPU time."),
        picture(folder, "path", "Path sampler and bidirectional paths, likewise."),
    ]
    yield "What the figures of the thesis hide: bias and cost", [
        paragraph(MODES_TEXT),
        picture(folder, "bias", "Bias (full dots; arrows: upper limits) and noise (rings) of one image, rms over the pixels."),
        "<h3>Metropolis chains</h3>", paragraph(FEW_TEXT), table(tables.modes(data, "mmlt")),
        "<h3>Path sampler</h3>", table(tables.modes(data, "path")),
    ]  # fmt: skip
    yield "Figure 24: the initial radius", [
        picture(folder, "radii", "Smoke: one render for each radius, and its bias."),
        picture(folder, "radius", f"Error, bias and noise; weights clamped at {CLAMP}. exchangeable: at a constant radius, unbiased."),
    ]
    yield "Figure 25: alpha, and the error outside of the medium", [
        picture(folder, "alpha", "Left: error against alpha, with theory's optimum dotted. Middle: bias of shrinking and constant radii."),
        table(tables.best_alpha(data)),
        paragraph(f"Schedules: alpha 1 keeps the radius; thesis_printed begins anew with each batch, as [Lu20 alg. 2] is printed. The thesis' "
                  f"begin with a radius of {FIRST_RADIUS} pixels. Weights linear in the gradient are clamped at {CLAMP}."),
        table(tables.schedules(data)),
        paragraph(f"Outside: pixels whose camera rays meet no medium. There are some in {' and '.join(tables.with_outside(data))}."),
    ]
    yield "Correlated noise: blurred errors and FLIP", [
        picture(folder, "flip", f"Relative RMSE after a blur of {BLUR:g} pixels, and FLIP, against CPU time."),
    ]  # fmt: skip
    yield "Settings: members, moving vertices, how often", [
        paragraph("n members besides the path itself, runs of so many vertices (1: the thesis' single vertex), T mutations per batch."),
        picture(folder, "settings", "Gain of `exchangeable` shifts over none, at equal CPU time."),
    ]
    yield "Surfaces first", [
        paragraph(SURFACES_TEXT),
        table(tables.surfaces(data)),
        table(tables.layers(data)),
    ]
    yield "Beside what people would use instead", [
        picture(folder, "beaten", "Relative RMSE against CPU time."),
        paragraph(f"CPU-seconds to 10 % and to 3 % relative RMSE, by RMSE ~ 1/sqrt(time). {EXTRAPOLATED}"),
        table(tables.peers(data)),
    ]
    yield "Defaults from evidence", [
        paragraph(DEFAULTS_TEXT),
        table(tables.defaults(data)),
        "<h3>Where time and variance go</h3>", table(tables.where(data)), paragraph(TRIED_TEXT),
    ]  # fmt: skip
    yield "The same seeds, the same bits", [table(tables.repeated(data))]


def page_text(data, folder):
    parts = ["<!doctype html><html lang=en><meta charset=utf-8><title>volgrad: figures</title>", f"<style>{STYLE}</style>"]
    parts += ["<h1>The thesis' figures, again and beyond</h1>", paragraph(f"{data.about}. Written by `make figures`."), paragraph(ABOUT)]
    for title, content in sections(data, folder):
        parts += [f"<h2>{html.escape(title)}</h2>", *content]
    return "\n".join(parts) + "</html>\n"


README = """{about}. Again with `make figures`, which writes everything into one page, with the data in
[experiments/figures](experiments/figures).

Metropolis chains, at equal mutations per pixel: how many times lower the squared error is than without shifts. {few}

{claims}

CPU-seconds to 10 % and to 3 % relative RMSE, 95 % intervals. {extrapolated}

{peers}

![relative RMSE against CPU time](experiments/figures/beaten.png)
![bias and noise of each mode](experiments/figures/bias.png)"""


def readme_text(data):
    claims, peers = ([header, [cells for cells, _ in rows]] for header, rows in (tables.claims(data), tables.peers(data)))
    return README.format(about=data.about, few=FEW_TEXT, extrapolated=EXTRAPOLATED, claims=markdown(*claims), peers=markdown(*peers))


def write(tables_folder, output):
    """output: the folder of the page, of plots, and of pictures that are there."""
    data = Data(tables_folder)
    output.mkdir(parents=True, exist_ok=True)
    for name, figure in draw_all(data).items():
        plots.save(figure, output / f"{name}.png")
    for name in README_PLOTS:
        shutil.copy(output / f"{name}.png", tables_folder)
    page = output / "figures.html"
    page.write_text(page_text(data, output))
    replace_between_markers(ROOT / "README.md", "figures", readme_text(data))
    print(f"written: {page}")
