# SPDX-License-Identifier: MPL-2.0
import math

import meanvalue
import numpy as np
from bar import RINGS, make_bar

V, F = make_bar()
# The other shape: three quarters of a circle around y.
bent = V.copy()
for v, (x, y, z) in enumerate(V):
    angle = 1.5 * math.pi * x / (0.2 * (RINGS - 1))
    bent[v] = (1.25 - z) * math.sin(angle), y, 1.25 - (1.25 - z) * math.cos(angle)

morpher = meanvalue.Morpher([V, bent], F)
half = morpher.solve([0.5, 0.5]).vertices

lengths = [np.linalg.norm(shape[8] - shape[0]) for shape in (V, bent, half)]
print("an edge of {:.6f}, bent {:.6f}, is {:.6f} half way".format(*lengths))
