# SPDX-License-Identifier: Apache-2.0
"""[SK23] Schor and Kim, A Shape Modulus for Fractal Geometry Generation."""
from harness import Entry, Step, Value
from meshes import use

from .parts import gallery, hours

# ------------------------------------------------------------------------------------------------ Table 1

def table_1_steps(size):
    return [Step("rational map", f"juliavdb fit $bunny -o map.json --roots {size.pick(12, 331, 331)} --resolution {size.pick(25, 97, 97)}"),
            Step("shape modulus", f"juliavdb fractal $bunny --alpha 40 --texture-roots 10 --texture-integer "
                                  f"--resolution {size.pick(40, 300, 300)} --mesh bunny.ply")]


def table_1(outputs, size):
    fit, fractal = outputs["rational map"], outputs["shape modulus"]
    roots = fit.counts["topRoots"] + fit.counts["bottomRoots"]
    return [Value("rational map", "parameters that are optimised", int(roots) + 1, 331 + 3, compared=size.name != "small"),
            Value("rational map", "CPU s of the optimisation", fit.cpu, "hours or days"),
            Value("shape modulus", "parameters that are optimised", 0, 0),
            Value("shape modulus", "CPU s of the optimisation", 0, 0),
            Value("shape modulus", "numbers to choose", 2, 2),
            Value("shape modulus", "CPU s of the whole fractal", fractal.cpu, 55.1, compared=False)]

# ------------------------------------------------------------------------------------------------ Table 2

# Of each example: the mesh, its options, and the paper's million triangles, CPU time, time on the clock and cores.
EXAMPLES = {
    "dragon, alpha 10 to 300": ("dragon", "--alpha x:10:300:smooth --texture-roots 40", 26.5, "10:05:03", "1:21:11", 64),
    "dragon, alpha 10": ("dragon", "--alpha 10 --texture-roots 40", 53.5, "41:58:28", "2:01:57", 64),
    "armadillo, alpha 40, beta 0.05": ("armadillo", "--alpha 40 --beta 0.05 --texture-roots 40", 160.3, "70:40:48", "4:20:46", 64),
    "chair, alpha and beta vary": ("chair", "--alpha y:100:200 --beta y:0.01:0.03 --texture-roots 10", 4.23, "19:41:33", "0:05:37", 512),
    "hand, alpha 90, beta 0.02": ("hand", "--alpha 90 --beta 0.02 --texture-roots 40", 12.7, "17:00:23", "0:05:27", 512),
    "bunny, alpha 6": ("bunny", "--alpha 6 --texture-roots 10", 355.8, "62:40:51", "1:01:45", 512),
}


def table_2_steps(size):
    n = size.pick(32, 400, 1600)
    coarse = size.pick(" --sdf-resolution 40", "", "")
    return [Step(name, f"juliavdb fractal {use(mesh)} {options} --texture-integer{coarse} --resolution {n} --crumbs keep --mesh /dev/null")
            for name, (mesh, options, *_) in EXAMPLES.items()]


def table_2(outputs, size):
    same = size.name == "full"
    return [value for name, (_, _, triangles, cpu, clock, cores) in EXAMPLES.items() for value in (
        Value(name, "triangles", int(outputs[name].counts["triangles"]), round(triangles * 1e6), same),
        Value(name, "CPU s", outputs[name].cpu, hours(cpu), same),
        Value(name, "s on the clock", outputs[name].wall, f"{hours(clock)} on {cores} cores"),
        Value(name, "memory, MiB", round(outputs[name].memory / 2**20)),
        Value(name, "% of the target's volume", outputs[name].number("the set holds")))]

# ------------------------------------------------------------------------------------------------ Fig. 8

ALPHAS = (20, 40, 100)


def average_steps(size):
    coarse = size.pick(" --sdf-resolution 40", " --sdf-resolution 60", "")
    return [Step(f"alpha {alpha}", f"juliavdb study $bunny --alpha {alpha} --texture-powers 1:6{coarse} "
                                   f"--versors {size.pick(10, 1000, 1000)} --size {size.pick(40, 60, 400)} -o average-{alpha}.png "
                                   f"--curve curve-{alpha}.png --csv circles-{alpha}.csv", (f"circles-{alpha}.csv",))
            for alpha in ALPHAS]


def average(outputs, size):
    values = []
    for alpha in ALPHAS:
        rows = outputs[f"alpha {alpha}"].table(f"circles-{alpha}.csv")
        radii = [row["radius"] for row in rows]
        # Over the disk: a circle counts as its radius does.
        open_part = sum(r for r, row in zip(radii, rows) if 0 < row["membership"] < 1 and row["mean"] is not None) / sum(radii)
        inner = next((row["radius"] for row in rows if row["membership"] < 1), radii[-1])
        values += [Value(f"alpha {alpha}", "sets", int(outputs[f"alpha {alpha}"].counts["versors"]), 1000),
                   Value(f"alpha {alpha}", "radius that all sets hold, of the largest circle", inner / radii[-1]),
                   Value(f"alpha {alpha}", "share of the circles' disk on circles that are in some sets and not in others", open_part),
                   Value(f"alpha {alpha}", "CPU s", outputs[f"alpha {alpha}"].cpu)]
    return values

# ------------------------------------------------------------------------------------------------ Sweeps

SWEEPS = {"alpha": ("--alpha {} --beta 0", (10, 20, 40, 80, 160, 320), 40),
          "beta": ("--alpha 40 --beta {}", (-0.04, -0.02, 0, 0.02, 0.04), 0),
          "origin shift": ("--alpha 40 --origin-shift {},0,0", (0, 0.02, 0.05, 0.1), 0)}


def sweep_steps(size):
    n, coarse = size.pick(32, 150, 300), size.pick(" --sdf-resolution 40", "", "")
    return [Step(f"{name} {x}", f"juliavdb fractal $bunny {options.format(x)} --texture-roots 10 --texture-integer{coarse} "
                                f"--resolution {n} -o fractal.vdb --mesh fractal.ply")
            for name, (options, places, _) in SWEEPS.items() for x in places]


def sweep(outputs, size):
    values = []
    for name, (_, places, _) in SWEEPS.items():
        for x in places:
            output = outputs[f"{name} {x}"]
            values += [Value(f"{name} {x}", "triangles", int(output.counts["triangles"])),
                       Value(f"{name} {x}", "% of the target's volume", output.number("the set holds")),
                       Value(f"{name} {x}", "nodes that are evaluated", int(output.counts["evaluatedNodes"]), SAYS.get(f"{name} {x}"))]
    return values


# What the paper says of the sweeps, beside the first row of each.
SAYS = {"alpha 10": "larger alpha: a thinner shell", "beta -0.04": "larger beta: a shell further out",
        "origin shift 0": "a shift erodes the set"}

# ------------------------------------------------------------------------------------------------ Figures

PUBLISHED = {
    "sk23-2": ("Fig. 2", "a fitted set, the modulus and the versor on a plane"),
    "sk23-3": ("Fig. 3", "where the first step leads"),
    "sk23-4": ("Fig. 4", "where a fit fails and the shape modulus does not"),
    "sk23-5": ("Fig. 5", "a bunny eroded by a shifted origin"),
    "sk23-6": ("Fig. 6", "a chair at three alphas and betas, from two sides"),
    "sk23-7": ("Fig. 7", "a dragon that is rough on one side"),
    "sk23-8": ("Fig. 8", "the average of 1000 sets, and the distance over circles"),
    "sk23-9": ("Fig. 9", "rings of the set and of the versor"),
    "sk23-10": ("Fig. 10", "the target, the versor on it, the set"),
    "sk23-11": ("Fig. 11", "one versor on two shapes"),
    "sk23-12": ("Fig. 12", "one shape with four versors"),
    "sk23-13": ("Fig. 13", "a bunny with detail on its body alone"),
}

ENTRIES = [
    Entry("sk23-table-1", "SK23", "Table 1", "what each method has to find", table_1_steps, table_1, ("bunny",), (),
          "The table of the paper compares formulas and the numbers that have to be found for them; some 300 roots, "
          "their powers and three more on the one side (331 roots for the bunny of [Kim15]), alpha and beta on the "
          "other. The 55.1 s are the paper's for bunnies like those of its Fig. 12, at a resolution that it does not "
          "state."),
    Entry("sk23-table-2", "SK23", "Table 2", "six examples on a lattice of 1600^3", table_2_steps, table_2,
          ("dragon", "armadillo", "chair", "hand", "bunny"), (),
          "The paper states neither the unit of alpha and beta, nor the width of its lattice and the powers of its roots. Here "
          "the longest side of a shape is 1, and has the number of voxels; at alpha 6 and 10 little is then left of the "
          "target. At the medium size the lattice is 400 and not 1600, so neither triangles nor times can be compared. Rows "
          "of the paper that are averages over the frames of an animation are one frame here. The chair has other alphas and "
          "betas than theirs, 1 to 4 and 1 to 2, which mean nothing in our unit. Times include reading the mesh and its "
          "distances; crumbs are kept."),
    Entry("sk23-average", "SK23", "Fig. 8", "the average of many sets", average_steps, average, ("bunny",), (),
          "The paper does not say at which alpha its figure was made."),
    Entry("sk23-sweeps", "SK23", "Section 3.2", "alpha, beta and the origin", sweep_steps, sweep, ("bunny",), (),
          "The paper has no numbers of these, but says in which direction each goes."),
    gallery("sk23-figures", "SK23", list(PUBLISHED), ["sk23-3"], PUBLISHED,
            "The pictures are those of docs/gallery.md, beside the commands of each. Fig. 1 has meshes and textures "
            "that the paper does not state; its place is taken by the first picture of the README."),
]
