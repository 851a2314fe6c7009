// Bends a bar that is given as libigl has meshes: its first cross-section is held, the last one is lifted.
#include <meanvalue/meanvalue.h>

#include <cmath>
#include <cstdio>
#include <numeric>

constexpr int kSections = 30;
constexpr int kCorners = 8;

/// Rings of kCorners vertices along x, with the triangles between them; open at both ends.
void make_bar(Eigen::MatrixXd& V, Eigen::MatrixXi& F) {
    V.resize(kSections * kCorners, 3);
    F.resize(2 * (kSections - 1) * kCorners, 3);
    for (int v = 0; v < V.rows(); ++v) {
        const int section = v / kCorners;
        const double angle = 2.0 * EIGEN_PI * (v % kCorners) / kCorners;
        V.row(v) << 0.2 * section, 0.3 * std::cos(angle), 0.3 * std::sin(angle);
        if (v + kCorners >= V.rows()) continue;
        const int beside = v - v % kCorners + (v + 1) % kCorners;
        F.row(2 * v) << v, beside, v + kCorners;
        F.row(2 * v + 1) << beside, beside + kCorners, v + kCorners;
    }
}

int main() {
    Eigen::MatrixXd V;
    Eigen::MatrixXi F;
    make_bar(V, F);
    std::vector<int> anchors(2 * kCorners);
    std::iota(anchors.begin(), anchors.begin() + kCorners, 0);
    std::iota(anchors.begin() + kCorners, anchors.end(), V.rows() - kCorners);

    const meanvalue::Deformer deformer(meanvalue::Binding(V, F, anchors));
    Eigen::MatrixXd targets = V(anchors, Eigen::all);
    targets.bottomRows(kCorners).rowwise() += Eigen::RowVector3d(-1.0, 0.0, 2.0);
    const meanvalue::Solution solution = deformer.solve(targets);
    const Eigen::MatrixXd U = solution.vertices;

    std::printf("%d vertices, %s after %d iterations (%s); the middle is %.3f higher\n", static_cast<int>(U.rows()),
                solution.converged ? "converged" : "not converged", solution.iterations, solution.stop_reason.c_str(),
                U(U.rows() / 2, 2) - V(V.rows() / 2, 2));
}
