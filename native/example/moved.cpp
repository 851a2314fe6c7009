// Takes what the library gives and frees it: the drafts of a drag, moved vertices, values of shape keys.
#include <meanvalue/meanvalue.h>

#include <cstdio>
#include <numeric>

int main() {
    constexpr int kRows = 40;
    Eigen::MatrixXd V(2 * kRows, 3);
    Eigen::MatrixXi F(2 * kRows - 2, 3);
    for (int v = 0; v < V.rows(); ++v) {
        const int along = v / 2;
        V.row(v) << along, v % 2, 0.0;
        if (v < F.rows()) F.row(v) << v, v + 2 - v % 2, v + 1 + v % 2;
    }
    const std::vector<int> anchors{0, 1, 2 * kRows - 2, 2 * kRows - 1};
    const meanvalue::Deformer deformer(meanvalue::Binding(V, F, anchors));
    Eigen::MatrixXd targets = V(anchors, Eigen::all);
    meanvalue::Deformer::Drag drag(deformer);
    meanvalue::Execution execution;
    std::vector<meanvalue::Positions> shapes;
    for (int frame = 0; frame < 20; ++frame) {
        targets.bottomRows(2).col(2).array() += 0.1;
        const meanvalue::Positions goal = targets;
        if (auto draft = drag.draft(goal)) shapes.push_back(std::move(*draft));
        shapes.push_back(std::move(drag.solve(goal, {}, execution).vertices));
    }
    Eigen::MatrixXd key = V;
    key.col(2) = 0.01 * V.col(0).cwiseAbs2();
    const std::vector<int> seen{0, 1, kRows, kRows + 1, 2 * kRows - 2, 2 * kRows - 1};
    const meanvalue::SliderFit fit(meanvalue::SliderBinding(V, std::vector{key}, seen));
    meanvalue::SliderSolution values = fit.solve(meanvalue::Positions(key(seen, Eigen::all)));
    shapes.push_back(std::move(values.residuals));
    const double sum = std::accumulate(shapes.begin(), shapes.end(), 0.0,
                                       [](double sum, const auto& shape) { return sum + shape.cwiseAbs().sum(); });
    std::printf("%zu shapes, their coordinates sum to %.3f\n", shapes.size(), sum);
}
