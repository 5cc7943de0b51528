"""Numbers and tables as text: Markdown for README.md and the .md files, HTML for the page of figures."""
import html

import numpy as np


def shown(value, low, high):
    """With its interval, to two digits that count; of an interval over orders of magnitude one is too many."""
    if high > 100 * low:
        return f"{value:.1g} ({low:.0e}–{high:.0e})"
    digits = max(0, int(2 - np.floor(np.log10(value))) - 1)
    return f"{value:.{digits}f} ({low:.{digits}f}–{high:.{digits}f})"


def markdown(header, rows):
    return "\n".join("| " + " | ".join(r) + " |" for r in [header, ["---"] * len(header), *rows])


def html_table(header, rows):
    def line(cells, tag):
        return "<tr>" + "".join(f"<{tag}>{marked_up(c)}</{tag}>" for c in cells) + "</tr>"

    return "<table>" + line(header, "th") + "".join(line(r, "td") for r in rows) + "</table>"


def marked_up(text):
    """Markdown's `code` and **bold** as HTML."""
    text = html.escape(text)
    for mark, tag in (("**", "b"), ("`", "code")):
        parts = text.split(mark)
        text = "".join(p if i % 2 == 0 else f"<{tag}>{p}</{tag}>" for i, p in enumerate(parts))
    return text


def replace_between_markers(path, name, text):
    begin, end = f"<!-- {name}:begin -->", f"<!-- {name}:end -->"
    before, rest = path.read_text().split(begin)
    path.write_text(f"{before}{begin}\n{text}\n{end}{rest.split(end)[1]}")
