#include "meanvalue/decode/fast/soft_constraints.h"

#include <algorithm>
#include <numeric>

#include "meanvalue/common/parallel.h"

namespace meanvalue {

SoftConstraints::SoftConstraints(std::vector<SoftAnchor> anchors, const Unknowns& unknowns)
    : anchors_(std::move(anchors)) {
    std::sort(anchors_.begin(), anchors_.end(),
              [](const SoftAnchor& a, const SoftAnchor& b) { return a.vertex < b.vertex; });
    for (const SoftAnchor& anchor : anchors_) {
        vertices_.push_back(anchor.vertex);
        places_.push_back(anchor.anchor);
    }
    numbers_ = picked(unknowns.number, vertices_);
}

double SoftConstraints::add_energy(const PositionsView& positions, const Positions& targets,
                                   const std::vector<double>& weights, Positions& gradient, int threads,
                                   const Execution& execution) const {
    const auto count = static_cast<Index>(anchors_.size());
    std::vector<double> energies(piece_count(count));
    parallel_pieces(count, threads, execution, [&](Index piece, Index begin, Index end) {
        double sum = 0.0;
        for (Index k = begin; k < end; ++k) {
            const double strength = (weights.empty() ? 1.0 : weights[k]) * anchors_[k].strength;
            const Eigen::RowVector3d stretch = positions.row(anchors_[k].vertex) - targets.row(k);
            sum += strength * stretch.squaredNorm();
            gradient.row(numbers_[k]) += 2.0 * strength * stretch;
        }
        energies[piece] = sum;
    });
    return std::accumulate(energies.begin(), energies.end(), 0.0);
}

void SoftConstraints::add_pulls(const Positions& moves, const std::vector<double>& weights, Positions& fall) const {
    const Eigen::Index first = moves.rows() - static_cast<Eigen::Index>(anchors_.size());
    for (std::size_t k = 0; k < anchors_.size(); ++k) {
        const double strength = (weights.empty() ? 1.0 : weights[k]) * anchors_[k].strength;
        fall.row(numbers_[k]) += 2.0 * strength * moves.row(first + static_cast<Eigen::Index>(k));
    }
}

void SoftConstraints::add_hessian(SparseMatrix& hessian) const {
    for (std::size_t k = 0; k < anchors_.size(); ++k)
        hessian.valuePtr()[hessian.outerIndexPtr()[numbers_[k]]] += 2.0 * anchors_[k].strength;
}

std::vector<double> SoftConstraints::lost_hessian(const std::vector<double>& weights) const {
    std::vector<double> lost(anchors_.size(), 0.0);
    for (std::size_t k = 0; k < weights.size(); ++k)
        lost[k] = 2.0 * (1.0 - weights[k]) * anchors_[k].strength;
    return lost;
}

std::vector<double> SoftConstraints::hardness(std::size_t vertex_count) const {
    if (empty()) return {};
    std::vector<double> result(vertex_count, 0.0);
    for (const SoftAnchor& anchor : anchors_)
        result[anchor.vertex] = hardness_of(anchor.strength);
    return result;
}

std::vector<SoftAnchor> coarse_soft_anchors(const std::vector<SoftAnchor>& anchors, const Hierarchy& hierarchy,
                                            const Level& level, std::size_t vertex_count, double scale) {
    std::vector<Index> into(vertex_count);
    std::iota(into.begin(), into.end(), 0);
    std::vector<char> is_removed(vertex_count, 0);
    for (std::size_t k = 0; k < level.removed_count; ++k)
        is_removed[hierarchy.order[k]] = 1;
    // Backwards, so that what a vertex was merged into is known by where that went.
    for (auto merge = hierarchy.soft_merges.rbegin(); merge != hierarchy.soft_merges.rend(); ++merge) {
        if (is_removed[merge->removed]) into[merge->removed] = into[merge->into];
    }
    std::vector<SoftAnchor> result;
    std::vector<Index> place(vertex_count, -1);
    for (const SoftAnchor& anchor : anchors) {
        if (into[anchor.vertex] != anchor.vertex) continue;
        place[anchor.vertex] = static_cast<Index>(result.size());
        result.push_back(anchor);
        result.back().strength = 0.0;
    }
    for (const SoftAnchor& anchor : anchors)
        result[place[into[anchor.vertex]]].strength += scale * anchor.strength;
    return result;
}

double energy_unit(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells) {
    double inverse_squares = 0.0;
    for (const Index i : unknowns.rows) {
        const double length = cells.mean_edge(encoding, i);
        if (length > 0.0) inverse_squares += 1.0 / (length * length);
    }
    return inverse_squares > 0.0 ? static_cast<double>(unknowns.rows.size()) / inverse_squares : 1.0;
}

}  // namespace meanvalue
