#include <algorithm>
#include <cmath>
#include <utility>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/rest_cells.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/morph/rotation_vectors.h"
#include "meanvalue/morph/shape_overlay.h"

namespace meanvalue {
namespace {

void edges_of(const OneRings& rings, const PositionsView& shape, Index vertex, Vector3* edges) {
    for (const Index* neighbour = rings.begin(vertex); neighbour != rings.end(vertex); ++neighbour)
        *edges++ = (shape.row(vertex) - shape.row(*neighbour)).transpose();
}

Eigen::ArrayXd squared_edges(const OneRings& rings, const PositionsView& shape) {
    Eigen::ArrayXd result(static_cast<Index>(rings.vertices.size()));
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        for (Index place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place)
            result[place] = (shape.row(v) - shape.row(rings.vertices[place])).squaredNorm();
    }
    return result;
}

/// The sum over a cell of to * from^T. Edges count as in the energy: with cotangent weights the rotation of a cell is
/// that of the surface, however its edges lie.
Matrix3 covariance_of(const std::vector<Spoke>& from, const Vector3* to) {
    Matrix3 covariance = Matrix3::Zero();
    for (std::size_t k = 0; k < from.size(); ++k) {
        const std::size_t next = k + 1 == from.size() ? 0 : k + 1;
        covariance += to[k] * (from[k].spoke * from[k].rest).transpose() +
                      (to[k] - to[next]) * (from[k].rim * (from[k].rest - from[next].rest)).transpose();
    }
    return covariance;
}

}  // namespace

LocalCells::LocalCells(const OneRings& rings, const std::vector<PositionsView>& shapes, int threads,
                       const Execution& execution)
    : rings_(rings), count_(shapes.size()) {
    std::vector<Quaternion> rotations = rotations_against(shapes, 0, threads, execution);
    const std::size_t central = central_shape(shapes, rotations, execution);
    measure_sizes(shapes, central, execution);
    if (central != 0) rotations = rotations_against(shapes, central, threads, execution);
    shape_rotations_.assign(count_, Quaternion::Identity());
    relative_.emplace(rings_, rotations, shape_rotations_, threads, execution);
    measure_edges(shapes, rotations, threads, execution);
}

/// An edge counts by how alike its shares of both shapes are: what one shape collapses does not make others longer.
void LocalCells::measure_sizes(const std::vector<PositionsView>& shapes, std::size_t central,
                               const Execution& execution) {
    const Eigen::ArrayXd reference = squared_edges(rings_, shapes[central]);
    for (const PositionsView& shape : shapes) {
        execution.check();
        const Eigen::ArrayXd squares = squared_edges(rings_, shape);
        const Eigen::ArrayXd growth = (squares * reference.sum()) / (reference * squares.sum());
        const Eigen::ArrayXd alike = (squares > 0.0).select(growth.min(1.0 / growth), 0.0);
        const double ratio = (alike * squares).sum() / (alike * reference).sum();
        sizes_.push_back(ratio > 0.0 ? std::sqrt(ratio) : 1.0);  // 1 where nothing is in both
    }
}

/// n x k: what takes the cells of one shape onto those of each.
std::vector<Quaternion> LocalCells::rotations_against(const std::vector<PositionsView>& shapes, std::size_t reference,
                                                      int threads, const Execution& execution) const {
    std::vector<Quaternion> result(rings_.vertex_count() * count_, Quaternion::Identity());
    parallel_for(rings_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        std::vector<Vector3> edges;
        std::vector<Spoke> spokes;
        std::vector<Matrix3> rotations(count_);
        for (Index v = begin; v < end; ++v) {
            if (rings_.valence(v) == 0) continue;
            edges.resize(rings_.valence(v));
            spokes.resize(rings_.valence(v));
            edges_of(rings_, shapes[reference], v, edges.data());
            measure_spokes(edges.data(), rings_.valence(v), spokes.data());
            for (std::size_t k = 0; k < count_; ++k) {
                edges_of(rings_, shapes[k], v, edges.data());
                rotations[k] = covariance_of(spokes, edges.data());
            }
            closest_rotations(rotations.data(), static_cast<Index>(count_));
            for (std::size_t k = 0; k < count_; ++k)
                result[v * count_ + k] = Quaternion(rotations[k]);
        }
    });
    return result;
}

/// The shape that agrees best with all others, each rotated onto it as a whole, and of two the larger: whatever their
/// order is.
std::size_t LocalCells::central_shape(const std::vector<PositionsView>& shapes,
                                      const std::vector<Quaternion>& rotations, const Execution& execution) const {
    std::vector<std::pair<double, double>> merits;  // agreement and size
    merits.reserve(count_);
    for (const PositionsView& shape : shapes)
        merits.emplace_back(0.0, squared_edges(rings_, shape).sum());
    for (std::size_t a = 0; a < count_; ++a) {
        for (std::size_t b = a + 1; b < count_; ++b) {
            execution.check();
            Matrix3 sum = Matrix3::Zero();
            for (std::size_t v = 0; v < rotations.size(); v += count_)
                sum += (rotations[v + b] * rotations[v + a].conjugate()).toRotationMatrix();
            const double agreement = closest_rotation(sum).cwiseProduct(sum).sum();
            merits[a].first += agreement;
            merits[b].first += agreement;
        }
    }
    return std::max_element(merits.begin(), merits.end()) - merits.begin();
}

/// The edges without what shape, cell and bend rotate them by.
void LocalCells::measure_edges(const std::vector<PositionsView>& shapes, const std::vector<Quaternion>& rotations,
                               int threads, const Execution& execution) {
    edges_.resize(rings_.vertices.size() * count_);
    parallel_for(rings_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            for (Index place = rings_.offsets[v]; place < rings_.offsets[v + 1]; ++place) {
                const Index to = rings_.vertices[place];
                for (std::size_t k = 0; k < count_; ++k) {
                    const Quaternion& own = rotations[v * count_ + k];
                    const Quaternion bend = half_way(own, rotations[to * count_ + k]);
                    const Vector3 edge = (shapes[k].row(v) - shapes[k].row(to)).transpose();
                    edges_[place * count_ + k] = (shape_rotations_[k] * own * bend).conjugate() * edge;
                }
            }
        }
    });
}

void LocalCells::fill(const ShapeWeights& weights, const std::vector<double>& sizes,
                      const std::vector<Quaternion>& frames, const Quaternion& rotation, int threads,
                      const Execution& execution, std::vector<Quaternion>& rotations,
                      std::vector<Vector3>& edges) const {
    relative_->fill(weights, frames, rotation, threads, execution, rotations);
    edges.resize(rings_.vertices.size());
    parallel_for(rings_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const double* const of = weights.of(v);
            for (Index place = rings_.offsets[v]; place < rings_.offsets[v + 1]; ++place) {
                Vector3 sum = Vector3::Zero();
                for (std::size_t k = 0; k < count_; ++k)
                    sum += (of[k] * sizes[k]) * edges_[place * count_ + k];
                edges[place] = half_way(rotations[v], rotations[rings_.vertices[place]]) * sum;
            }
        }
    });
}

std::vector<double> LocalCells::common_sizes(const std::vector<double>& weights) const {
    const double common = geometric_mean(sizes_, weights);
    std::vector<double> result;
    result.reserve(sizes_.size());
    for (const double size : sizes_)
        result.push_back(common / size);
    return result;
}

}  // namespace meanvalue
