# SPDX-License-Identifier: Apache-2.0
"""The page docs/reproduction.md: every entry with its commands, its table and its pictures."""
import json
import os
import shutil
import textwrap

import harness
import meshes
import tables

PAPERS = {"SK23": "A Shape Modulus for Fractal Geometry Generation", "Kim15": "Quaternion Julia Set Shape Optimization",
          "KD20": "A Massive Fractal in Days, Not Years", "ZB25": "Reformulating Multiplication for Mandelbrot-like Sets in 3D",
          "": "Ablations"}

HEAD = """# The papers' tables and figures

`reproduce/run` has written this page. Each section is one of its entries: the commands as they ran, what the paper has,
what they gave here, and the ratio of ours to the paper's. [replication.md](replication.md) says what the replication found,
[gallery.md](gallery.md) has the figures at their full size, and `reproduce/data/README.md` describes meshes and data.
`reproduce/run --help` explains its options. A run that was interrupted goes on where it stopped, and makes the same tables.

{conditions}

CPU times are those of all threads. Memory is the largest resident size of a process. A ratio stands only where both numbers
mean the same. The commands run in one folder for each entry, in this order, after these lines:

```
{variables}
```

{entries}
"""


def cpu_seconds(result):
    return float(sum(step["cpu"] for step in result["steps"]))


def conditions(results, missing):
    runs = {}
    for result in results:
        runs.setdefault((result["size"], result["date"][:10], result["machine"], result["version"]), []).append(result["entry"])
    lines = [f"**Run at the size {size}** on {date}, on {machine}, by {version}"
             + (": " + ", ".join(f"`{name}`" for name in names) if len(runs) > 1 else "") + "."
             for (size, date, machine, version), names in runs.items()]
    note = {"small": "The size small shows that everything runs; its numbers mean nothing.",
            "medium": "The size medium has fewer voxels than the papers, where that saves time. Where a number grows with that, "
                      "there is no ratio."}
    lines += [note[size] for size in dict.fromkeys(result["size"] for result in results) if size in note]
    lines.append("The entries without a result were not run: " + ", ".join(f"`{entry.name}`" for entry in missing) + "."
                 if missing else f"All entries were run, in {sum(cpu_seconds(result) for result in results) / 60:.0f} minutes of CPU time.")
    return "\n".join(textwrap.fill(line, 120, break_long_words=False, break_on_hyphens=False) for line in lines)


def shown(entry, result):
    """The pictures that the page shows. Those of the gallery are on its own page."""
    return result["pictures"] if entry.item != "Figures" else []


def section(entry, result, values, pictures):
    lines = [f"### {entry.source}: {entry.title}", ""]
    if entry.remarks:
        lines += [textwrap.fill(entry.remarks, 120, break_long_words=False, break_on_hyphens=False), ""]
    lines += [tables.as_markdown(values)]
    for picture in shown(entry, result):
        lines += [f"![{entry.name}, {picture}]({pictures}/{entry.name}-{picture})"]
    if shown(entry, result):
        lines.append("")
    lines += [f"`reproduce/run {entry.name}` took {tables.text(cpu_seconds(result))} CPU seconds at the size {result['size']}. Its commands:", "", "```"]
    lines += [step["command"] for step in result["steps"]]
    return "\n".join(lines + ["```", ""])


def write_data(data, entries, runner):
    """Writes the tables of the results into the folders SIZE of `data`, and the hashes of all its files."""
    for size in harness.SIZES:
        shutil.rmtree(data / size, ignore_errors=True)
    for entry in entries:
        result = runner.stored(entry)
        if result:
            place = data / result["size"]
            place.mkdir(parents=True, exist_ok=True)
            (place / f"{entry.name}.csv").write_text(tables.as_csv(runner.values(entry, result)))
    files = sorted(path for path in data.rglob("*") if path.is_file() and path.name not in ("README.md", "SHA256SUMS"))
    (data / "SHA256SUMS").write_text("".join(f"{harness.sha256(path)}  {path.relative_to(data)}\n" for path in files))


def write(path, folder, entries, runner):
    """Writes the page of the results that are in the folder. Pictures go into the folder images/reproduction beside it."""
    found, missing = [], []
    for entry in entries:
        result = runner.stored(entry)
        (found if result else missing).append((entry, result) if result else entry)
    images = path.parent / "images/reproduction"
    shutil.rmtree(images, ignore_errors=True)
    for entry, result in found:
        for picture in shown(entry, result):
            images.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(folder / entry.name / picture, images / f"{entry.name}-{picture}")
    parts = []
    for paper, title in PAPERS.items():
        of = [(entry, result) for entry, result in found if entry.paper == paper]
        if of:
            parts += [f"## {title}", ""]
            parts += [section(entry, result, runner.values(entry, result), "images/reproduction") for entry, result in of]
    used = sorted({name for _, result in found for name in result["inputs"]}, key=list(meshes.SOURCES).index)
    inputs = {name: result["inputs"][name] for _, result in found for name in result["inputs"]}
    known = json.loads((harness.ROOT / "reproduce/data/meshes.json").read_text())
    variables = [f"{name}={name}.obj   # {known.get(of['sha256'], of['origin'])}; SHA-256 {of['sha256'][:12]}"
                 for name, of in ((name, inputs[name]) for name in used)]
    text = HEAD.format(conditions=conditions([result for _, result in found], missing), variables="\n".join(variables),
                       entries="\n".join(parts).rstrip("\n"))
    beside = path.with_name(path.name + ".new")
    beside.write_text(text)
    os.replace(beside, path)
