# SPDX-License-Identifier: Apache-2.0
"""What each part of the method does, and what the choices of its numbers do. Nobody has published these."""
from harness import Entry, Step, Value

from .parts import dimension, dimension_values, growth

COARSE = " --sdf-resolution 40"


def coarse(size):
    return size.pick(COARSE, "", "")


def decided_steps(size):
    alphas = size.pick((40,), (10, 40, 100), (10, 40, 100))
    return [Step(f"alpha {alpha}", f"reproduce/tools/decided $bunny --alpha {alpha} --points {size.pick(2000, 40000, 1000000)} "
                                   f"--steps {size.pick(4, 8, 10)} --resolution {size.pick(40, 100, 200)}") for alpha in alphas]


def decided(outputs, size):
    values = []
    for name, output in outputs.items():
        rows = output.json()
        for row in rows:
            values += [Value(f"{name}, step {row['step']}", "% escaped", 100 * row["escaped"]),
                       Value(f"{name}, step {row['step']}", "% on their last side", 100 * row["settled"]),
                       Value(f"{name}, step {row['step']}", "% inside", 100 * row["inside"])]
        # An orbit takes another step if it has not escaped.
        steps = 1 + sum(1 - row["escaped"] for row in rows[:-1])
        values.append(Value(f"{name}, mean steps to the escape or the last", "steps", steps))
    return values


DIMENSIONS = {
    "power": ("--texture-powers {}:{} --texture-roots 10 --texture-integer", (2, 4, 8, 16, 32)),
    "roots": ("--texture-powers 2:6 --texture-roots {} --texture-integer", (3, 10, 30, 100)),
    "iterations": ("--texture-roots 10 --texture-integer --iterations {}", (1, 2, 3, 5, 8, 12)),
    "detail": ("--detail {}", (0.1, 0.3, 0.5, 0.8)),
}


def dimension_steps(size):
    steps = []
    for name, (options, places) in DIMENSIONS.items():
        for x in size.pick(places[:2], places, places):
            shell = "" if name == "detail" else "--alpha 20 "
            steps.append(dimension(f"{name} {x}", f"$bunny {shell}{options.format(x, x)}{size.pick(COARSE, ' --sdf-resolution 60', '')}",
                                   growth(size, medium="30,42,60,85", full="80,160,320,640")))
    return steps


def dimension_table(outputs, size):
    values = []
    for name, output in outputs.items():
        rows = output.json()["rows"]
        values += dimension_values(name, output)
        values.append(Value(name, "triangles for each evaluated node, at the largest N", rows[-1]["triangles"] / rows[-1]["evaluatedNodes"]))
    return values


# The phases before the field of the map is evaluated.
BEFORE = ("reading", "sides", "distance field", "local thickness", "exponent", "texture")


def phases(output):
    """CPU seconds of evaluating and meshing, without the target's distances."""
    return sum(phase["cpu"] for phase in output.events[-1]["phases"] if phase["phase"] not in BEFORE)


def proof_steps(size):
    ns = size.pick((32,), (80, 160), (200, 400))
    return [Step(f"N = {n}, {words}", f"juliavdb fractal $bunny --alpha 40 --texture-roots 10 --texture-integer{coarse(size)} --resolution {n}"
                                      f"{option} --mesh mesh.stl\nsha256sum mesh.stl")
            for n in ns for words, option in (("proofs", ""), ("no proofs", " --exhaustive"))]


def proofs(outputs, size):
    values = []
    for name, output in outputs.items():
        n, _, words = name.partition(", ")
        values += [Value(name, "nodes that are evaluated", int(output.counts["evaluatedNodes"])), Value(name, "CPU s of the surface", phases(output)),
                   Value(name, "triangles", int(output.counts["triangles"])),
                   Value(name, "the same file as with proofs", output.stdout == outputs[f"{n}, proofs"].stdout)]
    return values


def stop_steps(size):
    n = size.pick(32, 120, 300)
    return [Step(f"escape {escape}", f"juliavdb fractal $bunny --alpha 40 --texture-roots 10 --texture-integer --iterations 8 "
                                     f"--escape {escape} --exhaustive{coarse(size)} --resolution {n} --mesh /dev/null")
            for escape in ("2", "20", "1e3", "1e6")]


def stops(outputs, size):
    return [value for name, output in outputs.items() for value in (
        Value(name, "CPU s of the surface", phases(output)), Value(name, "triangles", int(output.counts["triangles"])))]


ALPHAS = (10, 20, 40, 80, 160, 320)


def island_steps(size):
    return [Step(f"alpha {alpha}", f"juliavdb fractal $bunny --alpha {alpha} --texture-roots 10 --texture-integer{coarse(size)} "
                                   f"--resolution {size.pick(32, 150, 300)} --crumbs keep -o fractal.vdb")
            for alpha in size.pick(ALPHAS[2:4], ALPHAS, ALPHAS)]


def islands(outputs, size):
    values = []
    for name, output in outputs.items():
        count = int(output.counts["islands"])
        values += [Value(name, "islands", count), Value(name, "% of the target's volume", output.number("the set holds")),
                   Value(name, "% of it in the largest", output.number("largest of which has") if count > 1 else 100.0)]
    return values


ENTRIES = [
    Entry("ablation-steps", "", "steps", "what is decided after each step", decided_steps, decided, ("bunny",), ("python:numpy", "python:juliavdb"),
          "Random points of the box that holds the set. Ten random roots with whole powers, escape radius 20."),
    Entry("ablation-dimension", "", "dimension", "what makes a surface rough", dimension_steps, dimension_table, ("bunny",), (),
          "[KD20] ask which settings give more surface for each voxel. Powers, roots and iterations are those of "
          "random roots at alpha 20; detail is that of the default texture."),
    Entry("ablation-proofs", "", "proofs", "the work that proofs of signs save", proof_steps, proofs, ("bunny",), (),
          "With `--exhaustive` every node is evaluated; the mesh has to be the same. An STL holds no recipe, so the "
          "files can be compared."),
    Entry("ablation-early-stop", "", "early stop", "the escape radius", stop_steps, stops, ("bunny",), (),
          "Every node is evaluated, with 8 iterations. The larger the radius, the later an orbit ends."),
    Entry("ablation-islands", "", "islands", "loose pieces by alpha", island_steps, islands, ("bunny",), (),
          "Crumbs are kept. The default drops them."),
]
