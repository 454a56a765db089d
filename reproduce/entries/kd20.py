# SPDX-License-Identifier: Apache-2.0
"""[KD20] Kim and Duff, A Massive Fractal in Days, Not Years."""
from harness import Entry, Step, Value
from meshes import use

from .parts import dimension, dimension_values, growth

TEXTURES = ("scales", "quills", "woven", "ledges", "fur", "coral", "bark", "thorns", "rings", "shells")
DIMENSION = 2.1868
# Of each shape: top roots, bottom roots, and the sums of their powers.
SHAPES = {"bunny": (178, 153, 251.998, 89.3455), "frog": (194, 170, 59.9387, 33.2539), "tooth": (65, 43, 372.339, 127.73)}


def fit(size, file="bunny.json", alpha=40, shape="bunny"):
    """As rough as `--alpha 40` is: without it the fit is far smoother. It has as many roots as the paper's."""
    roots = sum(SHAPES[shape][:2])
    return (f"juliavdb fit {use(shape)} -o {file} --iterations 1 --places keep --roots {size.pick(16, roots, roots)} "
            f"--resolution {size.pick(25, 97, 97)}" + (f" --alpha {alpha}" if alpha else ""))


def dimension_steps(size):
    n, coarse = growth(size), size.pick(" --sdf-resolution 40", "", "")
    rational = "--map rational --rational bunny.json --iterations 4"
    textures = size.pick(("scales",), TEXTURES, TEXTURES)
    return [Step("the fit", fit(size)), dimension("rational, n = 4", rational, n),
            dimension("plain bunny", f"$bunny --mask 0{coarse}", n),
            *(dimension(name, f"$bunny --texture {name}{coarse}", n) for name in textures)]


def dimension_table(outputs, size):
    values = []
    for name, output in outputs.items():
        if name != "the fit":
            values += dimension_values(name, output, DIMENSION if name.startswith("rational") else None)
    return values


def table_1_steps(size):
    return [Step(f"{shape}, {words}", fit(size, f"{shape}.json", alpha, shape))
            for shape in SHAPES for words, alpha in (("as found", None), ("--alpha 40", 40))]


def table_1(outputs, size):
    values = []
    for name, output in outputs.items():
        ours = (int(output.counts["topRoots"]), int(output.counts["bottomRoots"]), output.number("powers sum to"),
                output.number("powers sum to [-\\d.e+]+ and"))
        for quantity, found, paper in zip(("top roots", "bottom roots", "sum of top powers", "sum of bottom powers"), ours,
                                          SHAPES[name.partition(",")[0]]):
            values.append(Value(name, quantity, found, paper, size.name != "small"))
    return values


# At these thicknesses the powers of our bottom roots, or of our top roots, have about the sum of the paper's: 89 and 252.
PAPER_ALPHAS = {49: "bottom", 113: "top"}
# Of the fit as found, and of those: the options, and the share that the paper has.
NAIVE = {"64 bits": ("", 0.113), "80 bits": (" --type long", 0), "32 bits": (" --type float", "infeasible"),
         "64 bits, with the guard of Eq. 2": (" --guard", 0)}


def figure_3_steps(size):
    naive = f"reproduce/tools/naive {{}}.json --nodes {size.pick(6, 14, 40)}"
    steps = [Step("the fit", fit(size, "bunny.json", None)),
             *(Step(words, naive.format("bunny") + option) for words, (option, _) in NAIVE.items())]
    for alpha, side in PAPER_ALPHAS.items():
        steps += [Step(f"the fit, --alpha {alpha}", fit(size, f"{side}.json", alpha)),
                  *(Step(f"--alpha {alpha}, {words}", naive.format(side) + option) for words, (option, _) in NAIVE.items())]
    return steps + [Step("in logarithms, 32 bits", f"juliavdb fractal --map rational --rational bunny.json --iterations 4 --precision float "
                                                   f"--resolution {size.pick(32, 100, 200)} --grids surface,logmodulus -o bunny.vdb\n"
                                                   "reproduce/tools/finite bunny.vdb logmodulus")]


def figure_3(outputs, size):
    fits = ("", *(f"--alpha {alpha}, " for alpha in PAPER_ALPHAS))
    paper = {fit + words: share for fit in fits for words, (_, share) in NAIVE.items()}
    values = []
    for name, output in outputs.items():
        if output.stdout:
            found = output.json()
            values.append(Value(name, "share of nodes with an infinity or NaN", found["share"], paper.get(name), size.name != "small"))
            if "summed powers" in found:
                values += [Value(name, "sum of top powers", found["summed powers"]["top"], 251.998, False),
                           Value(name, "sum of bottom powers", found["summed powers"]["bottom"], 89.3455, False)]
            if name.endswith("Eq. 2"):
                values.append(Value(name, "share of nodes that the guard stops", found["bailed"] / found["nodes"]))
    return values


# ------------------------------------------------------------------------------------------------ Fig. 3 by resolution

def curve_steps(size):
    nodes = size.pick((5, 6), (8, 12, 16), (10, 14, 20, 28, 40))
    return [Step("the fit", fit(size, "top.json", 113)),
            *(Step(f"{n}^3 nodes", f"reproduce/tools/naive top.json --nodes {n}") for n in nodes)]


def curve(outputs, size):
    values = []
    for name, output in outputs.items():
        if output.stdout:
            found = output.json()
            values += [Value(name, "nodes with an infinity or NaN", found["broken"]),
                       Value(name, "share", found["share"], 0.113, size.name != "small")]
    return values

# ------------------------------------------------------------------------------------------------ Fig. 4

def vertex_steps(size):
    return [Step("the fit", fit(size)),
            *(Step(f"N = {n}", f"reproduce/tools/vertices bunny.json --resolution {n} --iterations 4")
              for n in size.pick((32,), (50, 100), (50, 100, 200)))]


def vertices(outputs, size):
    values = []
    for name, output in outputs.items():
        for way in ("searched", "linear") if output.stdout else ():
            found, case = output.json()[way], f"{name}, {way}"
            values += [Value(case, "% of the vertices within 5 % of an end of their edge", 100 * found["near ends"],
                             "snap to centres or edges" if way == "linear" else None),
                       Value(case, "% within 5 % of its middle", 100 * found["near the middle"])]
            if way == "linear":
                values += [Value(case, "from the searched vertex, in edges, median", found["off"]),
                           Value(case, "the same, quantile 0.95", found["off 95"])]
    return values

# ------------------------------------------------------------------------------------------------ Section 3.3: other guards

# At these thicknesses the powers of the tooth's bottom roots, or of its top roots, have about the sum of the paper's.
TOOTH_ALPHAS = {200: "bottom", 392: "top"}
# The options of the guard, and whether the paper has infinities with it.
GUARDS = {"no guard": ("", "yes"), "the guard of Eq. 2": (" --guard", "none"),
          "the sum of the bunny": (" --guard --guard-sum 89.3455", "yes"),
          "the sum of the frog": (" --guard --guard-sum 33.2539", "yes"),
          "the sum 0": (" --guard --guard-sum 0", None), "the factor 1.01": (" --guard --guard-factor 1.01", "yes"),
          "the factor 2": (" --guard --guard-factor 2", "none")}


def guard_steps(size):
    steps = []
    for alpha, side in TOOTH_ALPHAS.items():
        steps += [Step(f"the fit, --alpha {alpha}", fit(size, f"{side}.json", alpha, "tooth")),
                  *(Step(f"--alpha {alpha}, {words}", f"reproduce/tools/naive {side}.json --nodes {size.pick(6, 14, 24)}{option}")
                    for words, (option, _) in GUARDS.items())]
    return steps


def guards(outputs, size):
    values = []
    for name, output in outputs.items():
        if output.stdout:
            found, paper = output.json(), GUARDS[name.partition(", ")[2]][1]
            values += [Value(name, "share of nodes with an infinity or NaN", found["share"], paper),
                       Value(name, "share of nodes that the guard stops", found["bailed"] / found["nodes"])]
    return values

# ------------------------------------------------------------------------------------------------ Section 6: copies

# At --alpha 40 the set of three steps has lost its ears.
COPIES_ALPHA = 100
COPIES = ("whole", "first", "second")


def copies_steps(size):
    n, voxels, pixels = size.pick((3, 16, 40), (4, 160, 480), (4, 400, 800))
    pictures = "".join(f"juliavdb fractal --map rational --rational copies.json --iterations {n} $(cat {name}.box) --mesh {name}.ply\n"
                       f"juliavdb render {name}.ply -o {i}-{name}.png --material plaster --size {pixels}x{pixels}\n"
                       for i, name in enumerate(COPIES, 1))
    return [Step("the fit", fit(size, "bunny.json", COPIES_ALPHA)),
            Step("the copies", f"reproduce/tools/copies bunny.json -o copies.json --iterations {n} --voxels {voxels}"),
            Step("the pictures", pictures.rstrip())]


def copies(outputs, size):
    values = []
    for name, found in zip(("copy", "copy of the copy"), outputs["the copies"].json()["copies"]):
        values += [Value(name, "times smaller", found["times smaller"], "asks whether there are any"),
                   Value(name, "steps of the set that it is a copy of", found["steps"]),
                   Value(name, "intersection over union with that set", found["intersection over union"]),
                   Value(name, "fourth coordinate of the slice", found["place"][3])]
    return values


def precision_steps(size):
    n = size.pick(40, 200, 400)
    rational = f"--map rational --rational bunny.json --iterations 4 --resolution {n}"
    texture = f"$bunny --alpha 40 --texture-roots 10 --texture-integer --resolution {n}" + size.pick(" --sdf-resolution 40", "", "")
    return [Step("the fit", fit(size))] + [
        Step(f"{name}, {bits}", f"juliavdb fractal {options} --precision {kind} --mesh /dev/null")
        for name, options in (("rational", rational), ("shape modulus", texture))
        for bits, kind in (("32 bits", "float"), ("64 bits", "double"))] + (
        [Step("bench", "juliavdb_precision > precision.txt", ("precision.txt",))] if size.name == "full" else [])


def precision(outputs, size):
    values = []
    for name in ("rational", "shape modulus"):
        single, double = outputs[f"{name}, 32 bits"], outputs[f"{name}, 64 bits"]
        values += [Value(name, "triangles in 32 bits", int(single.counts["triangles"])),
                   Value(name, "triangles in 64 bits", int(double.counts["triangles"])),
                   Value(name, "their ratio", single.counts["triangles"] / double.counts["triangles"], "infeasible in 32 bits"),
                   Value(name, "CPU s in 32 bits", single.cpu), Value(name, "CPU s in 64 bits", double.cpu)]
    for line in outputs["bench"].kept["precision.txt"].splitlines() if "bench" in outputs else []:
        cells = [cell.strip() for cell in line.strip("|\n ").split("|")]
        if cells[0] in ("rational", "shape modulus") and len(cells) == 12:
            values.append(Value(f"{cells[0]}, n = {cells[1]}, roots {cells[2]}, powers {cells[3]}",
                                "flips per million, 32 to 64 bits", float(cells[6])))
            values.append(Value(f"{cells[0]}, n = {cells[1]}, roots {cells[2]}, powers {cells[3]}",
                                "flips per million, 64 to 128 bits", float(cells[10])))
    return values


def scale_steps(size):
    n = size.pick(100, 11500, 11500)
    # A tile of the rough one takes half a minute.
    tiles, sample = size.pick((8, 2), (20000, 8), (20000, 32))
    coarse = size.pick(" --sdf-resolution 40", "", "")
    rough = "--alpha 12 --beta 0.05 --iterations 8 --texture random"
    return [Step(name, f"juliavdb plan tiles $bunny -o {folder} --resolution {n} {options}--tiles {tiles} --make ply --estimate "
                       f"--sample {sample}{coarse}\nrm -r {folder}")
            for name, folder, options in (("default options", "plain", ""), ("rough: " + rough, "rough", rough + " "))]


def scale(outputs, size):
    values, same = [], size.name != "small"
    for name, output in outputs.items():
        counts = output.events[0]["counts"]
        found, low, high = (counts[f"estimatedTriangles{end}"] / 1e6 for end in ("", "Low", "High"))
        values.append(Value(name, "million triangles", found, 10483.747635, same))
        # Few tiles may happen to fit the estimator exactly, which says nothing of the others.
        if high - low > 1e-6 * found:
            values += [Value(name, "from, million", low), Value(name, "to, million", high)]
        values += [Value(name, "CPU hours", counts["estimatedCpuSeconds"] / 3600, "17 days on a GPU, 10 years on 12 cores"),
                   Value(name, "GiB on the disk", counts["estimatedDiskBytes"] / 2**30, 676, False)]
    return values


ENTRIES = [
    Entry("kd20-table-1", "KD20", "Table 1", "roots and summed powers", table_1_steps, table_1, ("bunny", "frog", "tooth"), (),
          "The paper has the maps of [Kim15]; ours are other fits, of the same bunny and of substitutes for the frog and the "
          "tooth."),
    Entry("kd20-dimension", "KD20", "Section 6", "the dimension of the surface", dimension_steps, dimension_table, ("bunny",), (),
          "The paper does not say over which resolutions it measured. The plain bunny is smooth and shows how near to 2 "
          "these resolutions come. The rows below it are shape moduli with the textures of the shelf, which the paper does not "
          "have."),
    Entry("kd20-figure-3", "KD20", "Fig. 3", "infinities and NaN of the products", figure_3_steps, figure_3, ("bunny",), ("python:pyopenvdb",),
          "The map is iterated four times by ordered products, in a space in which the longest side is 8: the released "
          "program scales a shape to a radius of 4. `--alpha` scales all powers of a fit; at 49 those of the bottom roots sum "
          "to the paper's sum, and at 113 those of the top roots. The last row is the program itself, which adds logarithms."),
    Entry("kd20-figure-3-curve", "KD20", "Fig. 3", "infinities and NaN by the resolution", curve_steps, curve, ("bunny",),
          ("python:numpy",),
          "64 bits, as in the entry above, with the fit whose top powers have the paper's sum. In the paper the share stays at "
          "11.3 % on all lattices."),
    Entry("kd20-figure-4", "KD20", "Fig. 4", "vertices by a line and by a search", vertex_steps, vertices, ("bunny",),
          ("python:numpy", "python:juliavdb"),
          "The vertices of the program are searched along the edges. Beside them are those where a line between the values ln |q| "
          "at the ends of the edge is 0. Of vertices that lie evenly on their edges 10 % are within 5 % of an end, and 10 % within "
          "5 % of the middle."),
    Entry("kd20-guard", "KD20", "Section 3.3", "the guard with another sum and other factors", guard_steps, guards, ("tooth",),
          ("python:numpy",),
          "The paper puts the summed bottom powers of the bunny and of the frog into the guard of the tooth, and 1.01 and 2 in the "
          "place of 1.05. Ours are fits of another tooth, with the paper's sum of bottom powers (`--alpha 200`) or of top powers "
          "(`--alpha 392`). [replication.md](replication.md#kd20-any-sum-is-enough-for-the-guard) says why none of them leaves an "
          "infinity."),
    Entry("kd20-copies", "KD20", "Section 6", "copies of the whole bunny", copies_steps, copies, ("bunny",), ("python:numpy", "python:juliavdb"),
          "The paper asks whether the fractal contains copies of the whole bunny. A fitted map has them as soon as it has a simple "
          "root outside the shape at a place where the other factors multiply to a positive real number: "
          "[replication.md](replication.md#kd20-copies-of-the-whole-bunny). The pictures are the set, its copy, and the copy of the copy, each of which fills the picture."),
    Entry("kd20-precision", "KD20", "Section 3.3", "32 bits against 64, and against 128", precision_steps, precision, ("bunny",),
          lambda size: size.pick((), (), ("program:juliavdb_precision",)),
          "At the full size the benchmark of docs/precision.md compares all of them with 128 bits; that page has its numbers."),
    Entry("kd20-scale", "KD20", "Section 5.1", "ten billion triangles", scale_steps, scale, ("bunny",), (),
          "Estimates from a sample of the tiles, with 95 % intervals where the sample gives one; at the medium size it is 8 of "
          "20 000 tiles. Our default surface is smoother than theirs; the second row is a rougher one. "
          "[scale.md](scale.md#ten-billion-triangles) has a third recipe, by which `reproduce/run kd20-ten-billion` makes more "
          "than ten billion triangles."),
]
