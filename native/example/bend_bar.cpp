// Bends a bar: its first cross-section is held, the last is lifted, and what is between follows.
#include <cmath>
#include <cstdio>
#include <vector>

#include "meanvalue/deform/deformer.h"

using meanvalue::Index;

namespace {

constexpr Index kSections = 30;
constexpr Index kCorners = 8;

/// Rings of kCorners vertices along x, with the triangles between them; open at both ends.
void make_bar(meanvalue::Positions& vertices, meanvalue::Triangles& triangles) {
    vertices.resize(kSections * kCorners, 3);
    triangles.resize(2 * (kSections - 1) * kCorners, 3);
    Index row = 0;
    for (Index section = 0; section < kSections; ++section) {
        for (Index corner = 0; corner < kCorners; ++corner) {
            const double angle = 2.0 * std::acos(-1.0) * corner / kCorners;
            const Index here = section * kCorners + corner;
            vertices.row(here) << 0.2 * section, 0.3 * std::cos(angle), 0.3 * std::sin(angle);
            if (section + 1 == kSections) continue;
            const Index beside = section * kCorners + (corner + 1) % kCorners;
            triangles.row(row++) << here, beside, here + kCorners;
            triangles.row(row++) << beside, beside + kCorners, here + kCorners;
        }
    }
}

}  // namespace

int main() {
    meanvalue::Positions vertices;
    meanvalue::Triangles triangles;
    make_bar(vertices, triangles);
    std::vector<Index> anchors;
    anchors.reserve(2 * static_cast<std::size_t>(kCorners));
    for (Index corner = 0; corner < kCorners; ++corner)
        anchors.push_back(corner);
    for (Index corner = 0; corner < kCorners; ++corner)
        anchors.push_back((kSections - 1) * kCorners + corner);

    meanvalue::Execution execution;
    meanvalue::Deformer deformer({vertices, triangles, anchors, {}}, execution);
    meanvalue::Positions targets(2 * kCorners, 3);
    for (Index anchor = 0; anchor < 2 * kCorners; ++anchor)
        targets.row(anchor) = vertices.row(anchors[anchor]);
    targets.bottomRows(kCorners).rowwise() += Eigen::RowVector3d(-1.0, 0.0, 2.0);

    const meanvalue::Solution solution = deformer.solve(targets, {}, {}, execution);
    std::printf("%d vertices, %s after %d iterations; the middle has risen by %.3f\n",
                static_cast<int>(vertices.rows()), solution.stop_reason.c_str(), solution.iterations,
                solution.vertices(kSections / 2 * kCorners, 2) - vertices(kSections / 2 * kCorners, 2));
    return solution.converged ? 0 : 1;
}
