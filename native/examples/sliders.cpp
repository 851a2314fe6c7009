// SPDX-License-Identifier: MPL-2.0
// Sliders
//
// A mesh has shape keys, each a shape that is added by its value. `SliderFit` finds the values that bring a few
// vertices to their targets, as markers on a face, and how the whole has moved; few values leave rest.
#include <meanvalue/meanvalue.h>

#include <cstdio>

#include "bar.h"

int main() {
    Eigen::MatrixXd V;
    Eigen::MatrixXi F;
    make_bar(V, F);
    // Two keys: one lifts the end, one makes the bar thicker.
    Eigen::MatrixXd lifted = V;
    lifted.col(2) += 0.05 * V.col(0).cwiseAbs2();
    Eigen::MatrixXd thicker = V;
    thicker.rightCols(2) *= 1.5;

    std::vector<int> seen;
    for (int v = 0; v < V.rows(); v += 7)
        seen.push_back(v);
    const meanvalue::SliderFit fit(meanvalue::SliderBinding(V, std::vector{lifted, thicker}, seen));

    const Eigen::MatrixXd mixed = V + 0.7 * (lifted - V) + 0.2 * (thicker - V);
    meanvalue::SliderSolution found = fit.solve(meanvalue::Positions(mixed(seen, Eigen::all)));
    const meanvalue::Positions rest = std::move(found.residuals);

    std::printf("lifted %.3f, thicker %.3f; the worst marker is %.3f off\n", found.values[0], found.values[1],
                rest.rowwise().norm().maxCoeff());
}
