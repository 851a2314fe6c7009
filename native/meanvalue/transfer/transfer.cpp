#include "meanvalue/transfer/transfer.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <utility>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/follow/carrier_surface.h"
#include "meanvalue/linalg/closest_rotation.h"
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
// What holds a vertex that rests, and how much a gap that counts fully holds against the surface.
constexpr double kHold = 1e3, kStrength = 30.0;
// What is near, in edges; faces each other, and is in front, both cosines.
constexpr double kNear = 1.5, kFacing = 0.2, kInFront = 0.3;
// Gaps are closed up to this share, each step for one solve with the factor.
constexpr double kLeft = 1e-8;
constexpr int kMostSteps = 200;
// A triangle that grows by so much more than the whole was not mapped, it has collapsed. Where all have, the mean
// counts.
constexpr double kMostGrowth = 8.0, kLeastArea = 1e-6;
// Weights in single precision have the sum 1 up to this.
constexpr double kWeightError = 1e-4;

using Flat = Eigen::Matrix<double, 1, 9>;

void require_input(const TransferBinding& binding, const std::vector<SharedPositions>& shapes,
                   const std::vector<char>& closes) {
    require_mesh(*binding.source_rest, *binding.source_faces, "source_rest", "source_faces");
    require_mesh(*binding.target_rest, *binding.target_faces, "target_rest", "target_faces");
    const Index count = static_cast<Index>(binding.target_rest->rows());
    require_count("correspondence[0]", binding.faces.size(), "face", count, "vertices of the target");
    require_count("correspondence[1]", binding.weights.rows(), "row", count, "vertices of the target");
    for (Index v = 0; v < count; ++v) {
        if (binding.faces[v] < 0 || binding.faces[v] >= binding.source_faces->rows()) {
            throw InvalidInput(message("correspondence[0] has face ", binding.faces[v], " for vertex ", v,
                                       ", but source_faces has ", binding.source_faces->rows(), " triangles"));
        }
        if (!(std::abs(binding.weights.row(v).sum() - 1.0) < kWeightError)) {
            throw InvalidInput(message("correspondence[1] has ", binding.weights.row(v), " for vertex ", v,
                                       "; give finite weights with the sum 1"));
        }
    }
    if (shapes.empty()) throw InvalidInput("source_shapes is empty; give one shape or more");
    for (std::size_t s = 0; s < shapes.size(); ++s) {
        const std::string name = message("source_shapes[", s, "]");
        require_count(name.c_str(), shapes[s]->rows(), "row", binding.source_rest->rows(), "vertices of the source");
        require_finite(*shapes[s], name.c_str());
        require_moderate_extent(*shapes[s]);
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

/// A connected part of the target on one of the source, both by their vertices.
struct PartPair {
    std::vector<Index> source, target;
    Similarity placed;
};

class Transfer {
  public:
    Transfer(const TransferBinding& binding, int threads, const Execution& execution);

    /// @param shape of the source.
    Positions carried(const Positions& shape, bool closes, const Execution& execution) const;

  private:
    Positions places_of(const Positions& of) const;
    void measure(int threads, const Execution& execution);
    SparseCholesky factor(const Eigen::VectorXd& diagonal, const Execution& execution) const;
    std::vector<Matrix3> local_maps(double length, const Execution& execution) const;
    void pair_parts(const Execution& execution);
    bool carry_part(const PartPair& part, const Positions& shape, double least, Positions& result) const;
    void close_gaps(const Positions& offsets, double largest, const std::vector<char>& rests, Positions& result,
                    const Execution& execution) const;

    const TransferBinding& binding_;
    const Positions& rest_;
    const Triangles& faces_;
    const Positions source_;  // at the vertices of the target
    const double size_;
    const std::vector<Index> one_part_;
    const CarrierSurface surface_;  // of the target
    SparseMatrix laplacian_;        // the lower triangle, of cotangents
    Eigen::VectorXd areas_;         // n: a third of those of the faces around each vertex, never 0
    SparseCholesky analysed_{InstructionSet::kPortable};
    std::vector<Matrix3> maps_;   // from the source to the target: of offsets
    std::vector<Matrix3> turns_;  // rotations with their sizes: of gaps
    std::vector<PartPair> parts_;
};

Transfer::Transfer(const TransferBinding& binding, int threads, const Execution& execution)
    : binding_(binding),
      rest_(*binding.target_rest),
      faces_(*binding.target_faces),
      source_(places_of(*binding.source_rest)),
      size_(bounding_box_diagonal(rest_)),
      one_part_(rest_.rows(), 0),
      surface_(rest_, faces_, one_part_, {1}, execution),
      laplacian_(rest_.rows(), rest_.rows()),
      areas_(Eigen::VectorXd::Zero(rest_.rows())) {
    measure(threads, execution);
    maps_ = local_maps(kMapLength * size_, execution);
    turns_ = local_maps(kRotationLength * size_, execution);
    for (Matrix3& turn : turns_) {
        const Matrix3 rotation = closest_rotation(turn);
        turn = (rotation.transpose() * turn).trace() / 3.0 * rotation;
    }
    pair_parts(execution);
}

Positions Transfer::places_of(const Positions& of) const {
    Positions places(binding_.weights.rows(), 3);
    for (Index v = 0; v < places.rows(); ++v) {
        const auto weights = binding_.weights.row(v);
        places.row(v) = weights / weights.sum() * of(binding_.source_faces->row(binding_.faces[v]), Eigen::all);
    }
    return places;
}

void Transfer::measure(int threads, const Execution& execution) {
    std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries;
    for (Index f = 0; f < faces_.rows(); ++f) {
        execution.check_every(f);
        Matrix3 edges;  // opposite to each corner
        for (int k = 0; k < 3; ++k)
            edges.col(k) = rest_.row(faces_(f, (k + 2) % 3)) - rest_.row(faces_(f, (k + 1) % 3));
        const double area = 0.5 * edges.col(0).cross(edges.col(1)).norm();
        const double least = std::max(kCoincident * edges.squaredNorm(), std::numeric_limits<double>::min());
        for (int k = 0; k < 3; ++k) {
            const Index a = faces_(f, (k + 1) % 3), b = faces_(f, (k + 2) % 3);
            const double weight = -edges.col((k + 1) % 3).dot(edges.col((k + 2) % 3)) / std::max(4.0 * area, least);
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
    analysed_.analyse(laplacian_, execution, threads);
}

/// Of the Laplacian with this added to its diagonal.
SparseCholesky Transfer::factor(const Eigen::VectorXd& diagonal, const Execution& execution) const {
    SparseMatrix lower = laplacian_;
    lower.diagonal() += diagonal;
    SparseCholesky result = analysed_.with_same_pattern();
    if (!result.factorise(std::move(lower), execution))
        throw SolverFailure(message("the Laplacian of ", diagonal.size(), " vertices is not positive definite"));
    return result;
}

/// From around each vertex of the source to there on the target, low-passed. Exact where one map does for all.
std::vector<Matrix3> Transfer::local_maps(double length, const Execution& execution) const {
    const double growth = size_ / bounding_box_diagonal(source_);
    if (!std::isfinite(growth))
        throw InvalidInput("correspondence has one place for all vertices; give each its own");
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(rest_.rows(), 9);
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(rest_.rows());
    for (Index f = 0; f < faces_.rows(); ++f) {
        const Matrix3 frame = frame_of(rest_, faces_, f);
        const Matrix3 map = frame * frame_of(source_, faces_, f).inverse();
        if (!(map.norm() < kMostGrowth * growth)) continue;
        for (const Index corner : faces_.row(f)) {
            sums.row(corner) += frame.col(2).squaredNorm() * Eigen::Map<const Flat>(map.data());
            weights[corner] += frame.col(2).squaredNorm();
        }
    }
    const Matrix3 whole = growth * Matrix3::Identity();
    const Flat mean =
        weights.sum() > 0.0 ? Flat(sums.colwise().sum() / weights.sum()) : Flat(Eigen::Map<const Flat>(whole.data()));
    const Eigen::VectorXd least = kLeastArea * areas_;
    const double scale = 1.0 / (length * length);
    sums = scale * (sums / 6.0 + least * mean);
    const Eigen::MatrixXd smooth = factor(scale * (weights / 6.0 + least), execution).solve(sums, execution);
    std::vector<Matrix3> maps(rest_.rows());
    for (Index v = 0; v < rest_.rows(); ++v)
        Eigen::Map<Flat>(maps[v].data()) = smooth.row(v);
    return maps;
}

/// Each part of the target with that of the source where most of its vertices are.
void Transfer::pair_parts(const Execution& execution) {
    const auto parts_of = [&](const Positions& places, const Triangles& faces) {
        return find_components(places, faces, std::vector<char>(places.rows(), 0), execution).part_of;
    };
    const std::vector<Index> of_source = parts_of(*binding_.source_rest, *binding_.source_faces);
    const std::vector<Index> of_target = parts_of(rest_, faces_);
    std::map<Index, std::vector<Index>> sources, targets;
    for (std::size_t v = 0; v < of_source.size(); ++v)
        sources[of_source[v]].push_back(static_cast<Index>(v));
    for (std::size_t v = 0; v < of_target.size(); ++v)
        targets[of_target[v]].push_back(static_cast<Index>(v));
    for (const auto& [part, target] : targets) {
        std::map<Index, std::vector<Index>> on;
        for (const Index v : target)
            on[of_source[(*binding_.source_faces)(binding_.faces[v], 0)]].push_back(v);
        const auto most = std::max_element(on.begin(), on.end(), [](const auto& one, const auto& other) {
            return one.second.size() < other.second.size();
        });
        parts_.push_back({sources[most->first], target, fit_similarity(source_, rest_, most->second)});
    }
}

/// Where the source's part moves as one the target's does so too, as seen from where it lies beside that. What is
/// left goes by the maps. @return whether it does.
bool Transfer::carry_part(const PartPair& part, const Positions& shape, double least, Positions& result) const {
    const Positions& source = *binding_.source_rest;
    const Similarity motion = fit_similarity(source, shape, part.source);
    double largest = 0.0, off = 0.0;
    for (const Index v : part.source) {
        largest = std::max(largest, (shape.row(v) - source.row(v)).norm());
        off = std::max(off, (motion.apply(source.row(v)) - shape.row(v).transpose()).norm());
    }
    if (!(largest > least && off < kRigid * largest)) return false;
    const Similarity& placed = part.placed;
    for (const Index v : part.target) {
        const Vector3 there = placed.rotation.transpose() * (rest_.row(v).transpose() - placed.translation);
        result.row(v) = placed.apply(motion.apply(there / placed.scale));
    }
    return true;
}

/// Moves what meets on the source by the least change that its gaps there want: with E the gaps along the directions
/// in which they close, each times the root of what it counts, and H the Laplacian with what holds,
///     (E H^-1 E^T + 1 / strength) pulls = wanted - E result, by conjugate gradients.
void Transfer::close_gaps(const Positions& offsets, double largest, const std::vector<char>& rests, Positions& result,
                          const Execution& execution) const {
    const Positions shape = source_ + offsets;
    const CarrierSurface surface(shape, faces_, one_part_, {1}, execution);
    std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries;
    std::vector<Vector3> directions;
    std::vector<double> gaps;
    for (Index v = 0; v < shape.rows(); ++v) {
        execution.check_every(v);
        const Vector3 facing = -surface.normals()[v];
        const double near = kNear * surface.mean_edge(v);
        TriangleTree::Query query;
        query.point = shape.row(v);
        query.normal = &facing;
        query.least_cosine = kFacing;
        const TriangleTree::Place place = surface.tree().nearest(query, near);
        if (place.triangle < 0 || (faces_.row(place.triangle).array() == v).any()) continue;
        const auto gap_of = [&](const Positions& positions) -> Vector3 {
            return positions(faces_.row(place.triangle), Eigen::all).transpose() * place.weights -
                   positions.row(v).transpose();
        };
        const Vector3 open = turns_[v] * gap_of(source_), closed = turns_[v] * gap_of(shape);
        const double size = turns_[v].col(0).norm(), before = open.norm() / size, after = closed.norm() / size;
        if (!(after < before) || gap_of(shape).dot(facing) > -kInFront * after) continue;
        const Vector3 other = gap_of(rest_) - open;
        const double weight = (1.0 - after / near) * smooth_step(1.0 - after / before, 0.6, 0.9) *
                              smooth_step((before - after) / largest, 0.1, 0.3) *
                              std::clamp(3.0 - 2.0 * other.norm() / open.norm(), 0.0, 1.0);
        if (!(weight > 0.0)) continue;
        const auto row = static_cast<Index>(gaps.size());
        directions.push_back(std::sqrt(weight) * (open - closed).normalized());
        gaps.push_back(directions.back().dot(closed + after / before * other));
        entries.emplace_back(row, v, -1.0);
        for (int k = 0; k < 3; ++k)
            entries.emplace_back(row, faces_(place.triangle, k), place.weights[k]);
    }
    const auto count = static_cast<Eigen::Index>(gaps.size());
    if (count == 0) return;
    SparseMatrix between(count, shape.rows());
    between.setFromTriplets(entries.begin(), entries.end());
    const Eigen::Map<const Positions> along(directions.front().data(), count, 3);
    const auto along_of = [&](const Positions& positions) -> Eigen::VectorXd {
        return (between * positions).cwiseProduct(along).rowwise().sum();
    };
    Eigen::VectorXd diagonal = areas_ / (kPullLength * kPullLength * size_ * size_);
    for (Index v = 0; v < shape.rows(); ++v) {
        const double edge = surface_.mean_edge(v);
        if (rests[v] && edge > 0.0) diagonal[v] += kHold * areas_[v] / (edge * edge);
    }
    const SparseCholesky energy = factor(diagonal, execution);
    SparseCholesky::Workspace workspace;
    const auto moved_by = [&](const Eigen::VectorXd& pulls) {
        Positions moved = between.transpose() * (pulls.asDiagonal() * along);
        energy.solve(moved, moved, 1, execution, workspace);
        return moved;
    };
    Eigen::VectorXd pulls = Eigen::VectorXd::Zero(count);
    Eigen::VectorXd left = Eigen::Map<const Eigen::VectorXd>(gaps.data(), count) - along_of(result);
    Eigen::VectorXd direction = left;
    double square = left.squaredNorm();
    const double least = std::pow(std::max(kLeft * std::sqrt(square), kRounding * size_), 2);
    for (int step = 0; step < kMostSteps && square > least; ++step) {
        const Eigen::VectorXd product = along_of(moved_by(direction)) + direction / kStrength;
        const double length = square / direction.dot(product);
        pulls += length * direction;
        left -= length * product;
        const double ratio = left.squaredNorm() / square;
        square *= ratio;
        direction = left + ratio * direction;
    }
    const Positions moved = moved_by(pulls);
    for (Index v = 0; v < shape.rows(); ++v) {
        if (!rests[v]) result.row(v) += moved.row(v);
    }
}

Positions Transfer::carried(const Positions& shape, bool closes, const Execution& execution) const {
    const Positions offsets = places_of(shape - *binding_.source_rest);
    const double largest = offsets.rowwise().norm().maxCoeff();
    Positions result = rest_;
    if (!(largest > kRounding * bounding_box_diagonal(source_))) return result;
    std::vector<char> rests(result.rows());
    for (Index v = 0; v < result.rows(); ++v) {
        result.row(v) += maps_[v] * offsets.row(v).transpose();
        rests[v] = !(offsets.row(v).norm() > kResting * largest);
    }
    for (const PartPair& part : parts_) {
        if (!carry_part(part, shape, kResting * largest, result)) continue;
        for (const Index v : part.target)
            rests[v] = 1;
    }
    if (closes) close_gaps(offsets, largest, rests, result, execution);
    return result;
}

}  // namespace

Positions transfer(const TransferBinding& binding, const std::vector<SharedPositions>& shapes,
                   const std::vector<char>& closes, Execution& execution) {
    pin_eigen_cache_sizes();
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
