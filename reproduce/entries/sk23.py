# SPDX-License-Identifier: Apache-2.0
"""[SK23] Schor and Kim, A Shape Modulus for Fractal Geometry Generation."""
import dataclasses
import math

from harness import Entry, Step, Value
from meshes import use

from .parts import gallery, hours

# ------------------------------------------------------------------------------------------------ Table 1

def table_1_steps(size):
    return [Step("rational map", f"juliavdb fit $bunny -o map.json --iterations 1 --places keep --roots {size.pick(12, 331, 331)} --resolution {size.pick(25, 97, 97)}"),
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

# How the program that the authors released makes a set (docs/peer-formats.md): its fields have 100 cells, and its own random roots
# have whole powers from 2 to 12. Its origin is the middle of the box.
RELEASED = "--sdf-resolution {} --texture-integer --texture-powers 2:12"


@dataclasses.dataclass(frozen=True)
class Example:
    """A row of Table 2. Its alpha and beta are for distances in the unit of the mesh; those of our options are for a longest side
    of 1, so that alpha is multiplied by the longest side and beta divided by it.

    @param alpha    the paper's, one or two that the set varies between
    @param beta     likewise
    @param side     the longest side in the unit of the mesh, as this run assumes it
    @param ramp     how alpha and beta vary
    @param texture  the options for its roots, and for the origin where the middle of the box lies inside the shape
    @param paper    million triangles, CPU time, time on the clock, and cores"""
    mesh: str
    alpha: tuple
    beta: tuple
    side: float
    ramp: str
    texture: str
    paper: tuple

    def shell(self, side=None):
        """The options for alpha and beta, where the longest side is `side` units of the mesh."""
        side = side or self.side

        def option(name, values):
            words = [f"{value:.6g}" for value in values]
            return f"--{name} " + (words[0] if len(words) == 1 else self.ramp.format(*words))

        words = option("alpha", [alpha * side for alpha in self.alpha])
        return words if self.beta == (0,) else words + " " + option("beta", [beta / side for beta in self.beta])

    def command(self, side, resolution, coarse):
        return (f"juliavdb fractal {use(self.mesh)} {self.shell(side)} {self.texture} {RELEASED.format(coarse)} "
                f"--resolution {resolution} --crumbs keep --mesh /dev/null")


EXAMPLES = {
    "dragon, alpha 10 to 300": Example("dragon", (10, 300), (0,), 16, "x:{}:{}:smooth", "--texture-roots 40",
                                       (26.5, "10:05:03", "1:21:11", 64)),
    "dragon, alpha 10": Example("dragon", (10,), (0,), 16, "", "--texture-roots 40", (53.5, "41:58:28", "2:01:57", 64)),
    "armadillo, alpha 40, beta 0.05": Example("armadillo", (40,), (0.05,), 1, "", "--texture-roots 40 --origin centre",
                                              (160.3, "70:40:48", "4:20:46", 64)),
    "chair, alpha 1 to 4, beta 1 to 2": Example("chair", (1, 4), (1, 2), 110, "y:{}:{}", "--texture-roots 10",
                                                (4.23, "19:41:33", "0:05:37", 512)),
    "hand, alpha 90, beta 0.02": Example("hand", (90,), (0.02,), 1, "", "--texture-roots 40 --origin centre",
                                         (12.7, "17:00:23", "0:05:27", 512)),
    "bunny, alpha 6": Example("bunny", (6,), (0,), 2, "", "--texture-roots 10 --texture-placement cluster --origin centre",
                              (355.8, "62:40:51", "1:01:45", 512)),
}


def table_2_steps(size):
    n = size.pick(32, 400, 1600)
    return [Step(name, example.command(example.side, n, size.pick(40, 100, 100))) for name, example in EXAMPLES.items()]


def table_2(outputs, size):
    same, values = size.name == "full", []
    for name, example in EXAMPLES.items():
        triangles, cpu, clock, cores = example.paper
        values += [Value(name, "longest side in units of the mesh", example.side),
                   Value(name, "triangles", int(outputs[name].counts["triangles"]), round(triangles * 1e6), same),
                   Value(name, "CPU s", outputs[name].cpu, hours(cpu), same),
                   Value(name, "s on the clock", outputs[name].wall, f"{hours(clock)} on {cores} cores"),
                   Value(name, "memory, MiB", round(outputs[name].memory / 2**20)),
                   Value(name, "% of the target's volume", outputs[name].number("the set holds"))]
    return values

# ------------------------------------------------------------------------------------------------ The unit of alpha and beta

# The longest sides, in units of the mesh, at which each example is tried.
SIDES = {"dragon, alpha 10": (1, 4, 16, 64), "armadillo, alpha 40, beta 0.05": (0.5, 1, 2, 4, 151),
         "hand, alpha 90, beta 0.02": (0.5, 1, 2, 4), "bunny, alpha 6": (1, 2, 4, 8)}


def unit_sizes(size):
    return size.pick((16, 32), (50, 100), (100, 200))


def unit_steps(size):
    return [Step(f"{name}, longest side {side:g}, N = {n}", EXAMPLES[name].command(side, n, size.pick(40, 100, 100)))
            for name, sides in SIDES.items() for side in sides for n in unit_sizes(size)]


def unit(outputs, size):
    values, (low, high) = [], unit_sizes(size)
    for name, sides in SIDES.items():
        for side in sides:
            case = f"{name}, longest side {side:g}"
            few, many = (outputs[f"{case}, N = {n}"].counts["triangles"] for n in (low, high))
            dimension = math.log(many / few) / math.log(high / low) if few and many else 0.0
            values += [Value(case, f"triangles at N = {high}", int(many)),
                       Value(case, "exponent of their growth", dimension),
                       Value(case, "million triangles at N = 1600, extrapolated", many * (1600 / high)**dimension / 1e6,
                             EXAMPLES[name].paper[0], size.name == "full"),
                       Value(case, "% of the target's volume", outputs[f"{case}, N = {high}"].number("the set holds"))]
    return values

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

# ------------------------------------------------------------------------------------------------ Fig. 8, in the plane

FLAT = ("star", "trefoil")


def flat_steps(size):
    return [Step(target, f"reproduce/tools/flat {target} -o {target}-1-average.png --curve {target}-2-distance.png "
                         f"--csv {target}.csv --alpha 20 --sets {size.pick(20, 200, 1000)} --pixels {size.pick(20, 60, 120)}",
                 (f"{target}.csv",))
            for target in FLAT]


def flat(outputs, size):
    values = []
    for target in FLAT:
        found, rows = outputs[target].json(), outputs[target].table(f"{target}.csv")
        undecided = [row["mean"] for row in rows if 0 < row["membership"] < 1]
        values += [Value(target, "sets", found["sets"], 1000, size.name == "full"),
                   Value(target, "least phi of a pixel that some set leaves out", found["leastPhiLeftOut"],
                         "small phi: all sets hold it"),
                   Value(target, "greatest phi of a pixel that some set holds", found["greatestPhiHeld"], "large phi: no set does"),
                   Value(target, "% of the pixels of which sets differ", 100 * found["undecided"]),
                   Value(target, "mean phi on circles of which sets differ, least", min(undecided)),
                   Value(target, "and greatest", max(undecided)),
                   Value(target, "largest difference from reproduce/reference_maps.py", found["offReference"])]
    return values

# ------------------------------------------------------------------------------------------------ Fig. 4

# Of each shape: alpha where the longest side is 1, and the paper's seconds of the set and hours of the fit that failed.
FAILED = {"armadillo": (40, 2.9, 4.5), "dragon": (160, 5.1, 3.5)}


def failed_steps(size):
    schedule, roots = size.pick("25(VF)", "25(VFRF)", "25(VFRF)"), size.pick("12 --resolution 25", "300", "300")
    return [step for shape, (alpha, *_) in FAILED.items() for step in (
        Step(f"{shape}, fit", f'juliavdb fit {use(shape)} -o {shape}.json --schedule "{schedule}" --weights layers '
                              f'--roots {roots}'),
        Step(f"{shape}, shape modulus", f"juliavdb fractal {use(shape)} --alpha {alpha} --texture-roots 40 {RELEASED.format(100)} "
                                        f"--resolution {size.pick(40, 100, 100)} --mesh {shape}.ply"))]


def failed(outputs, size):
    values = []
    for shape, (_, seconds, hours_of_fit) in FAILED.items():
        fit, fractal = outputs[f"{shape}, fit"], outputs[f"{shape}, shape modulus"]
        values += [Value(shape, "CPU s of the fit", fit.cpu, 3600 * hours_of_fit, False),
                   Value(shape, "% of the union of fit and target that both hold", 100 * fit.counts["iou"]),
                   Value(shape, "after 4 iterations", 100 * fit.counts["iteratedIou"], "failed"),
                   Value(shape, "CPU s of the set with the shape modulus", fractal.cpu, seconds, False),
                   Value(shape, "% of the target's volume", fractal.number("the set holds"), "succeeded"),
                   Value(shape, "the fit's time over the set's", fit.cpu / fractal.cpu, 3600 * hours_of_fit / seconds, False)]
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
          "The program that the authors released measures phi in the unit of the mesh, but scales positions, so that the box of "
          "the mesh becomes a cube of the side 1. An alpha of the paper therefore stands for one unit of a mesh that is not "
          "available. In our unit, in which the longest side is 1, it has to be multiplied by the longest side of the mesh, and "
          "beta divided by it. The table has the longest side that each row assumes. Our file of the bunny has 2, and our chair "
          "has 110 if it is 1.1 m high and the unit is a centimetre. The paper's chair is another, so its row cannot match. The "
          "armadillo and the hand have 1, and the dragon 16, because at 4 only a tenth of it is left. These are choices among "
          "the sides of the entry sk23-unit, so a ratio near 1 shows that such a unit exists, and not that it was the paper's. "
          "It is not the unit of our files of the dragon and the armadillo, whose longest sides are 0.2 and 151. Distances have "
          "100 cells, as the names of the fields that come with the released program have it. As in that program, roots have "
          "whole powers from 2 to 12, and the origin is the middle of the box, except for the chair, where that lies outside, "
          "and the dragon, where it lies just below the surface; their origin is the centre of the largest ball inside. The "
          "roots of the bunny lie close together. The paper says so of the second shape of its Fig. 1, which we take to be the "
          "bunny. The longest side has 1600 voxels. At the medium size it has 400, so neither triangles nor times can be "
          "compared. Rows of the paper that are averages over the frames of an animation are one frame here. Times include "
          "reading the mesh and its distances; crumbs are kept."),
    Entry("sk23-unit", "SK23", "Table 2, alpha", "the longest side of the mesh in its unit", unit_steps, unit,
          ("dragon", "armadillo", "hand", "bunny"), (),
          "Rows of Table 2 whose alpha does not vary, for several longest sides of the mesh, as the entry sk23-table-2 explains "
          "them. The number of triangles at 1600 is extrapolated from the growth between two smaller lattices. It is nearest to "
          "the paper's where the longest side is 4 for the dragon, 1 for the armadillo, between 2 and 4 for the hand, and 2 for "
          "the bunny, so no one unit suits all. It also depends on the versor, of which the paper states little."),
    Entry("sk23-figure-4", "SK23", "Fig. 4", "where a fit fails", failed_steps, failed, ("armadillo", "dragon"), (),
          "The paper's fits failed after 4.5 and 3.5 hours, and its sets took 2.9 and 5.1 s; from these it has the ratios 5600 "
          "and 2500. It does not state the passes of the fits, nor the lattice of the sets. Our fits have the coarsest passes "
          "of [Kim15] alone, VFRF with 25^3 cells, and our sets have 100 voxels, so neither the times nor their ratios can be "
          "compared. Our fits fail as the paper's do: after 4 iterations almost nothing is left in common with the target."),
    Entry("sk23-average", "SK23", "Fig. 8", "the average of many sets", average_steps, average, ("bunny",), (),
          "The paper does not say at which alpha its figure was made. This is a plane of sets in space; the entry sk23-figure-8 is "
          "in two dimensions, as the paper's figure is."),
    Entry("sk23-figure-8", "SK23", "Fig. 8", "the average of many sets in the plane, for two targets", flat_steps, flat, (),
          ("python:numpy",),
          "The outlines are ours, because the paper does not name its two targets; nor does it state alpha and the versors. "
          "They have a longest side of 1, and the sets are computed by a script of their own in numpy."),
    Entry("sk23-sweeps", "SK23", "Section 3.2", "alpha, beta and the origin", sweep_steps, sweep, ("bunny",), (),
          "The paper has no numbers of these, but says in which direction each goes."),
    gallery("sk23-figures", "SK23", list(PUBLISHED), ["sk23-3"], PUBLISHED,
            "The pictures are those of docs/gallery.md, beside the commands of each. Fig. 1 shows an armadillo, a bunny, a dragon "
            "and a hand with the alphas and betas of Table 2. Their versors are not stated, except that the roots of the second "
            "shape lie close together. The first picture of the README takes its place."),
]
