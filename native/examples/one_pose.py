# SPDX-License-Identifier: MPL-2.0
import meanvalue
from bar import CORNERS, both_ends, make_bar

V, F = make_bar()

# The first ring stays, the last one goes back and up.
anchors = both_ends()
targets = V[anchors]
targets[-CORNERS:] += [-1.0, 0.0, 2.0]

solution = meanvalue.deform(V, F, anchors, targets)
U = solution.vertices

middle = len(V) // 2
how = "converged" if solution.converged else "not converged"
print(f"{how}; the middle is {U[middle, 2] - V[middle, 2]:.6f} higher")
