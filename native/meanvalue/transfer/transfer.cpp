#include "meanvalue/transfer/transfer.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/follow/carrier_surface.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/mesh/components.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue {
namespace {

// Shares of the target's diagonal: over which maps and their rotations are low-passed, and how far what closes pulls.
constexpr double kMapLength = 0.09, kRotationLength = 0.045, kPullLength = 0.023;
// Shares of the largest offset: of what rests, and by how much a part that moves rigidly may differ from that.
constexpr double kResting = 1e-4, kRigid = 1e-3;
// What holds a vertex that rests, and a gap that counts fully, against the surface.
constexpr double kHold = 1e3, kStrength = 100.0;
// What is near, in edges; faces each other, and is in front, both cosines.
constexpr double kNear = 1.5, kFacing = 0.2, kInFront = 0.3;
// A triangle that grows by so much more than the whole was not mapped but collapsed: what is around it counts.
constexpr double kMostGrowth = 8.0, kLeastArea = 1e-6;
constexpr double kWeightError = 1e-4;  // of their sum, in single precision

using Flat = Eigen::Matrix<double, 1, 9>;
using Entries = std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>>;

void require_input(const TransferBinding& binding, const std::vector<SharedPositions>& shapes,
                   const std::vector<char>& closes) {
    require_mesh(*binding.source_rest, *binding.source_faces, "source_rest", "source_faces");
    require_mesh(*binding.target_rest, *binding.target_faces, "target_rest", "target_faces");
    const Index count = static_cast<Index>(binding.target_rest->rows());
    require_count("correspondence[0]", binding.faces.size(), "face", count, "vertices of the target");
    require_count("correspondence[1]", binding.weights.rows(), "row", count, "vertices of the target");
    for (Index v = 0; v < count; ++v) {
        const Index face = binding.faces[v], faces = static_cast<Index>(binding.source_faces->rows());
        if (face < 0 || face >= faces || !(std::abs(binding.weights.row(v).sum() - 1.0) < kWeightError)) {
            throw InvalidInput(message("correspondence has face ", face, " and weights ", binding.weights.row(v),
                                       " for vertex ", v, "; give one of the ", faces,
                                       " triangles of source_faces, and weights with the sum 1"));
        }
    }
    if (shapes.empty()) throw InvalidInput("source_shapes is empty; give one shape or more");
    for (std::size_t s = 0; s < shapes.size(); ++s) {
        const std::string name = message("source_shapes[", s, "]");
        require_count(name.c_str(), shapes[s]->rows(), "row", binding.source_rest->rows(), "vertices of the source");
        require_finite(*shapes[s], name.c_str());
    }
    require_count("close", closes.size(), "flag", shapes.size(), "shapes");
}

/// The edges of a triangle, and its normal of a length that grows with them.
Matrix3 frame_of(const PositionsView& positions, const TrianglesView& faces, Index f) {
    Matrix3 frame;
    for (int k : {0, 1})
        frame.col(k) = positions.row(faces(f, k + 1)) - positions.row(faces(f, 0));
    const Vector3 normal = frame.col(0).cross(frame.col(1));
    frame.col(2) = normal / std::sqrt(normal.norm());
    return frame;
}

double smooth_step(double x, double low, double high) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// A connected part of the target, those of its vertices that are on one part of the source, and how it lies there.
struct Part {
    std::vector<Index> vertices, seen;
    Similarity placed;
};

class Transfer {
  public:
    Transfer(const TransferBinding& binding, int threads, const Execution& execution)
        : binding_(binding),
          rest_(*binding.target_rest),
          faces_(*binding.target_faces),
          source_(places_of(*binding.source_rest)),
          size_(bounding_box_diagonal(rest_)),
          laplacian_(rest_.rows(), rest_.rows()),
          areas_(Eigen::VectorXd::Zero(rest_.rows())) {
        measure(threads, execution);
        maps_ = local_maps(kMapLength * size_, execution);
        turns_ = local_maps(kRotationLength * size_, execution);
        for (Matrix3& turn : turns_) {
            const Matrix3 rotation = closest_rotation(turn);
            turn = (rotation.transpose() * turn).trace() / 3.0 * rotation;
        }
        find_parts(execution);
    }

    /// @param shape of the source.
    Positions carried(const Positions& shape, bool closes, const Execution& execution) const {
        const Positions offsets = places_of(shape - *binding_.source_rest), there = source_ + offsets;
        const double largest = offsets.rowwise().norm().maxCoeff();
        Positions result = rest_;
        if (!(largest > kRounding * bounding_box_diagonal(source_))) return result;
        std::vector<char> rests(result.rows());
        for (Index v = 0; v < result.rows(); ++v) {
            result.row(v) += maps_[v] * offsets.row(v).transpose();
            rests[v] = !(offsets.row(v).norm() > kResting * largest);
        }
        for (const Part& part : parts_) {  // rigid ones go as they do on the source, seen from where they lie there
            const Similarity motion = fit_similarity(source_, there, part.seen);
            double most = 0.0, off = 0.0;
            for (const Index v : part.seen) {
                most = std::max(most, offsets.row(v).norm());
                off = std::max(off, (motion.apply(source_.row(v)) - there.row(v).transpose()).norm());
            }
            if (part.seen.size() < 3 || !(most > kResting * largest && off < kRigid * most)) continue;
            const Similarity& placed = part.placed;
            for (const Index v : part.vertices) {
                const Vector3 from = placed.rotation.transpose() * (rest_.row(v).transpose() - placed.translation);
                result.row(v) = placed.apply(motion.apply(from / placed.scale));
                rests[v] = 1;
            }
        }
        if (closes) close_gaps(there, largest, rests, result, execution);
        return result;
    }

  private:
    Positions places_of(const Positions& of) const {
        Positions places(binding_.weights.rows(), 3);
        for (Index v = 0; v < places.rows(); ++v) {
            const auto weights = binding_.weights.row(v);
            places.row(v) = weights / weights.sum() * of(binding_.source_faces->row(binding_.faces[v]), Eigen::all);
        }
        return places;
    }

    /// The Laplacian and areas.
    void measure(int threads, const Execution& execution) {
        Entries entries;
        for (Index f = 0; f < faces_.rows(); ++f) {
            execution.check_every(f);
            Matrix3 edges;  // opposite to each corner
            for (int k = 0; k < 3; ++k)
                edges.col(k) = rest_.row(faces_(f, (k + 2) % 3)) - rest_.row(faces_(f, (k + 1) % 3));
            const double area = 0.5 * edges.col(0).cross(edges.col(1)).norm();
            const double least = std::max(kCoincident * edges.squaredNorm(), std::numeric_limits<double>::min());
            for (int k = 0; k < 3; ++k) {
                const Index a = faces_(f, (k + 1) % 3), b = faces_(f, (k + 2) % 3);
                const double dot = -edges.col((k + 1) % 3).dot(edges.col((k + 2) % 3));
                const double weight = dot / std::max(4.0 * area, least);
                entries.emplace_back(std::max(a, b), std::min(a, b), -weight);
                entries.emplace_back(a, a, weight);
                entries.emplace_back(b, b, weight);
                areas_[faces_(f, k)] += area / 3.0;
            }
        }
        const double total = areas_.sum();
        if (!(total > 0.0)) throw InvalidInput("target_faces have no area; give the mesh that the shapes are for");
        areas_.array() += kLeastArea * total / static_cast<double>(areas_.size());
        for (Index v = 0; v < rest_.rows(); ++v)
            entries.emplace_back(v, v, 0.0);
        laplacian_.setFromTriplets(entries.begin(), entries.end());
        SparseCholesky analysed;
        analysed.analyse(laplacian_, execution, threads);
        order_ = analysed.pattern().order;
    }

    /// Of the Laplacian and this.
    SparseCholesky factor(const SparseMatrix& more, const Execution& execution) const {
        const SparseMatrix sum = laplacian_ + more;
        SparseCholesky result(InstructionSet::kPortable);
        result.analyse(sum, execution, 1, order_);
        if (!result.factorise(sum, execution))
            throw SolverFailure(message("the Laplacian of ", sum.rows(), " vertices is not positive definite"));
        return result;
    }

    /// From around each vertex of the source to there on the target, low-passed. Exact where one map does for all.
    std::vector<Matrix3> local_maps(double length, const Execution& execution) const {
        const double growth = size_ / bounding_box_diagonal(source_), scale = 1.0 / (length * length);
        Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(rest_.rows(), 9);
        Eigen::VectorXd weights = Eigen::VectorXd::Zero(rest_.rows());
        for (Index f = 0; f < faces_.rows(); ++f) {
            const Matrix3 frame = frame_of(rest_, faces_, f), map = frame * frame_of(source_, faces_, f).inverse();
            if (!(map.norm() < kMostGrowth * growth)) continue;
            const double share = frame.col(2).squaredNorm() / 6.0;
            for (const Index corner : faces_.row(f)) {
                sums.row(corner) += share * Eigen::Map<const Flat>(map.data());
                weights[corner] += share;
            }
        }
        if (!(weights.sum() > 0.0))
            throw InvalidInput("correspondence leaves no area; give each vertex its own place");
        const Flat mean = sums.colwise().sum() / weights.sum();
        // What has no area is held against what cotangents as large as its own leave of a zero.
        const Eigen::VectorXd least = kLeastArea * scale * areas_ + kRounding * laplacian_.diagonal().cwiseAbs();
        sums = scale * sums + least * mean;
        weights = scale * weights + least;
        sums = factor(SparseMatrix(weights.asDiagonal()), execution).solve(sums, execution);
        std::vector<Matrix3> maps(rest_.rows());
        for (Index v = 0; v < rest_.rows(); ++v)
            Eigen::Map<Flat>(maps[v].data()) = sums.row(v);
        return maps;
    }

    void find_parts(const Execution& execution) {
        const std::vector<char> none(std::max(binding_.source_rest->rows(), rest_.rows()), 0);
        const std::vector<Index> of_source =
            find_components(*binding_.source_rest, *binding_.source_faces, none, execution).part_of;
        const std::vector<Index> of_target = find_components(rest_, faces_, none, execution).part_of;
        std::map<Index, std::map<Index, std::vector<Index>>> pairs;
        for (Index v = 0; v < rest_.rows(); ++v)
            pairs[of_target[v]][of_source[(*binding_.source_faces)(binding_.faces[v], 0)]].push_back(v);
        for (const auto& [number, on] : pairs) {
            Part& part = parts_.emplace_back();
            for (const auto& [source, vertices] : on) {
                part.vertices.insert(part.vertices.end(), vertices.begin(), vertices.end());
                if (vertices.size() > part.seen.size()) part.seen = vertices;
            }
            part.placed = fit_similarity(source_, rest_, part.seen);
        }
    }

    /// Moves what meets on the source, `there`, by the least change that gives its gaps the length wanted, along the
    /// way in which they close.
    void close_gaps(const Positions& there, double largest, const std::vector<char>& rests, Positions& result,
                    const Execution& execution) const {
        const std::vector<Index> one_part(there.rows(), 0);
        const CarrierSurface surface(there, faces_, one_part, {1}, execution);
        Entries entries;
        std::vector<Vector3> missing;
        for (Index v = 0; v < there.rows(); ++v) {
            execution.check_every(v);
            const Vector3 facing = -surface.normals()[v];
            const double near = kNear * surface.mean_edge(v);
            const TriangleTree::Place place =
                surface.tree().nearest({there.row(v), TriangleTree::kNoPart, &facing, kFacing}, near);
            if (place.triangle < 0 || (faces_.row(place.triangle).array() == v).any()) continue;
            const auto gap_of = [&](const Positions& positions) -> Vector3 {
                return positions(faces_.row(place.triangle), Eigen::all).transpose() * place.weights -
                       positions.row(v).transpose();
            };
            const Vector3 open = turns_[v] * gap_of(source_), closed = turns_[v] * gap_of(there);
            const double size = turns_[v].col(0).norm(), before = open.norm() / size, after = closed.norm() / size;
            if (!(after < before) || gap_of(there).dot(facing) > -kInFront * after) continue;
            const Vector3 other = gap_of(rest_) - open, along = (open - closed).normalized();
            const double weight = (1.0 - after / near) * smooth_step(1.0 - after / before, 0.6, 0.9) *
                                  smooth_step((before - after) / largest, 0.1, 0.3) *
                                  std::clamp(3.0 - 2.0 * other.norm() / open.norm(), 0.0, 1.0);
            if (!(weight > 0.0)) continue;
            const auto row = static_cast<Index>(missing.size());
            const double root = std::sqrt(kStrength * weight);
            missing.push_back(root * along.dot(closed + after / before * other - gap_of(result)) * along);
            entries.emplace_back(row, v, -root);
            for (int k = 0; k < 3; ++k)
                entries.emplace_back(row, faces_(place.triangle, k), root * place.weights[k]);
        }
        if (missing.empty()) return;
        const auto count = static_cast<Eigen::Index>(missing.size());
        SparseMatrix between(count, there.rows());
        between.setFromTriplets(entries.begin(), entries.end());
        Eigen::VectorXd held = areas_ / (kPullLength * kPullLength * size_ * size_);
        for (Index v = 0; v < there.rows(); ++v)
            held[v] += rests[v] ? kHold : 0.0;
        const SparseMatrix more = SparseMatrix(between.transpose() * between).triangularView<Eigen::Lower>();
        Positions moved = between.transpose() * Eigen::Map<const Positions>(missing.front().data(), count, 3);
        SparseCholesky::Workspace workspace;
        factor(more + SparseMatrix(held.asDiagonal()), execution).solve(moved, moved, 1, execution, workspace);
        for (Index v = 0; v < there.rows(); ++v) {
            if (!rests[v]) result.row(v) += moved.row(v);
        }
    }

    const TransferBinding& binding_;
    const Positions& rest_;
    const Triangles& faces_;
    const Positions source_;  // at the vertices of the target
    const double size_;
    SparseMatrix laplacian_;      // the lower triangle, of cotangents
    Eigen::VectorXd areas_;       // n: a third of those of the faces around each vertex, never 0
    std::vector<Index> order_;    // of elimination
    std::vector<Matrix3> maps_;   // from the source to the target: of offsets
    std::vector<Matrix3> turns_;  // rotations with their sizes: of gaps
    std::vector<Part> parts_;
};

}  // namespace

Positions transfer(const TransferBinding& binding, const std::vector<SharedPositions>& shapes,
                   const std::vector<char>& closes, Execution& execution) {
    require_input(binding, shapes, closes);
    execution.begin_stage("shapes");
    const int threads = thread_count(binding.threads);
    const Transfer each(binding, threads, execution);
    const Eigen::Index count = binding.target_rest->rows();
    Positions result(count * static_cast<Eigen::Index>(shapes.size()), 3);
    std::atomic<std::size_t> done{0};
    parallel_items(shapes.size(), threads, execution, [&](int, std::size_t s) {
        result.middleRows(static_cast<Eigen::Index>(s) * count, count) =
            each.carried(*shapes[s], closes[s] != 0, execution);
        execution.set_progress(static_cast<double>(++done) / static_cast<double>(shapes.size()));
    });
    return result;
}

}  // namespace meanvalue
