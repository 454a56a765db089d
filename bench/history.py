#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Keeps what the program took on which day, and says what has become slower.

    JULIAVDB_BENCH_MESH=bunny.obj bench/table --only-program --history    measures, and adds a run to bench/history.json
    bench/history.py                                                      compares the last run with the one before it
    bench/history.py --plot history.svg                                   draws the CPU seconds of all runs

Only runs on the same processor are compared. A time counts as slower if it is more than 15 % longer: CPU times of the same
program differ by some 10 % on a machine that others use, too.
"""
import argparse
import datetime
import html
import json
import math
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FILE = ROOT / "bench/history.json"
SLOWER = 1.15


def commit():
    done = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True)
    return done.stdout.strip() or "unknown"


def entry(report, processor):
    """A run of the history: CPU seconds by what was done."""
    times = {f"fractal {w['mesh']}, N = {w['N']}": round(w["cpu"], 3) for w in report["waits"]}
    times |= {f"sdf {w['mesh']}, half width {w['width']}": round(w["own"], 3) for w in report["widths"]}
    return {"date": datetime.date.today().isoformat(), "commit": commit(), "processor": processor, "cpuSeconds": times}


def read(path):
    return json.loads(path.read_text()) if path.exists() else []


def add(path, run):
    runs = read(path) + [run]
    path.write_text("[\n" + ",\n".join(json.dumps(r) for r in runs) + "\n]\n")
    return runs


def slower(runs):
    """Lines about what the last run needs longer for than the one before it on the same processor."""
    if not runs:
        return []
    last = runs[-1]
    before = next((r for r in reversed(runs[:-1]) if r["processor"] == last["processor"]), None)
    if not before:
        return []
    return [f"{what}: {time:g} CPU s, and {before['cpuSeconds'][what]:g} in {before['commit']} of {before['date']}"
            for what, time in last["cpuSeconds"].items()
            if time > SLOWER * before["cpuSeconds"].get(what, float("inf"))]


def verdict(runs):
    lines = slower(runs)
    return "\n".join(["slower than before:", *lines]) if lines else "nothing has become slower"


def plot(runs):
    """A curve for each thing that was done, as SVG: CPU seconds over the runs, on a logarithmic scale."""
    width, height, left, top = 640, 360, 60, 20
    names = list(dict.fromkeys(name for run in runs for name in run["cpuSeconds"]))
    times = [time for run in runs for time in run["cpuSeconds"].values() if time > 0]
    if not times:
        sys.exit("the history has no run; measure one with bench/table --only-program --history")
    low, high = math.floor(math.log10(min(times))), math.ceil(math.log10(max(times)) + 1e-9)
    x = lambda i: left + (width - left) * (i / max(1, len(runs) - 1))
    y = lambda time: top + height * (high - math.log10(time)) / max(1, high - low)
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width + 260}" height="{height + 60}" '
             'font-family="sans-serif" font-size="11">', '<rect width="100%" height="100%" fill="white"/>']
    for power in range(low, high + 1):
        at = y(10.0 ** power)
        lines.append(f'<path d="M{left} {at:.1f}H{width}" stroke="#ddd"/><text x="{left - 6}" y="{at + 4:.1f}" '
                     f'text-anchor="end">{10.0 ** power:g} s</text>')
    for i, run in enumerate(runs):
        lines.append(f'<text x="{x(i):.1f}" y="{top + height + 16}" text-anchor="middle">{html.escape(run["date"])}</text>')
    for n, name in enumerate(names):
        colour = f"hsl({360 * n // len(names)},60%,40%)"
        points = [(x(i), y(r["cpuSeconds"][name])) for i, r in enumerate(runs) if r["cpuSeconds"].get(name, 0) > 0]
        lines.append(f'<polyline fill="none" stroke="{colour}" points="' +
                     " ".join(f"{a:.1f},{b:.1f}" for a, b in points) + '"/>')
        lines += [f'<circle cx="{a:.1f}" cy="{b:.1f}" r="2.5" fill="{colour}"/>' for a, b in points]
        lines.append(f'<text x="{width + 12}" y="{top + 14 * n + 8}" fill="{colour}">{html.escape(name)}</text>')
    return "\n".join(lines + ["</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--file", type=pathlib.Path, default=FILE, help="the history (default bench/history.json)")
    parser.add_argument("--plot", type=pathlib.Path, metavar="SVG", help="draw it")
    options = parser.parse_args()
    runs = read(options.file)
    if options.plot:
        options.plot.write_text(plot(runs))
    print(verdict(runs))
    return 1 if slower(runs) else 0


if __name__ == "__main__":
    sys.exit(main())
