"""Where libvolgrad_core could panic: each place in the source from which a call to core::panicking is left after optimisation.
freestanding.sh demands that there is none. Usage: panics.py ARCHIVE, as cargo makes it, with debug=1 (make panics)."""

import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path


def run(*command, folder=None):
    return subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True).stdout


def calls(listing):
    """Section and address of each call."""
    section = None
    for line in listing.splitlines():
        if match := re.match(r"Disassembly of section (\S+):", line):
            section = match[1]
        elif match := re.match(r"\s+([0-9a-f]+): R_\S+\s+\S*(panicking|slice_index_fail|unwrap_failed|expect_failed)", line):
            # The relocation lies in the call, before its end.
            yield section, hex(int(match[1], 16) - 1)


def place(object_file, section, address, root):
    """The innermost line of ours that leads there, and the lines it is inlined into."""
    frames = run("addr2line", "-i", "-j", section, "-e", str(object_file), address).split()
    return " < ".join(frame.removeprefix(root) for frame in frames if frame.startswith(root)) or section


def main():
    root = f"{Path(__file__).resolve().parents[2]}/"
    archive = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        [name] = [member for member in run("ar", "t", str(archive)).split() if member.startswith("volgrad-")]
        run("ar", "x", str(archive), name, folder=folder)
        listing = run("objdump", "-dr", "--no-show-raw-insn", name, folder=folder)
        places = Counter(place(Path(folder) / name, *call, root) for call in calls(listing))
    for where, count in sorted(places.items()):
        print(f"{count} x {where}")
    print(f"{sum(places.values())} calls")


if __name__ == "__main__":
    main()
