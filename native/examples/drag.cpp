// SPDX-License-Identifier: MPL-2.0
// A drag
//
// Binding is expensive and done once for a set of anchors; a solve is cheap. In a drag each solve goes on from the
// answer before, and `draft()` tells in a few milliseconds what the solve is going to give: show it meanwhile.
// Any number of drags, and of threads, may use one `Deformer`.
#include <meanvalue/meanvalue.h>

#include <cstdio>

#include "bar.h"

int main() {
    Eigen::MatrixXd V;
    Eigen::MatrixXi F;
    make_bar(V, F);
    const std::vector<int> anchors = both_ends();
    const meanvalue::Deformer deformer(meanvalue::Binding(V, F, anchors));

    Eigen::MatrixXd targets = V(anchors, Eigen::all);
    meanvalue::Deformer::Drag drag(deformer);
    std::vector<meanvalue::Positions> shown;
    int drafts = 0;
    for (int frame = 0; frame < 20; ++frame) {
        targets.bottomRows(kCorners).rowwise() += Eigen::RowVector3d(-0.05, 0.0, 0.1);
        if (auto draft = drag.draft(targets)) {
            shown.push_back(std::move(*draft));
            ++drafts;
        }
        shown.push_back(drag.solve(targets).vertices);
    }
    std::printf("20 solves, %d drafts; the middle is %.6f higher\n", drafts,
                shown.back()(V.rows() / 2, 2) - V(V.rows() / 2, 2));
}
