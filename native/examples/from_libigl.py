# SPDX-License-Identifier: MPL-2.0
# | libigl | Open3D | here |
# |---|---|---|
# | `arap = igl.ARAP(V, F, 3, b)`, `igl.arap_precomputation()` | | `deformer = Deformer(V, F, b)` |
# | `arap.solve(bc, U)`, `igl.arap_solve()` | | `drag.solve(bc).vertices`, with `drag = deformer.drag()` |
# | the same from `U = V` | | `deformer.solve(bc).vertices` |
# | all at once | `mesh.deform_as_rigid_as_possible(b, bc, 50)` | `deform(V, F, b, bc).vertices` |
# | another `b` | | `deformer.rebind(b)` |
# | none | | `Deformer(V, F, b, stiffness=1.0 + 29.0 * is_limb)`: limbs bend at their joints |
#
# `b` has one dimension: of a column give `b.ravel()`, of flags `np.flatnonzero(flags)`. For Open3D, `V` is
# `np.asarray(mesh.vertices)` and `F` is `np.asarray(mesh.triangles)`.

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
