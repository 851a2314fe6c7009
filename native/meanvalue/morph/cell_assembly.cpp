#include "meanvalue/morph/cell_assembly.h"

#include <algorithm>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/rest_cells.h"
#include "meanvalue/mesh/disjoint_sets.h"

namespace meanvalue {
namespace {

// The factor is in single precision: a second pass solves for the residual of the first.
constexpr int kPasses = 2;
// Weight of rims against spokes. At 0 and at 1 more triangles are turned over (docs/decisions).
constexpr double kRimShare = 0.3;

}  // namespace

void factor_laplacian(Index vertices, std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries,
                      int threads, const Execution& execution, SupernodalFactor& factor) {
    DisjointSets parts(vertices);
    std::vector<double> diagonal(vertices, 0.0);
    for (const auto& entry : entries) {
        parts.join(entry.row(), entry.col());
        for (const Index v : {entry.row(), entry.col()})
            diagonal[v] -= entry.value();
    }
    for (Index v = 0; v < vertices; ++v) {
        const double held = parts.root(v) == v ? 2.0 : 1.0;
        entries.emplace_back(v, v, diagonal[v] > 0.0 ? held * diagonal[v] : 1.0);
    }
    SparseMatrix lower(vertices, vertices);
    execution.check();
    lower.setFromTriplets(entries.begin(), entries.end());
    factor.analyse(lower, execution, threads);
    if (!factor.factorise(lower, execution, threads))
        throw SolverFailure(message("the Laplacian of ", vertices, " vertices is not positive definite"));
}

CellAssembly::CellAssembly(const OneRings& rings, const std::vector<Vector3>& edges, InstructionSet instructions,
                           int threads, const Execution& execution)
    : rings_(rings), factor_(instructions) {
    measure(edges, threads, execution);
    std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries;
    entries.reserve(2 * rings_.vertices.size() + rings_.vertex_count());
    const auto add = [&](Index a, Index b, double weight) {
        entries.emplace_back(std::max(a, b), std::min(a, b), -weight);
    };
    for (Index v = 0; v < rings_.vertex_count(); ++v) {
        execution.check_every(v);
        const Index first = rings_.offsets[v], last = rings_.offsets[v + 1];
        for (Index k = first; k < last; ++k) {
            add(v, rings_.vertices[k], spokes_[k]);
            add(rings_.vertices[k], rings_.vertices[k + 1 == last ? first : k + 1], rims_[k]);
        }
    }
    factor_laplacian(rings_.vertex_count(), std::move(entries), threads, execution, factor_);
}

void CellAssembly::measure(const std::vector<Vector3>& edges, int threads, const Execution& execution) {
    spokes_.resize(rings_.vertices.size());
    rims_.resize(rings_.vertices.size());
    parallel_for(rings_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        std::vector<Spoke> spokes;
        for (Index v = begin; v < end; ++v) {
            const Index first = rings_.offsets[v];
            const Index valence = rings_.valence(v);
            if (valence == 0) continue;
            spokes.resize(valence);
            measure_spokes(edges.data() + first, valence, spokes.data());
            for (Index k = 0; k < valence; ++k) {
                spokes_[first + k] = spokes[k].spoke;
                rims_[first + k] = kRimShare * spokes[k].rim;
            }
        }
    });
}

/// Minus the derivative of the energy of one row by its own vertex. @param shares receives the same by each ring
/// vertex.
Vector3 CellAssembly::pull_of(Index row, const std::vector<Vector3>& edges, const Matrix3& rotation,
                              const Positions& positions, std::vector<Vector3>& missing, Vector3* shares) const {
    const Index first = rings_.offsets[row];
    const Index valence = rings_.valence(row);
    const Vector3 own = positions.row(row);
    missing.resize(valence);
    for (Index k = 0; k < valence; ++k) {
        const Vector3 edge = own - Vector3(positions.row(rings_.vertices[first + k]));
        missing[k] = rotation * edges[first + k] - edge;
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

void CellAssembly::solve(const std::vector<Vector3>& edges, const std::vector<Quaternion>& rotations, int threads,
                         const Execution& execution, Positions& positions) const {
    const Index vertices = rings_.vertex_count();
    std::vector<Vector3> shares(rings_.vertices.size());  // of each half-edge, for the vertex that it leads to
    Positions sums(vertices, 3);
    SupernodalFactor::Workspace workspace;
    for (int pass = 0; pass < kPasses; ++pass) {
        parallel_for(vertices, threads, execution, [&](Index begin, Index end) {
            std::vector<Vector3> missing;
            for (Index v = begin; v < end; ++v) {
                sums.row(v) = pull_of(v, edges, rotations[v].toRotationMatrix(), positions, missing,
                                      shares.data() + rings_.offsets[v])
                                  .transpose();
            }
        });
        execution.check();
        for (std::size_t place = 0; place < shares.size(); ++place)
            sums.row(rings_.vertices[place]) += shares[place].transpose();
        factor_.solve(sums, sums, threads, execution, workspace);
        positions += sums;
    }
}

}  // namespace meanvalue
