# SPDX-License-Identifier: MPL-2.0
import meanvalue
from bar import CORNERS, both_ends, make_bar

V, F = make_bar()
anchors = both_ends()
deformer = meanvalue.Deformer(V, F, anchors)

targets = V[anchors]
shown, drafts = [], 0
with deformer.drag() as drag:
    for _ in range(20):
        targets[-CORNERS:] += [-0.05, 0.0, 0.1]
        draft = drag.draft(targets)
        if draft is not None:
            shown.append(draft)
            drafts += 1
        shown.append(drag.solve(targets).vertices)

U, middle = shown[-1], len(V) // 2
print(f"20 solves, {drafts} drafts; the middle is {U[middle, 2] - V[middle, 2]:.6f} higher")
