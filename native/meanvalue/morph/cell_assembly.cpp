#include "meanvalue/morph/cell_assembly.h"

#include <algorithm>
#include <utility>

#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

// The factor is in single precision; a second pass is for what the first leaves.
constexpr int kPasses = 2;

template <typename T>
std::size_t bytes_of(const std::vector<T>& items) {
    return items.capacity() * sizeof(T);
}

}  // namespace

CellAssembly::CellAssembly(const Encoding& layout, QuadraticRows rows, const SupernodalFactor& factor,
                           const Execution& execution)
    : layout_(layout), rows_(std::move(rows)), factor_(factor) {
    index_uses(execution);
}

void CellAssembly::index_uses(const Execution& execution) {
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

/// Minus the derivative of one row by its own vertex. @param shares receives that by each ring vertex.
Vector3 CellAssembly::pull_of(Index row, const RestCells& cells, const Matrix3& rotation, const Positions& positions,
                              std::vector<Vector3>& missing, Vector3* shares) const {
    const Index first = layout_.ring_offsets[row];
    const Index valence = layout_.ring_offsets[row + 1] - first;
    const Vector3 own = positions.row(row);
    missing.resize(valence);
    Vector3 bend = Vector3::Zero();
    for (Index k = 0; k < valence; ++k) {
        const Vector3 edge = own - Vector3(positions.row(layout_.ring[first + k]));
        missing[k] = rotation * cells.edges[first + k] - edge;
        bend += rows_.weights[first + k] * missing[k];
    }
    bend *= rows_.bending[row];
    Vector3 pull = bend;
    for (Index k = 0; k < valence; ++k) {
        const Index before = k == 0 ? valence - 1 : k - 1;
        const Index after = k + 1 == valence ? 0 : k + 1;
        const Vector3 spoke = rows_.spokes[first + k] * missing[k];
        pull += spoke;
        shares[k] = -spoke - rows_.weights[first + k] * bend - rows_.rims[first + k] * (missing[k] - missing[after]) -
                    rows_.rims[first + before] * (missing[k] - missing[before]);
    }
    return pull;
}

void CellAssembly::solve(const RestCells& cells, const std::vector<Quaternion>& rotations, int threads,
                         const Execution& execution, Workspace& workspace, Positions& positions) const {
    const Index vertices = layout_.vertex_count();
    workspace.shares.resize(layout_.ring.size());
    workspace.sums.resize(vertices, 3);
    for (int pass = 0; pass < kPasses; ++pass) {
        parallel_for(vertices, threads, execution, [&](Index begin, Index end) {
            std::vector<Vector3> missing;
            for (Index v = begin; v < end; ++v) {
                workspace.sums.row(v) = pull_of(v, cells, rotations[v].toRotationMatrix(), positions, missing,
                                                workspace.shares.data() + layout_.ring_offsets[v])
                                            .transpose();
            }
        });
        parallel_for(vertices, threads, execution, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                Vector3 sum = workspace.sums.row(v);
                for (Index use = use_start_[v]; use < use_start_[v + 1]; ++use)
                    sum += workspace.shares[uses_[use]];
                workspace.sums.row(v) = sum.transpose();
            }
        });
        factor_.solve(workspace.sums, workspace.sums, threads, execution, workspace.factor);
        positions += workspace.sums;
    }
}

std::size_t CellAssembly::bytes() const {
    return rows_.bytes() + bytes_of(use_start_) + bytes_of(uses_);
}

}  // namespace meanvalue
