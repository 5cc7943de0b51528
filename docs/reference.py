"""Writes docs/reference.md from include/volgrad.h, whose comments are those of src/ffi.

    python3 docs/reference.py               writes docs/reference.md
    python3 docs/reference.py --check       fails if that would change it
    python3 docs/reference.py --statuses    prints a C header that aborts where a function returns an error that its page does not name

What many functions have in common is said once, here: what a parameter of some name is, which errors one of some type brings. The rest is
in each function's comment: sentences that begin with "Costs", VOLGRAD_ERROR_... and citations are put where they belong.
"""

import pathlib
import re
import sys
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUTPUT = ROOT / "docs/reference.md"

# Title, and how the names of its functions begin after volgrad_. The longest that fits counts.
SECTIONS = [
    ("Versions and statuses", ("status_", "abi_", "version")),
    ("Scenes", ("scene_",)),
    ("The host's answers", ("hit_",)),
    ("Lines through media", ("line_", "transmittance_")),
    ("Phase functions", ("phase_",)),
    ("Paths", ("path_",)),
    ("Shifts", ("shift_",)),
    ("Films", ("film_",)),
    ("The path sampler", ("path_sampler_",)),
    ("The bidirectional sampler", ("bidirectional_",)),
    ("Guides", ("guide_",)),
    ("Metropolis chains", ("chain_",)),
    ("OpenEXR files", ("exr_",)),
]

# What a parameter is, by name; (function, name) where that name means something else there.
MEANING = {
    "scene": "a scene, or a guided one",
    "guided": "where the scene goes",
    "queries": "the host's ray queries",
    "options": "settings",
    "pass": "number of the pass: random numbers depend on it",
    "first_pixel": "number of the first pixel, within the camera's crop",
    "pixel_count": "pixels",
    "film": "what is added to",
    "stats": "counts, which grow; or NULL",
    "memory": "writable memory, aligned to 16 bytes, that stays yours",
    "bytes": "its size, bytes",
    "struct_size": "`sizeof` of the struct, bytes",
    "desc": "description of the scene",
    "error": "which field was wrong; or NULL",
    "line": "a line and its media, world units",
    "ray": "a ray that volgrad asked about",
    "hit": "the host's answer",
    "path": "a path and the media along its edges, world units",
    "phase": "a phase function",
    "to_previous": "vector from the vertex to the previous point",
    "to_next": "vector from the vertex to the next point",
    "u": "number in (0, 1)", "u0": "number in [0, 1)", "u1": "number in [0, 1)",
    "tau": "optical depth per channel, no unit",
    "result": "what was found",
    "rgb": "linear RGB",
    "count": "length of the array",
    "capacity": "room in the array",
    "seed": "random seed", "index": "number of the path or estimate: another one for every one",
    "weight": "C = w f/p, linear RGB", "splats": "splats, pixels and linear RGB",
    "width": "pixels", "height": "pixels", "scale": "factor on all sums",
    "into": "what is added to", "from": "what is added",
    "dropped": "how many", "vertex": "number of a vertex on the path, the camera's being 0",
    "first": "number of the first", "chain": "a chain", "mutations": "how many",
    "techniques": "table of `volgrad_chain_learn`; or NULL: all alike",
    "weights": "values of bootstrap samples, luminance", "wanted": "chains, about",
    "starts": "where chains begin; or NULL", "start": "where the chain begins",
    "light_vertices": "vertices from the light", "camera_vertices": "vertices from the camera", "weighted": "0 or 1",
    "layout": "sizes of image and window, pixels", "attributes": "texts and numbers for the file's head",
    "paths": "paths and the media along their edges, world units", "path_count": "length of both arrays",
    "first_index": "number of the first path: another one for every one", "x": "pixel", "y": "pixel",
    "bounds": "first and last pixels, the last exclusive", "text": "buffer for the report, UTF-8; or NULL if `capacity` is 0",
    "length": "of the report, bytes", "mutation": "what will be done", "current": "the path where the chain is",
    "proposed": "the path it will look at", "attribute_count": "length of that array", "status": "a status",
    ("volgrad_film_init", "film"): "where the film goes", ("volgrad_scene_init", "scene"): "where the scene goes",
    ("volgrad_chain_init", "chain"): "where the chain goes", ("volgrad_guide_init", "film"): "what `volgrad_guide_learn` filled",
    ("volgrad_film_develop", "film"): "a film", ("volgrad_film_dropped", "film"): "a film",
    ("volgrad_chain_learn", "techniques"): "the table", ("volgrad_path_run_log_gradient", "count"): "vertices that move",
    ("volgrad_path_run_log_derivative", "count"): "vertices that move", ("volgrad_shift_path", "count"): "splats written",
    ("volgrad_chain_bootstrap", "count"): "samples", ("volgrad_shift_paths", "count"): "splats written",
    ("volgrad_shift_paths", "weights"): "C = w f/p of each path, linear RGB",
    ("volgrad_exr_write", "path"): "UTF-8 name of the file", ("volgrad_exr_read", "path"): "UTF-8 name of the file",
    ("volgrad_exr_read_layout", "path"): "UTF-8 name of the file",
}

OPTIONAL = {"stats", "error", "techniques", "starts"}

# Errors that a parameter brings, by the end of its type or by its name, beside NULL and MISALIGNED of every pointer.
BY_TYPE = [
    (r"const struct volgrad_scene \*|struct volgrad_film \*|struct volgrad_chain \*", ["NOT_INITIALISED"]),
    (r"volgrad_queries \*", ["STRUCT_SIZE", "CALLBACK", "INVALID_HIT"]),
    (r"_options \*", ["STRUCT_SIZE", "KIND", "NOT_FINITE", "RANGE"]),
    (r"(_stats|_plan_result) \*", ["STRUCT_SIZE"]),
    (r"volgrad_scene_desc \*", ["STRUCT_SIZE", "KIND", "NOT_FINITE", "RANGE", "INDEX"]),
    (r"volgrad_line \*", ["NOT_FINITE", "INDEX", "ZERO_LENGTH", "SEGMENTS"]),
    (r"volgrad_path \*", ["KIND", "RANGE", "INDEX", "ZERO_LENGTH", "SEGMENTS"]),
    (r"volgrad_phase \*", ["KIND", "NOT_FINITE", "RANGE"]),
    (r"volgrad_exr_layout \*|const char \*", ["INTERNAL"]),  # a bug in the OpenEXR library stops there
]

# Where derivatives are needed, of which the host may have none for what it computes itself.
NO_GRADIENT = {
    "volgrad_path_log_gradient", "volgrad_path_run_log_gradient", "volgrad_path_run_log_derivative", "volgrad_shift_path",
    "volgrad_shift_paths", "volgrad_path_sampler_run", "volgrad_bidirectional_run", "volgrad_bidirectional_run_technique",
    "volgrad_chain_init", "volgrad_chain_run", "volgrad_chain_flush", "volgrad_chain_peek",
}

# Those of the above that a function does not look for.
NEVER = {"volgrad_scene_size": {"KIND", "NOT_FINITE", "INDEX"}}


@dataclass
class Function:
    name: str
    returns: str
    parameters: list  # of (type with stars, name)
    comment: str
    text: str  # as declared

    def statuses(self):
        """Errors that it may return, in the order of their numbers."""
        if self.returns != "volgrad_status":
            return []
        names = {name for _, name in self.parameters}
        found = set(re.findall(r"VOLGRAD_ERROR_(\w+)", self.comment))
        if self.name.endswith("_default"):
            return order(found | {"NULL", "MISALIGNED", "STRUCT_SIZE"})
        for kind, name in self.parameters:
            if "*" in kind and name not in OPTIONAL:
                found.add("NULL")
            if "*" in kind and "char" not in kind and name != "error":
                found.add("MISALIGNED")
            for pattern, errors in BY_TYPE:
                if re.search(f"(?:{pattern})$", kind):
                    found |= set(errors)
        if self.name in NO_GRADIENT:
            found.add("NO_GRADIENT")
        if "memory" in names or "capacity" in names:
            found.add("TOO_SMALL")
        if "film" in names and ("scene" in names or "chain" in names) or "into" in names:
            found.add("SIZE_MISMATCH")
        if "count" in names and any("*" in kind for kind, name in self.parameters if name in ("weights", "splats")):
            found.add("RANGE")
        return order(found - NEVER.get(self.name, set()))


def order(errors):
    return [error for error in STATUSES if error in errors]


def clean(comment):
    return " ".join(line.strip() for line in comment.split("\n")).strip()


def paragraphs(lines):
    """Comment lines without their slashes; an empty one ends a paragraph."""
    return "\n\n".join(clean(part) for part in "\n".join(lines).split("\n\n"))


def parse(header):
    """Functions, structs (name, comment, [(field, comment)]), constants (name, value, comment), callbacks, statuses."""
    functions, structs, constants, callbacks, statuses = [], [], [], [], []
    comment, lines = [], iter(header.split("\n"))
    for line in lines:
        if line.startswith("//"):
            comment.append(line[3:])
            continue
        text, comment = paragraphs(comment), comment if line.startswith("#if") else []
        if match := re.match(r"#define (VOLGRAD_\w+) (\S+)", line):
            constants.append((match[1], match[2], text))
        elif re.match(r"enum volgrad_status", line):
            statuses = members(lines)
        elif match := re.match(r"typedef struct (volgrad_\w+) \{", line):
            structs.append((match[1], text, fields(lines)))
        elif match := re.match(r"typedef struct (volgrad_\w+) \1;", line):
            structs.append((match[1], text, []))
        elif match := re.match(r"typedef .*\(\*(volgrad_\w+)\)", line):
            callbacks.append((match[1], text, whole(line, lines)))
        elif match := re.match(r"(volgrad_status|const char \*|uint32_t )\s?(volgrad_\w+)\((.*)", line):
            declared = whole(line, lines)
            inside = clean(declared[declared.index("(") + 1 : declared.rindex(")")])
            parameters = [] if inside == "void" else [split(parameter) for parameter in inside.split(",")]
            functions.append(Function(match[2], match[1].strip(), parameters, text, declared))
    return functions, structs, constants, callbacks, statuses


def whole(declared, lines):
    """A declaration to its end."""
    while not declared.endswith(";"):
        declared += "\n" + next(lines)
    return declared


def split(parameter):
    match = re.match(r"(.*?)(\w+)$", parameter.strip())
    return match[1].strip(), match[2]


def fields(lines):
    result, comment = [], []
    for line in lines:
        if line.startswith("}"):
            return result
        if line.strip().startswith("//"):
            comment.append(line.strip()[3:])
        else:
            result.append((line.strip().rstrip(";"), paragraphs(comment)))
            comment = []


def members(lines):
    result, comment = [], []
    for line in lines:
        if line.startswith("};"):
            return result
        if line.strip().startswith("//"):
            comment.append(line.strip()[3:])
        elif match := re.match(r"\s+VOLGRAD_(\w+) = (\d+),", line):
            result.append((match[1].removeprefix("ERROR_"), int(match[2]), paragraphs(comment)))
            comment = []


def section_of(name):
    fits = [(len(start), title) for title, starts in SECTIONS for start in starts if name.removeprefix("volgrad_").startswith(start)]
    return max(fits)[1] if fits else name.split("_")[1].capitalize()


def cell(text):
    return text.replace("\n\n", "<br>").replace("|", "\\|").replace("<gradient", "&lt;gradient")


def threads(function):
    def is_output(kind):
        return "**" in kind or "const" not in kind

    own = [f"`{name}`" for kind, name in function.parameters if "*" in kind and is_output(kind)]
    shared = [f"`{name}`" for kind, name in function.parameters if "*" in kind and not is_output(kind)]
    result = []
    if shared:
        result.append(f"{', '.join(shared)} may be shared.")
    if own:
        result.append(f"{', '.join(own)}: this thread's alone during the call.")
    return " ".join(result) or "Any."


def examples(name, files):
    return [str(path.relative_to(ROOT)) for path, text in files if re.search(rf"\b{name}\b", text)][:2]


def describe(function, files):
    costs = re.findall(r"Costs? .*?[.:](?=\s|$)", function.comment)
    prose = function.comment
    for cost in costs:
        prose = prose.replace(cost, "")
    lines = [f"### `{function.name}`", ""]
    lines += ["    " + line for line in function.text.split("\n")] + [""]
    lines += [re.sub(r"  +", " ", part).strip() + "\n" for part in prose.split("\n\n") if part.strip()]
    if function.parameters:
        lines += ["| parameter | type | |", "|---|---|---|"]
        for kind, name in function.parameters:
            meaning = MEANING.get((function.name, name), MEANING.get(name, ""))
            if not meaning:
                print(f"docs/reference.py: no meaning for {name} of {function.name}", file=sys.stderr)
            lines.append(f"| `{name}` | `{kind.replace('struct ', '')}` | {meaning} |")
        lines.append("")
    errors = function.statuses()
    if function.returns == "volgrad_status":
        lines.append(f"* Errors: {', '.join('`' + error + '`' for error in errors)}")
    lines.append(f"* Threads: {threads(function)}")
    trivial = function.name.endswith(("_default", "_size", "version", "_message"))
    lines.append(f"* Cost: {' '.join(cost.removeprefix('Costs ') for cost in costs) or ('constant.' if trivial else '')}".rstrip())
    if not costs and not trivial:
        print(f"docs/reference.py: {function.name} does not say what it Costs", file=sys.stderr)
    if source := sorted(set(re.findall(r"\[[A-Z]\w+\d\d[^\]]*\]", function.comment))):
        lines.append(f"* Source: {', '.join(source)}")
    if found := examples(function.name, files):
        lines.append(f"* Example: {', '.join(f'[{path}](../{path})' for path in found)}")
    return "\n".join(lines) + "\n"


def struct(name, comment, members):
    lines = [f"### `{name}`", "", comment or "", ""]
    if members:
        lines += ["| field | |", "|---|---|"]
        lines += [f"| `{declared.replace('struct ', '')}` | {cell(text)} |" for declared, text in members]
    return "\n".join(lines) + "\n"


def reference(functions, structs, constants, callbacks, statuses):
    paths = [*sorted((ROOT / "examples_c").glob("*.c*")), ROOT / "docs/conventions.md", *sorted((ROOT / "tests/c").glob("*_test.c"))]
    files = [(path, path.read_text()) for path in paths if path.exists()]
    out = ["# Reference", "", "Written by `docs/reference.py` from `include/volgrad.h`; edit the comments in `src/ffi`. Read",
           "[conventions.md](conventions.md) first: units, frames, threads, errors and sizes are said there, once for all functions.", "",
           "Errors are listed without their `VOLGRAD_ERROR_`. That no others are returned is what all tests and fuzzers of the C interface",
           "check on every call that they make.", ""]
    titles = list(dict.fromkeys([title for title, _ in SECTIONS] + [section_of(f.name) for f in functions]))
    for title in titles + ["Structs", "Callbacks", "Constants", "Statuses"]:
        out.append(f"* [{title}](#{title.lower().replace(' ', '-')})")
    out.append("")
    for title in titles:
        out += [f"## {title}", ""] + [describe(f, files) for f in functions if section_of(f.name) == title]
    out += ["## Structs", ""] + [struct(*s) for s in sorted(structs)]
    out += ["## Callbacks", ""] + [f"### `{name}`\n\n    {text}\n\n{comment}\n" for name, comment, text in callbacks]
    out += ["## Constants", "", "| name | value | |", "|---|---|---|"]
    out += [f"| `{name}` | {value} | {cell(comment)} |" for name, value, comment in constants]
    out += ["", "## Statuses", "", "| name | value | |", "|---|---|---|"]
    out += [f"| `VOLGRAD_{'' if name == 'OK' else 'ERROR_'}{name}` | {value} | {cell(comment)} |" for name, value, comment in statuses]
    return "\n".join(out) + "\n"


def status_header(functions):
    """Every call of a function becomes one that checks what it returns."""
    lines = ["/* Written by docs/reference.py --statuses: a status that a function's page does not name aborts. */",
             "#ifndef DOCUMENTED_H", "#define DOCUMENTED_H", "#include <stdio.h>", "#include <stdlib.h>", '#include "volgrad.h"',
             "static inline volgrad_status documented(const char *name, uint32_t mask, volgrad_status status) {",
             "    if (status >= 0 && status < 32 && mask >> status & 1) return status;",
             '    fprintf(stderr, "%s returned %d (%s), which docs/reference.md does not name\\n", name, status, '
             "volgrad_status_message(status));", "    abort();", "}"]
    for function in functions:
        if function.returns == "volgrad_status":
            mask = 1 + sum(1 << STATUSES.index(error) for error in function.statuses())
            lines.append(f'#define {function.name}(...) documented("{function.name}", {mask:#x}, ({function.name})(__VA_ARGS__))')
    return "\n".join(lines + ["#endif", ""])


def main():
    global STATUSES
    parsed = parse((ROOT / "include/volgrad.h").read_text())
    STATUSES = [name for name, _, _ in sorted(parsed[4], key=lambda status: status[1])]
    if "--statuses" in sys.argv:
        print(status_header(parsed[0]), end="")
        return
    text = reference(*parsed)
    if "--check" in sys.argv:
        if OUTPUT.read_text() != text:
            sys.exit("docs/reference.md is stale: python3 docs/reference.py")
    else:
        OUTPUT.write_text(text)


if __name__ == "__main__":
    main()
