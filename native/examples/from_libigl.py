# SPDX-License-Identifier: MPL-2.0
import meanvalue
from bar import CORNERS, both_ends, make_bar

V, F = make_bar()
b = both_ends()
bc = V[b]

deformer = meanvalue.Deformer(V, F, b)  # igl.arap_precomputation(V, F, 3, b, data)
with deformer.drag() as drag:
    for _ in range(10):
        bc[-CORNERS:, 2] += 0.1
        U = drag.solve(bc).vertices  # U = igl.arap_solve(bc, data, U)

middle = len(V) // 2
print(f"the middle is {U[middle, 2] - V[middle, 2]:.6f} higher")
