# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # When are 32 bits too few?
# The field can be computed in floats or in doubles. Both have a sign at every point; here is how often the signs differ, the
# nearer the points lie to each other and to the surface. As a script: 6_precision.py MESH OUT.png [POINTS]

# %%
import sys

import juliavdb
import numpy as np
from pictures import plot, save

mesh, out = sys.argv[1:3]
count = int(sys.argv[3]) if len(sys.argv) > 3 else 100000

# %%
options = dict(alpha=40, texture_roots=10, texture_integer=True, sdf_resolution=100)
single, double = (juliavdb.Field(mesh, precision=precision, **options) for precision in ("float", "double"))
low, high = np.array(double.bounds)
draw = np.random.default_rng(1)
inside, outside = draw.uniform(low, high, (2, count, 3))
keep = double.inside(inside) & ~double.inside(outside)
inside, outside = inside[keep], outside[keep]

# %% [markdown]
# Bisection: pairs of points on either side of the surface come nearer to each other, by half in each round.

# %%
sizes, flips = [], []
for _ in range(40):
    middle = (inside + outside) / 2
    here = double.inside(middle)
    flips.append(np.mean(single.inside(middle) != here))
    sizes.append(np.median(np.linalg.norm(inside - outside, axis=1)) / np.max(high - low))
    inside, outside = np.where(here[:, None], middle, inside), np.where(here[:, None], outside, middle)

# %% [markdown]
# The answer: as long as the points are some hundred-thousandths of the box apart, hardly ever; below that, as often as a coin would.

# %%
save(out, plot((sizes, np.maximum(flips, 1 / len(inside)))))
for size, flip in zip(sizes[::5], flips[::5]):
    print(f"{size:.1e} of the box apart: {100 * flip:.2f} % of the signs differ")
