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


ENTRIES = [
    gallery("zb25-figures", "ZB25", list(PUBLISHED), ["zb25-1", "zb25-7"], PUBLISHED,
            "The pictures are those of docs/gallery.md, beside the commands of each. The other parts of Fig. 1 are drawings."),
    Entry("zb25-classes", "ZB25", "Summary and conclusions", "pairs of functions, clustered by their pictures", sweep_steps, sweep, (),
          ("python:numpy",),
          "The paper suggests to sample and cluster the space of functions. Each row of the picture is a class: pairs"
          " whose pictures are near to each other, by their outlines and greys, under average linkage."),
]
