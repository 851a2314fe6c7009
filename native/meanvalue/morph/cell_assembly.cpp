#include "meanvalue/morph/cell_assembly.h"

#include <algorithm>
#include <numeric>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/rest_cells.h"

namespace meanvalue {
namespace {

// The factor is in single precision: a second pass solves for the residual of the first.
constexpr int kPasses = 2;
// Weight of rims against spokes. At 0 and at 1 more triangles are turned over (docs/decisions).
constexpr double kRimShare = 0.3;

}  // namespace

CellAssembly::CellAssembly(const Encoding& layout, const RestCells& cells,
                           const std::vector<std::vector<Index>>& parts, InstructionSet instructions, int threads,
                           const Execution& execution)
    : layout_(layout), factor_(instructions) {
    measure(cells, threads, execution);
    index_uses(execution);
    const SparseMatrix lower = matrix(parts, execution);
    factor_.analyse(lower, execution, threads);
    if (!factor_.factorise(lower, execution, threads))
        throw SolverFailure(message("the Laplacian of ", lower.rows(), " vertices is not positive definite"));
}

void CellAssembly::measure(const RestCells& cells, int threads, const Execution& execution) {
    spokes_.resize(layout_.ring.size());
    rims_.resize(layout_.ring.size());
    parallel_for(layout_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        std::vector<Spoke> spokes;
        for (Index v = begin; v < end; ++v) {
            const Index first = layout_.ring_offsets[v];
            const Index valence = layout_.ring_offsets[v + 1] - first;
            if (valence == 0) continue;
            spokes.resize(valence);
            measure_spokes(cells.edges.data() + first, valence, spokes.data());
            for (Index k = 0; k < valence; ++k) {
                spokes_[first + k] = spokes[k].spoke;
                rims_[first + k] = kRimShare * spokes[k].rim;
            }
        }
    });
}

/// The lower triangle. The first vertex of each part is held: this fixes where the part is, and nothing else.
SparseMatrix CellAssembly::matrix(const std::vector<std::vector<Index>>& parts, const Execution& execution) const {
    const Index vertices = layout_.vertex_count();
    std::vector<double> diagonal(vertices, 0.0);
    std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries;
    entries.reserve(2 * layout_.ring.size() + vertices);
    const auto add = [&](Index a, Index b, double weight) {
        diagonal[a] += weight;
        diagonal[b] += weight;
        entries.emplace_back(std::max(a, b), std::min(a, b), -weight);
    };
    for (Index v = 0; v < vertices; ++v) {
        execution.check_every(v);
        const Index first = layout_.ring_offsets[v];
        const Index last = layout_.ring_offsets[v + 1];
        for (Index k = first; k < last; ++k) {
            add(v, layout_.ring[k], spokes_[k]);
            add(layout_.ring[k], layout_.ring[k + 1 == last ? first : k + 1], rims_[k]);
        }
    }
    for (const std::vector<Index>& part : parts)
        diagonal[part.front()] *= 2.0;
    for (Index v = 0; v < vertices; ++v)
        entries.emplace_back(v, v, diagonal[v] > 0.0 ? diagonal[v] : 1.0);
    SparseMatrix lower(vertices, vertices);
    execution.check();
    lower.setFromTriplets(entries.begin(), entries.end());
    execution.check();
    return lower;
}

void CellAssembly::index_uses(const Execution& execution) {
    use_start_.assign(layout_.vertex_count() + 1, 0);
    for (const Index vertex : layout_.ring)
        ++use_start_[vertex + 1];
    std::partial_sum(use_start_.begin(), use_start_.end(), use_start_.begin());
    execution.check();
    uses_.resize(layout_.ring.size());
    std::vector<Index> next(use_start_.begin(), use_start_.end() - 1);
    for (std::size_t place = 0; place < layout_.ring.size(); ++place)
        uses_[next[layout_.ring[place]]++] = static_cast<Index>(place);
}

/// Minus the derivative of the energy of one row by its own vertex. @param shares receives the same by each ring
/// vertex.
Vector3 CellAssembly::pull_of(Index row, const RestCells& cells, const Matrix3& rotation, const Positions& positions,
                              std::vector<Vector3>& missing, Vector3* shares) const {
    const Index first = layout_.ring_offsets[row];
    const Index valence = layout_.ring_offsets[row + 1] - first;
    const Vector3 own = positions.row(row);
    missing.resize(valence);
    for (Index k = 0; k < valence; ++k) {
        const Vector3 edge = own - Vector3(positions.row(layout_.ring[first + k]));
        missing[k] = rotation * cells.edges[first + k] - edge;
    }
    Vector3 pull = Vector3::Zero();
    for (Index k = 0; k < valence; ++k) {
        const Index before = k == 0 ? valence - 1 : k - 1;
        const Index after = k + 1 == valence ? 0 : k + 1;
        const Vector3 spoke = spokes_[first + k] * missing[k];
        pull += spoke;
        shares[k] = -spoke - rims_[first + k] * (missing[k] - missing[after]) -
                    rims_[first + before] * (missing[k] - missing[before]);
    }
    return pull;
}

void CellAssembly::solve(const RestCells& cells, const std::vector<Quaternion>& rotations, int threads,
                         const Execution& execution, Positions& positions) const {
    const Index vertices = layout_.vertex_count();
    std::vector<Vector3> shares(layout_.ring.size());  // of each half-edge, for the vertex that it leads to
    Positions sums(vertices, 3);
    SupernodalFactor::Workspace workspace;
    for (int pass = 0; pass < kPasses; ++pass) {
        parallel_for(vertices, threads, execution, [&](Index begin, Index end) {
            std::vector<Vector3> missing;
            for (Index v = begin; v < end; ++v) {
                sums.row(v) = pull_of(v, cells, rotations[v].toRotationMatrix(), positions, missing,
                                      shares.data() + layout_.ring_offsets[v])
                                  .transpose();
            }
        });
        parallel_for(vertices, threads, execution, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                Vector3 sum = sums.row(v);
                for (Index use = use_start_[v]; use < use_start_[v + 1]; ++use)
                    sum += shares[uses_[use]];
                sums.row(v) = sum.transpose();
            }
        });
        factor_.solve(sums, sums, threads, execution, workspace);
        positions += sums;
    }
}

}  // namespace meanvalue
