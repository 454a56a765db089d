# SPDX-License-Identifier: Apache-2.0
"""What a measured dimension is worth: sets whose dimension is known, the spread over seeds, and the dimension by place."""
import statistics

from harness import Entry, Step, Value

from .parts import dimension

# ------------------------------------------------------------------------------------------------ Sets of known dimension

# Of the Julia sets of the plane: [McM98]. A set of a real constant is turned about the real axis, which adds 1.
BASILICA, RABBIT = 1.26835, 1.3934
RABBIT_C = "-0.12256116687665362+0.7448617666197442j"
# The size of the voxels at N = 800.
SPHERE_VOXEL, JULIA_VOXEL = 0.0025, 0.004
STEPS = (5, 10, 20, 60)  # after which q^2 - 1 is measured
LINES = {"basilica x line": ("-1", 1 + BASILICA), "rabbit x line": (RABBIT_C, 1 + RABBIT)}


def known(size):
    """Of each set: the options that make it, its dimension, and the size of the voxels for its boxes."""
    turned = "--map quadratic --c={},0,0,0 --iterations {}"
    steps = size.pick((5, 20), STEPS, STEPS)
    return {"sphere, a mesh": ("sphere.obj --mask 0" + size.pick(" --sdf-resolution 40", "", ""), 2, SPHERE_VOXEL),
            "unit ball, q^2 at n = 20": (turned.format(0, 20), 2, SPHERE_VOXEL),
            **{f"q^2 - 1 at n = {n}": (turned.format(-1, n), 1 + BASILICA, JULIA_VOXEL) for n in steps}}


def known_steps(size):
    n = size.pick("24,32,40,48", "50,100,200,400", "100,200,400,800")
    coarser = size.pick(16, 2, 1)
    steps = [Step("a sphere", "reproduce/shapes sphere" + size.pick(" --coarse", "", "") + " > sphere.obj")]
    for name, (options, _, voxel) in known(size).items():
        steps += [dimension(name, options, n),
                  Step(f"{name}, boxes", f"juliavdb fractal {options} --voxel-size {coarser * voxel} --mesh mesh.ply\n"
                                         f"reproduce/tools/dimension boxes mesh.ply --voxel {coarser * voxel}")]
    for name, (c, _) in LINES.items():
        steps.append(Step(name, f"reproduce/tools/dimension line --c={c} --iterations {size.pick(10, 60, 60)} "
                                f"--dimension {size.pick('50,100,150', '50,100,200', '100,200,400')} "
                                f"--plane {size.pick('50,100,200', '100,200,400,800', '100,200,400,800,1600,3200')}"))
    return steps


def beside(case, way, found, error, true):
    return [Value(case, f"by {way}", found), Value(case, f"standard error, {way}", error),
            Value(case, f"deviation, {way}", found - true)]


def known_table(outputs, size):
    values = []
    for name, (_, true, _) in known(size).items():
        law, boxes = outputs[name].json(), outputs[f"{name}, boxes"].json()
        values += [Value(name, "known dimension", true), *beside(name, "triangles", law["dimension"], law["standardError"], true),
                   *beside(name, "boxes", boxes["dimension"], boxes["standardError"], true)]
    for name, (_, true) in LINES.items():
        found = outputs[name].json()
        values += [Value(name, "known dimension", true),
                   *beside(name, "triangles", found["dimension"], found["standardError"], true),
                   *beside(name, "edges of the plane section", found["plane"]["dimension"], found["plane"]["standardError"], true)]
    return values

# ------------------------------------------------------------------------------------------------ Seeds

TEXTURES = {"ten random roots, alpha 20": "--alpha 20 --texture-roots 10 --texture-integer", "scales": "--texture scales"}


def seeds(size):
    return range(1, 1 + size.pick(3, 8, 8))


def seed_steps(size):
    coarse = size.pick(" --sdf-resolution 40", "", "")
    return [dimension(f"{name}, seed {seed}", f"$bunny {options} --texture-seed {seed}{coarse}",
                      size.pick("24,32,40,48", "40,80,160", "80,160,320"))
            for name, options in TEXTURES.items() for seed in seeds(size)]


def seed_table(outputs, size):
    values = []
    for name in TEXTURES:
        laws = [outputs[f"{name}, seed {seed}"].json() for seed in seeds(size)]
        found = [law["dimension"] for law in laws]
        spread = statistics.stdev(found)
        values += [Value(name, "seeds", len(found)), Value(name, "dimension, mean", statistics.mean(found)),
                   Value(name, "standard error of the mean", spread / len(found)**0.5), Value(name, "least", min(found)),
                   Value(name, "greatest", max(found)), Value(name, "standard deviation over seeds", spread),
                   Value(name, "standard error of one seed, mean", statistics.mean(law["standardError"] for law in laws))]
    return values

# ------------------------------------------------------------------------------------------------ A map

WAYS = {"plain, --mask 0": "--mask 0", "--detail x:0.02:0.8:smooth": "--detail x:0.02:0.8:smooth"}


def map_steps(size):
    n, coarse = size.pick(100, 200, 600), size.pick(" --sdf-resolution 40", "", "")
    # The longest side of the bunny of glmark2-data, and of the coarse one, is 2 to within 1 %.
    return [Step(name, f"juliavdb fractal $bunny {options}{coarse} --voxel-size {2 / n:.6f} --mesh mesh.ply\n"
                       f"reproduce/tools/dimension local mesh.ply --voxel {2 / n:.6f} --shifts 4 -o {i}-map.png")
            for i, (name, options) in enumerate(WAYS.items(), 1)]


def map_table(outputs, size):
    values = []
    for name, output in outputs.items():
        found = output.json()
        values += [Value(name, "blocks", found["blocks"]),
                   *(Value(name, f"quantile {p}", found["quantiles"][p]) for p in ("0.05", "0.5", "0.95")),
                   Value(name, "median of the third at low x", found["low x"]),
                   Value(name, "median of the third at high x", found["high x"])]
    return values


ENTRIES = [
    Entry("dimension-known", "", "known dimensions", "sets whose dimension is known", known_steps, known_table, (),
          ("python:numpy", "python:juliavdb"),
          "The dimensions of the Julia sets of the plane are those of [McM98]: 1.26835 for the basilica, z^2 - 1, and 1.3934 for "
          "Douady's rabbit. The quaternion set of a real constant is the one of the plane turned about the real axis, and a "
          "product with a line is made by a map of our own; either adds 1. Triangles are those of 'study --dimension'; boxes are "
          "of 1 to 8 voxels at the finest of these N. Lines have 60 steps, and the plane section of their slabs goes further, "
          "to N = 3200 at the full size. [scale.md](scale.md#what-a-measured-dimension-is-worth) says what follows."),
    Entry("dimension-seeds", "", "dimension by seed", "how far one texture says what its kind has", seed_steps, seed_table,
          ("bunny",), (),
          "The seed varies the random roots, or the phases of the waves of `scales`. All other options stay."),
    Entry("dimension-map", "", "dimension by place", "boxes in each block of a surface", map_steps, map_table, ("bunny",),
          ("python:numpy",),
          "Boxes of 1, 2, 4 and 8 voxels are counted in each block of 32 voxels. In the second row the depth of the detail grows "
          "along x. In the pictures blue is 2 and red is 2.4 or more."),
]
