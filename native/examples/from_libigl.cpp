// SPDX-License-Identifier: MPL-2.0
// From libigl, CGAL or Open3D
//
// Code for as-rigid-as-possible deformation keeps its `V`, `F`, `b` and `bc`, of `double` and `int` in any layout.
// Shapes are near those of ARAP, not the same. Surfaces only; no dynamics, and no `dim` but 3.
//
// | libigl | CGAL | here |
// |---|---|---|
// | `arap_precomputation(V, F, 3, b, data)` | `preprocess()` | `Deformer deformer(Binding(V, F, b))` |
// | `arap_solve(bc, data, U)` from the last `U` | `deform()` | `Drag drag(deformer)`, `drag.solve(bc).vertices` |
// | the same from `U = V` | `reset()`, `deform()` | `deformer.solve(bc).vertices` |
// | `data.max_iter` | `set_iterations()` | to convergence; `max_iterations` in `solve(bc, SolveOptions)` |
// | another `b` | other control vertices | `deformer.binding_again()` with other `anchors`: two thirds of a bind |
// | a smaller `F` | `insert_roi_vertices()` | `Binding::roi`: n flags, 1 may move |
// | `bc` turned as a whole | `rotate()` | turn its rows; `Binding::handles` tells which anchors are one piece |
// | none | none | `Binding::strengths`: springs for constraints; `stiffness`: factors of lengths, to bend at joints |
//
// Constrained vertices are at `bc` exactly. `Binding::rigidity` says how much lengths count; at 0 only shape does.
#include <meanvalue/meanvalue.h>

#include <cstdio>

#include "bar.h"

int main() {
    Eigen::MatrixXd V;
    Eigen::MatrixXi F;
    make_bar(V, F);
    const Eigen::VectorXi b = Eigen::Map<const Eigen::VectorXi>(both_ends().data(), 2 * kCorners);
    Eigen::MatrixXd bc = V(b, Eigen::all);

    const meanvalue::Deformer deformer(meanvalue::Binding(V, F, b));  // igl::arap_precomputation(V, F, 3, b, data);
    meanvalue::Deformer::Drag drag(deformer);
    Eigen::MatrixXd U = V;
    for (int frame = 0; frame < 10; ++frame) {
        bc.bottomRows(kCorners).col(2).array() += 0.1;
        U = drag.solve(bc).vertices;  // igl::arap_solve(bc, data, U);
    }
    std::printf("the middle is %.6f higher\n", U(U.rows() / 2, 2) - V(V.rows() / 2, 2));
}
