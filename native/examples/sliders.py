# SPDX-License-Identifier: MPL-2.0
import meanvalue
import numpy as np
from bar import make_bar

V, F = make_bar()
# Two keys: one lifts the end, one makes the bar thicker.
lifted = V + np.outer(0.05 * V[:, 0] ** 2, [0.0, 0.0, 1.0])
thicker = V * [1.0, 1.5, 1.5]

seen = np.arange(0, len(V), 7)
fit = meanvalue.SliderFit(V, [lifted, thicker], seen)

mixed = V + 0.7 * (lifted - V) + 0.2 * (thicker - V)
found = fit.solve(mixed[seen])

worst = np.linalg.norm(found.residuals, axis=1).max()
print(f"lifted {found.values[0]:.3f}, thicker {found.values[1]:.3f}; the worst marker is {worst:.3f} off")
