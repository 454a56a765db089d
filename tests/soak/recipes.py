# SPDX-License-Identifier: Apache-2.0
"""Random recipes from the program's own list of options.

An option that is new is drawn as its placeholder in the help suggests (N, X,Y,Z, a|b|c, none for a flag), so it takes part from
its first day. VALUES has the options for which something more apt is known.
"""

import dataclasses
import pathlib
import random
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "explore"))
import harness  # noqa: E402
import server  # noqa: E402

# Set for every recipe, given as the input, or varied by the laws themselves.
NOT_DRAWN = {"input", "map", "resolution", "voxel-size", "sdf-resolution", "sdf-voxel-size", "exhaustive"}
FORMATS = (".ply",) * 5 + (".obj", ".stl", ".glb")
VDB_SHARE = 0.6  # of the recipes write a VDB beside the mesh


@dataclasses.dataclass(frozen=True)
class Recipe:
    """What a run is told."""
    target: str | None
    options: tuple  # of pairs (name, value); the value of a flag is None
    mesh: str | None  # the extension of the mesh, if there is one
    vdb: bool

    def words(self, without=()):
        words = [self.target] if self.target else []
        for name, value in self.options:
            if name not in without:
                words.append(f"--{name}" if value is None else f"--{name}={value}")
        return words

    def without(self, name):
        return dataclasses.replace(self, options=tuple(o for o in self.options if o[0] != name))

    def value(self, name, otherwise=None):
        return dict(self.options).get(name, otherwise)

    def has(self, name):
        return any(name == other for other, _ in self.options)


def registry(folder):
    """The program's maps, options and textures, as it tells them to the page of `juliavdb explore`."""
    with server.Server(folder, "ball.obj", *server.QUICK) as running:
        return running.get("start")[1]


class Draw:
    """One recipe's chances, and what its values depend on."""

    def __init__(self, seed, known, targets):
        self.chance = random.Random(seed)
        self.known = known
        self.targets = targets

    # ------------------------------------------------------------------------------------------------------- numbers

    def number(self, low, high, digits=4):
        return f"{self.chance.uniform(low, high):.{digits}g}"

    def power_of_ten(self, low, high):
        return f"{10 ** self.chance.uniform(low, high):.4g}"

    def vector(self, spread, about=(0, 0, 0)):
        return ",".join(f"{self.chance.gauss(c, spread):.7g}" for c in about)

    def some(self, names, most=None, separator=","):
        names = list(names)
        return separator.join(self.chance.sample(names, self.chance.randint(1, min(most or len(names), len(names)))))

    # -------------------------------------------------------------------------------------------------------- sources

    def control(self, low, high):
        """A control whose values lie from low to high."""
        chance, target = self.chance, self.target
        a, b = (self.number(low, high) for _ in range(2))
        kinds = ["number"] * 5 + ["ramp"] * 3 + ["near", "expr", "expr", "paint@"]
        kinds += ["paint"] * 4 if target and target.attributes else []
        kinds += ["texture"] * 4 if target and target.uv else []
        kind = chance.choice(kinds)
        if kind == "ramp":
            ends = sorted(chance.uniform(0, 1) for _ in range(2))
            at = [f"@{t:.2f}" for t in ends] if chance.random() < 0.4 else ["", ""]
            return f"{chance.choice('xyz')}:{a}{at[0]}:{b}{at[1]}{chance.choice(['', ':smooth'])}"
        if kind == "near":
            return f"near:brush.obj:{self.number(0.05, 0.6)}:{a}:{b}"
        if kind == "paint":
            return f"paint:{chance.choice(target.attributes)}:{a}:{b}"
        if kind == "paint@":
            return f"paint:red@painted.ply:{a}:{b}"
        if kind == "texture":
            return f"texture:checks.png:{chance.choice(['', 'r:', 'luminance:'])}{a}:{b}"
        if kind == "expr":
            share = chance.choice(["height", "hx", "hz * height", "ny > 0.3 ? 1 : 0", "(1 + sin(20*x))/2", "abs(nz)",
                                   "min(1, 2*tau)", "1/(1 + curvature^2)", "exp(-abs(phi)*9)"])
            return f"expr:{low:g} + {high - low:g} * ({share})"
        return a

    def transferred(self):
        names = (("uv",) if self.target and self.target.uv else ()) + (
            ("Cd", *self.target.attributes) if self.target and self.target.attributes else ())
        return self.some(names or ("uv", "Cd"), 2)

    def colour(self):
        what = self.chance.choice(self.known["colours"])
        if what in ("trap", "iterations", "depth") and self.chance.random() < 0.6:
            what += ":" + self.chance.choice([*self.known["gradients"], "checks.png"])
        return what

    def box(self):
        low, high = (self.target.low, self.target.high) if self.target else ((-1.5, ) * 3, (1.5, ) * 3)
        corners = []
        for l, h in zip(low, high):
            ends = sorted(self.chance.uniform(l - 0.2 * (h - l), h + 0.2 * (h - l)) for _ in range(2))
            corners.append((ends[0], max(ends[1], ends[0] + 0.3 * (h - l))))
        return ",".join(f"{c[end]:.9g}" for end in (0, 1) for c in corners)

    def levels(self):
        return ",".join(["100%"] + [f"{s}%" for s in sorted(self.chance.sample(range(5, 80, 5), 2), reverse=True)])

    def function(self):
        """Three components of a user's function; now and then one that is odd, even or the same in all axes."""
        pieces = ["{0}*{0}", "{0}*{0} - {1}*{1}", "2*{0}*{1}", "cos({0})", "sin({1})*{0}", "{0}^3 - {1}", "exp(-{2}*{2})",
                  "abs({0})", "{0}*{1}*{2}", "sqrt({0}*{0} + {1}*{1})", "{0}/(1 + {1}*{1})", "1", "atan2({0}, {1})"]
        axes = ("x", "y", "z"), ("y", "z", "x"), ("z", "x", "y")
        same = self.chance.choice(pieces) if self.chance.random() < 0.5 else None
        return ", ".join((same or self.chance.choice(pieces)).format(*axis) for axis in axes)

    def moved(self):
        """The target at another moment, if it has one."""
        if not self.target or self.target.kind in ("vdb", "cloud"):
            return "ball.obj"
        return self.chance.choice(["moved_", "moved_", "moved_", ""]) + self.target.name

    def values(self):
        """By the name of an option, a function that draws its value."""
        chance = self.chance
        size = self.target.size if self.target else 2.0
        length = lambda low, high: lambda: self.number(low * size, high * size)
        versors = [t["name"] for t in self.known["textures"]] + ["random"] * 3 + ["swirl.json", "roots.p4d"]
        return {
            "alpha": lambda: self.control(3, 300), "beta": lambda: self.control(-0.05, 0.05),
            "detail": lambda: self.control(0, 1), "outward": lambda: self.control(0, 1),
            "mask": lambda: self.control(0, 1),
            "texture": lambda: chance.choice(versors + ["roots.o3d"] * (self.map == "rational")),
            "texture-seed": lambda: str(chance.randint(0, 10**6)), "texture-roots": lambda: str(chance.randint(1, 24)),
            "texture-powers": lambda: "{}:{}".format(*sorted((chance.randint(1, 12), chance.randint(1, 12)))),
            "texture-distance": lambda: self.number(0, 0.2), "texture-radius": lambda: self.number(0.01, 0.5),
            "texture-scale": lambda: self.number(0.4, 2.5), "texture-translate": lambda: self.vector(0.1),
            "texture-centre": lambda: self.vector(0.2),
            "rational": lambda: chance.choice(["rational.json", "roots.o3d"]),
            "iterations": lambda: str(chance.choice([1, 2, 3, 4, 6, 9])), "escape": lambda: self.number(1.1, 40),
            "slice": lambda: self.number(-0.4, 0.4), "radius": lambda: self.number(1.2, 6),
            "c": lambda: ",".join(self.number(-0.8, 0.8) for _ in range(4 if self.map == "quadratic" else 3)),
            "f": self.function, "g": self.function,
            "power": lambda: chance.choice(["2", "3", "8", "8", "5", "2.5", "-2", self.number(-9, 12), "64"]),
            "origin": lambda: chance.choice(["auto", "centre", self.vector(0.1)]),
            "origin-near": lambda: self.vector(0.2), "origin-shift": lambda: self.vector(0.05),
            "box": self.box, "seed-stride": lambda: str(2 ** chance.randint(0, 5)),
            "tolerance": lambda: self.power_of_ten(-9, -0.35), "adaptivity": lambda: self.power_of_ten(-2, 0.6),
            "crumbs": lambda: chance.choice(["drop", "keep"]),
            "largest": lambda: str(chance.randint(0, 4)), "min-size": length(0, 0.2), "lod": self.levels,
            "attributes": lambda: self.some(("Cd", "direction", "trap", "iterations", "depth", "tau", "mask", "velocity"), 4),
            "colour": self.colour, "transfer": self.transferred,
            "rest": self.moved, "target-before": self.moved, "target-after": self.moved,
            "rest-attribute": lambda: "rest", "rest-frame": lambda: self.number(0, 9), "fps": lambda: self.number(1, 60),
            "grids": lambda: self.some(("surface", "density", "logmodulus", "iterations", "versor")),
            "repair-gap": length(0, 0.15), "thicken": length(0.12, 0.4), "points-radius": length(0.12, 0.3),
            "solidify": lambda: chance.choice(["", "y:", "z:"]) + self.number(0.2 * size, size),
            "grid": lambda: "",
            "iso": lambda: self.number(-0.05 * size, 0.05 * size),
            "grid-names": lambda: "houdini",
        }

    def guessed(self, option):
        """A value for an option that is not known here: as its placeholder and its help suggest."""
        words, help_text = option["argument"], option["help"]
        listed = re.search(r"a list of ([\w, ]+)", help_text)
        if words == "LIST" and listed:
            return self.some([name.strip() for name in listed[1].split(",")])
        if "|" in words and not re.search(r"[\[\]]", words):
            choices = [w for w in words.split("|") if not re.search(r"[A-Z]{2}|,", w)]
            if choices:
                return self.chance.choice(choices)
        if "," in words:
            return ",".join(self.number(-1, 1) for _ in words.split(","))
        if words in ("N", "S"):
            return str(self.chance.randint(0, 12))
        return option.get("default") or self.number(0, 2)

    # -------------------------------------------------------------------------------------------------------- recipes

    def solid(self):
        """What makes a solid of the target, if it is none: one of the options that mend."""
        mending = {"open": ["repair", "repair-gap", "thicken"], "terrain": ["solidify", "thicken"], "sheet": ["thicken"],
                   "cloud": ["points-radius"]}
        return self.chance.choice(mending.get(self.target.kind if self.target else "", [None]))

    def recipe(self):
        chance, known = self.chance, self.known
        # Half of all recipes are for the map that has the most options.
        names = [m["name"] for m in known["maps"]]
        self.map = chance.choice(names + [names[0]] * (len(names) - 2))
        use = next(m["target"] for m in known["maps"] if m["name"] == self.map)
        wanted = {"needed": True, "optional": chance.random() < 0.6, "none": False}[use]
        self.target = chance.choices(self.targets, [t.weight for t in self.targets])[0] if wanted else None
        values = self.values()
        lattice = [("map", self.map), ("resolution", str(chance.randint(12, 32 if chance.random() < 0.8 else 48)))]
        if self.target and self.target.kind != "vdb":
            lattice.append(("sdf-resolution", str(chance.randint(16, 40))))
        mend = self.solid()
        likely = chance.choice([0.03, 0.1, 0.1, 0.3])
        drawn = []
        for option in known["options"]:
            name = option["name"]
            # Mending what is whole is allowed, and rare.
            rare = 0.1 if name in ("repair", "repair-gap", "solidify", "thicken", "points-radius", "grid", "iso", "invert") else 1
            if name in NOT_DRAWN or self.map not in option["maps"]:
                continue
            if name != mend and chance.random() > likely * rare:
                continue
            rivals = {option.get("alternative"), *option["displaces"]} | {
                o["name"] for o in known["options"] if name in o["displaces"] or o.get("alternative") == name}
            # A contradiction is a usage error, which is a law too.
            if rivals & {other for other, _ in drawn} and chance.random() < 0.95:
                continue
            value = None if not option["argument"] else values.get(name, lambda: self.guessed(option))()
            drawn.append((name, value))
        given = dict(drawn)
        # What means nothing alone.
        if {"f", "g"} & given.keys() or given.get("pair") == "user":
            drawn = [(n, v) for n, v in drawn if n not in ("pair", "f", "g")]
            drawn += [(n, self.function()) for n in ("f", "g")]
        mesh = ".glb" if "lod" in given else chance.choice(FORMATS)
        # Options of a VDB alone have one. The program refuses what else has no effect, and such an option is taken out.
        vdb = chance.random() < VDB_SHARE or bool({"grids", "half", "grid-names"} & given.keys())
        return Recipe(self.target.name if self.target else None, tuple(lattice + drawn), mesh, vdb)


def box_of(recipe, targets):
    """A box that holds every vertex: generous, for what has no --box."""
    target = next((t for t in targets if t.name == recipe.target), None)
    reach = 1.01 * max(float(recipe.value("radius", 2)), float(recipe.value("escape", 20)))
    if recipe.has("box"):
        numbers = [float(x) for x in recipe.value("box").split(",")]
        # A cap lies up to a voxel outside. What mends a target makes it larger, and so the voxels, by half at most.
        voxel = 1.5 * (target.size if target else 2 * reach) / float(recipe.value("resolution", 200))
        margin = voxel if recipe.has("cap") else 0
        return [x - margin for x in numbers[:3]], [x + margin for x in numbers[3:]]
    if not target:
        return [-reach] * 3, [reach] * 3
    return [l - 1.5 * target.size for l in target.low], [h + 1.5 * target.size for h in target.high]
