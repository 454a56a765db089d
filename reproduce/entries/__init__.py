# SPDX-License-Identifier: Apache-2.0
"""The entries of all papers, by name and in order."""
from . import ablations, dimension, kd20, kim15, sk23, zb25

ENTRIES = {entry.name: entry for module in (sk23, kim15, kd20, zb25, ablations, dimension) for entry in module.ENTRIES}
