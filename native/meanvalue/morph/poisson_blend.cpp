#include "meanvalue/morph/poisson_blend.h"

#include <algorithm>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/decode/fast/row_energy.h"

namespace meanvalue {
namespace {

// The factor is in single precision; a second pass is for what the first leaves.
constexpr int kPasses = 2;

template <typename T>
std::size_t bytes_of(const std::vector<T>& items) {
    return items.capacity() * sizeof(T);
}

}  // namespace

PoissonBlend::PoissonBlend(const Encoding& layout, const RestCells& cells, const std::vector<Index>& pinned,
                           InstructionSet instructions, int threads, const Execution& execution)
    : layout_(layout), factor_(instructions) {
    measure_weights(cells, execution);
    index_uses(execution);
    const SparseMatrix lower = matrix(pinned);
    factor_.analyse(lower, execution, threads);
    if (!factor_.factorise(lower, execution, threads))
        throw SolverFailure(message("the Laplacian of ", lower.cols(), " vertices is singular"));
}

void PoissonBlend::measure_weights(const RestCells& cells, const Execution& execution) {
    weights_.resize(layout_.ring.size());
    std::vector<Spoke> spokes;
    for (Index v = 0; v < layout_.vertex_count(); ++v) {
        execution.check_every(v);
        const Index first = layout_.ring_offsets[v];
        const Index valence = layout_.ring_offsets[v + 1] - first;
        if (valence == 0) continue;
        spokes.resize(valence);
        measure_spokes(cells.edges.data() + first, valence, spokes.data());
        for (Index k = 0; k < valence; ++k)
            weights_[first + k] = spokes[k].spoke;
    }
}

void PoissonBlend::index_uses(const Execution& execution) {
    use_start_.assign(layout_.vertex_count() + 1, 0);
    for (const Index vertex : layout_.ring)
        ++use_start_[vertex + 1];
    for (Index v = 0; v < layout_.vertex_count(); ++v) {
        execution.check_every(v);
        use_start_[v + 1] += use_start_[v];
    }
    uses_.resize(layout_.ring.size());
    std::vector<Index> next(use_start_.begin(), use_start_.end() - 1);
    for (std::size_t place = 0; place < layout_.ring.size(); ++place) {
        execution.check_every(place);
        uses_[next[layout_.ring[place]]++] = static_cast<Index>(place);
    }
}

SparseMatrix PoissonBlend::matrix(const std::vector<Index>& pinned) const {
    const Index vertices = layout_.vertex_count();
    std::vector<double> diagonal(vertices, 0.0);
    std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries;
    entries.reserve(layout_.ring.size() + vertices);
    for (Index v = 0; v < vertices; ++v) {
        for (Index place = layout_.ring_offsets[v]; place < layout_.ring_offsets[v + 1]; ++place) {
            const Index other = layout_.ring[place];
            diagonal[v] += weights_[place];
            diagonal[other] += weights_[place];
            entries.emplace_back(std::max(v, other), std::min(v, other), -weights_[place]);
        }
    }
    for (const Index v : pinned)
        diagonal[v] += diagonal[v];
    for (Index v = 0; v < vertices; ++v)
        entries.emplace_back(v, v, diagonal[v] > 0.0 ? diagonal[v] : 1.0);
    SparseMatrix lower(vertices, vertices);
    lower.setFromTriplets(entries.begin(), entries.end());
    return lower;
}

void PoissonBlend::solve(const RestCells& cells, const std::vector<Matrix3>& rotations, int threads,
                         const Execution& execution, Workspace& workspace, Positions& positions) const {
    const Index vertices = layout_.vertex_count();
    workspace.missing.resize(layout_.ring.size());
    workspace.sums.resize(vertices, 3);
    for (int pass = 0; pass < kPasses; ++pass) {
        parallel_for(vertices, threads, execution, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                const Vector3 own = positions.row(v);
                for (Index place = layout_.ring_offsets[v]; place < layout_.ring_offsets[v + 1]; ++place) {
                    const Vector3 edge = own - Vector3(positions.row(layout_.ring[place]));
                    workspace.missing[place] = weights_[place] * (rotations[v] * cells.edges[place] - edge);
                }
            }
        });
        parallel_for(vertices, threads, execution, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                Vector3 sum = Vector3::Zero();
                for (Index place = layout_.ring_offsets[v]; place < layout_.ring_offsets[v + 1]; ++place)
                    sum += workspace.missing[place];
                for (Index use = use_start_[v]; use < use_start_[v + 1]; ++use)
                    sum -= workspace.missing[uses_[use]];
                workspace.sums.row(v) = sum.transpose();
            }
        });
        factor_.solve(workspace.sums, workspace.sums, threads, execution, workspace.factor);
        positions += workspace.sums;
    }
}

std::size_t PoissonBlend::bytes() const {
    return bytes_of(weights_) + bytes_of(use_start_) + bytes_of(uses_) + factor_.bytes();
}

}  // namespace meanvalue
