# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # What does alpha do?
# The papers set the thickness of the shell by alpha: the modulus of the first step is e^(alpha (phi - beta)), where phi is
# the distance to the target. As a script: 2_alpha.py MESH OUT.png [SIZE]

# %%
import math
import sys

import juliavdb
import numpy as np
from pictures import save

mesh, out = sys.argv[1:3]
size = int(sys.argv[3]) if len(sys.argv) > 3 else 300
alphas = (10, 40, 160)

# %% [markdown]
# At how many random points of a box is the modulus of the first step neither large nor small?

# %%
pictures, undecided, points = [], [], None
for alpha in alphas:
    options = dict(alpha=alpha, texture_roots=10, texture_integer=True, sdf_resolution=100)
    pictures.append(juliavdb.render(mesh, size=(size, size), samples=1, **options))
    first = juliavdb.Field(mesh, iterations=1, **options)
    if points is None:  # the box of the first alpha holds the sets of all others
        points = np.random.default_rng(1).uniform(*np.array(first.bounds), (100 * size, 3))
    undecided.append(np.mean(np.abs(first(points)) < math.log(20)))

# %% [markdown]
# The answer: the larger alpha is, the fewer points have a modulus between 1/20 and 20, and the thinner the shell is.

# %%
save(out, np.concatenate(pictures, axis=1))
for alpha, share in zip(alphas, undecided):
    print(f"alpha {alpha}: {100 * share:.1f} % of the box between 1/20 and 20")
