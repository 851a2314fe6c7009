// SPDX-License-Identifier: MPL-2.0
// What the examples deform: a bar along x, as libigl has meshes.
#include <Eigen/Core>
#include <cmath>
#include <vector>

constexpr int kRings = 30;
constexpr int kCorners = 8;

/// Rings of kCorners vertices along x, with the triangles between them; open at both ends.
inline void make_bar(Eigen::MatrixXd& V, Eigen::MatrixXi& F) {
    V.resize(kRings * kCorners, 3);
    F.resize(2 * (kRings - 1) * kCorners, 3);
    for (int v = 0; v < V.rows(); ++v) {
        const int ring = v / kCorners;
        const double angle = 2.0 * EIGEN_PI * (v % kCorners) / kCorners;
        V.row(v) << 0.2 * ring, 0.3 * std::cos(angle), 0.3 * std::sin(angle);
        if (v + kCorners >= V.rows()) continue;
        const int beside = v - v % kCorners + (v + 1) % kCorners;
        F.row(2 * v) << v, beside, v + kCorners;
        F.row(2 * v + 1) << beside, beside + kCorners, v + kCorners;
    }
}

/// The vertices of the first ring, then those of the last.
inline std::vector<int> both_ends() {
    std::vector<int> vertices(2 * kCorners);
    for (int corner = 0; corner < kCorners; ++corner) {
        vertices[corner] = corner;
        vertices[kCorners + corner] = (kRings - 1) * kCorners + corner;
    }
    return vertices;
}
