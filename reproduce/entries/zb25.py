# SPDX-License-Identifier: Apache-2.0
"""[ZB25] Zimmermann and Bruckner, Reformulating Multiplication for Mandelbrot-like Sets in 3D."""
from harness import Entry, Step, Value

from .parts import gallery

PUBLISHED = {
    "zb25-1": ("Fig. 1a", "the Mandelbrot set of the plane"),
    "zb25-2": ("Fig. 2", "the triplex square, with plus and minus in z"),
    "zb25-3": ("Fig. 3", "sets that fill space"),
    "zb25-4": ("Fig. 4", "C and D as Mandelbrot sets"),
    "zb25-5": ("Fig. 5", "balls and flats, c = (-1, 0, 0)"),
    "zb25-6": ("Fig. 6", "tunnels, c = (0.39, 0.2, 0)"),
    "zb25-7": ("Fig. 7", "four more Julia sets"),
}

# The functions of the paper, and others of the same kinds.
F = ("1, 1, 1", "x*x, y*y, z*z", "x*x*y, y*y, z*z", "y*z, z*x, x*y", "x*x-y*y, 2*x*y, z*z", "r*x, r*y, r*z")
G = ("cos(x), cos(y), cos(z)", "1, cos(z), 1", "0, 0, 1", "y, z, x", "sin(y), sin(z), sin(x)", "1, x, y*z")


def pairs(size):
    return size.pick((F[:2], G[:2]), (F, G), (F, G))


def sweep_steps(size):
    f, g = pairs(size)
    view = size.pick("--size 40x40 --samples 1 --iterations 10", "--size 64x64 --samples 1 --iterations 30",
                     "--size 160x160 --iterations 50")
    listed = [" ".join(f'"{x}"' for x in functions) for functions in (f, g)]
    # A number of two digits puts the pictures into their order.
    return [Step("the pictures", f"mkdir cells\ni=10\nfor f in {listed[0]}; do\n  for g in {listed[1]}; do\n"
                                 f"    juliavdb render --field --map cross --scheme 4 --radius 4 --f \"$f\" --g \"$g\" --background \"#ffffff\" {view} "
                                 "-o cells/$i.png\n    i=$((i + 1))\n  done\ndone"),
            Step("the classes", f"reproduce/tools/classes -o classes.png --most {size.pick(2, 8, 8)} cells/*.png")]


def sweep(outputs, size):
    f, g = pairs(size)
    names = [f"f = ({a}), g = ({b})" for a in f for b in g]
    found = outputs["the classes"].json()
    values = [Value("all", "pairs", len(names), "a search is suggested, and not made"), Value("all", "pairs that show nothing", len(found["empty"]))]
    for i, members in enumerate(found["classes"], 1):
        values += [Value(f"class {i}", "pairs", len(members)), Value(f"class {i}", "in the middle of it", names[members[0]])]
    return values


# ------------------------------------------------------------------------------------------------ Fig. 7d: the rings that thin out

# The third coordinate of c, and the paper's words.
THINNER = {0.31: "the rings of Fig. 7d", 0.32: None, 0.33: None, 0.34: None, 0.345: None, 0.346: None, 0.347: None, 0.3475: None,
           0.3477: None, 0.348: "gone at the latest"}


def thinner_steps(size):
    constants = size.pick((0.31, 0.345, 0.348), THINNER, THINNER)
    return [Step("the points", f"reproduce/tools/triplex share {' '.join(map(str, constants))} "
                               f"--points {size.pick(40000, 400000, 40000000)}")]


def thinner(outputs, size):
    found = outputs["the points"].json()
    values = []
    for row in found["rows"]:
        name = f"c = (0, 0, {row['c']})"
        values += [Value(name, "points inside", row["inside"], THINNER[row["c"]]), Value(name, "of so many", found["points"]),
                   # Each point stands for a small part of the cube.
                   Value(name, "volume of the set", found["side"]**3 * row["inside"] / found["points"])]
    return values

# ------------------------------------------------------------------------------------------------ The form without trigonometry


WITH_ANGLES = ("numpy, angles", "the program, with angles")


def speed_steps(size):
    return [Step("the square", f"reproduce/tools/triplex speed --points {size.pick(4000, 100000, 1000000)}")]


def speed(outputs, size):
    rows = outputs["the square"].json()["rows"]
    with_angles = {row["way"].partition(",")[0]: row["nanoseconds"] for row in rows if row["way"] in WITH_ANGLES}
    values = []
    for row in rows:
        ratio = with_angles[row["way"].partition(",")[0]] / row["nanoseconds"]
        values += [Value(row["way"], "CPU ns a step", row["nanoseconds"]),
                   Value(row["way"], "times as fast as with angles", ratio,
                         "can improve the performance" if row["way"].endswith("as printed") else None)]
        if "off" in row:
            values.append(Value(row["way"], "largest difference from the square by angles", row["off"]))
    return values


ENTRIES = [
    gallery("zb25-figures", "ZB25", list(PUBLISHED), ["zb25-1", "zb25-7"], PUBLISHED,
            "The pictures are those of docs/gallery.md, beside the commands of each. The other parts of Fig. 1 are drawings."),
    Entry("zb25-classes", "ZB25", "Summary and conclusions", "pairs of functions, clustered by their pictures", sweep_steps, sweep, (),
          ("python:numpy",),
          "The paper suggests to sample and cluster the space of functions. Each row of the picture is a class: pairs"
          " whose pictures are near to each other, by their outlines and greys, under average linkage."),
    Entry("zb25-thinner", "ZB25", "Fig. 7d", "an object that thins out until it is gone", thinner_steps, thinner, (),
          ("python:numpy", "python:juliavdb"),
          "Points of one cube at random, with 100 steps and the radius 2, as in the paper: pair A, scheme 5. The volume is "
          "that of the cube times the share of the points, so a set in which no point lies may still have a smaller one."),
    Entry("zb25-speed", "ZB25", "Reformulation", "the square with and without trigonometric functions", speed_steps, speed, (),
          ("python:numpy", "python:juliavdb"),
          "The paper says that its form can improve the performance of rendering, and has no numbers. In numpy it is compared "
          "with the square by the angles of Eq. 1, on one thread, and with the same form multiplied out, which has one square "
          "root. The program's rows are steps of whole orbits, of the powers 2 and 2.000000001; the second one takes the angles, and a "
          "power of r besides."),
]
