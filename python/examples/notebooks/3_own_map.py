# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # Which set does a map of one's own have?
# The maps of Zimmermann and Bruckner iterate f(p) x g(p) + c for two functions f and g of space, given as formulas. Here f
# squares the coordinates, and g takes the cosines of k times the coordinates. As a script: 3_own_map.py OUT.png [SIZE]

# %%
import sys

import juliavdb
import numpy as np
from pictures import save

out = sys.argv[1]
size = int(sys.argv[2]) if len(sys.argv) > 2 else 300
ks = (0.5, 1, 2)

# %%
pictures, shares = [], []
for k in ks:
    field = juliavdb.Field(map="cross", scheme=4, f="x*x, y*y, z*z", g=f"cos({k}*x), cos({k}*y), cos({k}*z)", radius=4)
    low, high = np.array(field.bounds)
    points = np.random.default_rng(1).uniform(low, high, (100 * size, 3))
    shares.append(np.mean(field.inside(points)) * np.prod(high - low))
    pictures.append(field.render(size=(size, size), samples=1, colour="direction"))

# %% [markdown]
# The answer: one set for each k. Its volume comes from the share of random points that lie in it.

# %%
save(out, np.concatenate(pictures, axis=1))
for k, volume in zip(ks, shares):
    print(f"k = {k}: a volume of some {volume:.2f}")
