// SPDX-License-Identifier: MPL-2.0
// A morph
//
// Shapes of one mesh are mixed by weights: limbs turn on their way instead of shrinking. A weight may also be given
// for each vertex, which takes a part of one shape (`MorphOptions::parts`). The result depends on the weights alone.
#include <meanvalue/meanvalue.h>

#include <cstdio>

#include "bar.h"

int main() {
    Eigen::MatrixXd V;
    Eigen::MatrixXi F;
    make_bar(V, F);
    // The other shape: three quarters of a circle around y.
    Eigen::MatrixXd bent = V;
    for (int v = 0; v < V.rows(); ++v) {
        const double angle = 1.5 * EIGEN_PI * V(v, 0) / (0.2 * (kRings - 1));
        bent.row(v) << (1.25 - V(v, 2)) * std::sin(angle), V(v, 1), 1.25 - (1.25 - V(v, 2)) * std::cos(angle);
    }
    const meanvalue::Morpher morpher(meanvalue::MorphBinding(std::vector{V, bent}, F));
    const Eigen::MatrixXd half = morpher.solve({0.5, 0.5}).vertices;

    const auto length = [](const Eigen::MatrixXd& U) { return (U.row(8) - U.row(0)).norm(); };
    std::printf("an edge of %.6f, bent %.6f, is %.6f half way\n", length(V), length(bent), length(half));
}
