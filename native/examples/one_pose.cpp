// SPDX-License-Identifier: MPL-2.0
// One pose
//
// Some vertices, the anchors, are held or moved, and the rest of the surface follows with its details. `anchors`
// names them in any order, and `targets` has a row for each. Matrices may have any layout, as those of libigl have.
// `deform()` does all at once; for other targets of the same anchors, keep a `Deformer` (the next page).
#include <meanvalue/meanvalue.h>

#include <cstdio>

#include "bar.h"

int main() {
    Eigen::MatrixXd V;
    Eigen::MatrixXi F;
    make_bar(V, F);

    // The first ring stays, the last one goes back and up.
    const std::vector<int> anchors = both_ends();
    Eigen::MatrixXd targets = V(anchors, Eigen::all);
    targets.bottomRows(kCorners).rowwise() += Eigen::RowVector3d(-1.0, 0.0, 2.0);

    const meanvalue::Solution solution = meanvalue::deform(V, F, anchors, targets);
    const Eigen::MatrixXd U = solution.vertices;

    std::printf("%s; the middle is %.6f higher\n", solution.converged ? "converged" : "not converged",
                U(U.rows() / 2, 2) - V(V.rows() / 2, 2));
}
