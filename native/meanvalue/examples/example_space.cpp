#include "meanvalue/examples/example_space.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/ring_encoder.h"
#include "meanvalue/linalg/procrustes.h"

namespace meanvalue {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
// About one for each limb and joint of a figure. More of them follow the anchors' noise.
constexpr Index kFunctions = 12;
// How far a function reaches, over the mean distance of a vertex from the second nearest center: with a smaller one
// there are steps between functions, with a larger one they are alike.
constexpr double kReach = 1.7;
// It reaches at least this many times the largest distance of a vertex from its nearest center: each vertex has one.
constexpr double kReachOverFarthest = 1.2;
// What weights cost, as a share of the mean diagonal of their normal matrix: their size, and their differences
// between functions that overlap.
constexpr double kSizeCost = 0.03;
constexpr double kDifferenceCost = 0.3;
// Vertices that weights are fitted to: as good as all of them from a few hundred for each weight on.
constexpr Index kSample = 6000;

/// The rotation that takes `from` onto `to`, as well as `weights` let it.
Matrix3 rotation_onto(const Vector3* from, const Vector3* to, const double* weights, Index count) {
    Matrix3 covariance = Matrix3::Zero();
    for (Index k = 0; k < count; ++k)
        covariance += weights[k] * to[k] * from[k].transpose();
    return closest_rotation(covariance);
}

/// Distances along edges from `source` (Dijkstra 1959); in a straight line to vertices that no edges lead to.
Eigen::ArrayXd distances_from(Index source, const Encoding& layout, const PositionsView& positions,
                              const Execution& execution) {
    Eigen::ArrayXd distance = Eigen::ArrayXd::Constant(positions.rows(), kFar);
    using Entry = std::pair<double, Index>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    distance[source] = 0.0;
    queue.emplace(0.0, source);
    for (std::size_t step = 0; !queue.empty(); ++step) {
        execution.check_every(step);
        const auto [here, vertex] = queue.top();
        queue.pop();
        if (here > distance[vertex]) continue;
        const EncodedRing ring = layout.ring_of(vertex);
        for (Index k = 0; k < ring.valence; ++k) {
            const Index next = ring.ring[k];
            const double there = here + (positions.row(vertex) - positions.row(next)).norm();
            if (!(there < distance[next])) continue;
            distance[next] = there;
            queue.emplace(there, next);
        }
    }
    return distance.isFinite().select(distance, (positions.rowwise() - positions.row(source)).rowwise().norm());
}

}  // namespace

SurfaceFunctions::SurfaceFunctions(const Encoding& layout, const PositionsView& positions,
                                   const Execution& execution) {
    if (positions.rows() == 0) return;
    Eigen::ArrayXd nearest = (positions.rowwise() - mean_row(positions).transpose()).rowwise().norm();
    Eigen::ArrayXd second = Eigen::ArrayXd::Constant(positions.rows(), kFar);
    std::vector<Eigen::ArrayXd> distances;  // from each center
    for (Eigen::Index center = 0; count < kFunctions; ++count) {
        execution.check();
        if (!(nearest.maxCoeff(&center) > 0.0) && count > 0) break;
        distances.push_back(distances_from(static_cast<Index>(center), layout, positions, execution));
        if (count > 0) second = second.min(nearest.max(distances.back()));
        nearest = count > 0 ? nearest.min(distances.back()).eval() : distances.back();
    }
    const double mean = count > 1 ? second.mean() : 0.0;
    const double reach = std::max(kReach * mean, kReachOverFarthest * nearest.maxCoeff());
    values = grouped<Value>(positions.rows(), [&](const auto& add) {
        for (Index v = 0; v < positions.rows(); ++v) {
            execution.check_every(v);
            double total = 0.0;
            const auto bell = [&](Index c) {
                const double share = reach > 0.0 ? std::min(1.0, distances[c](v) / reach) : 0.0;
                const double root = (1.0 - share * share) * (1.0 - share * share);
                return root * root;
            };
            for (Index c = 0; c < count; ++c)
                total += bell(c);
            for (Index c = 0; c < count; ++c)
                if (bell(c) > 0.0) add(v, {c, bell(c) / total});
        }
    });
}

ExampleSpace::ExampleSpace(const Encoding& rest, const SurfaceFunctions& functions, const PositionsView& positions,
                           const std::vector<Positions>& shapes, int threads, const Execution& execution)
    : rest_(rest),
      count_(static_cast<Index>(shapes.size())),
      functions_(functions),
      cells_(rest_cells(rest_, positions, threads, execution)),
      cell_weights_(rest_.ring.size()),
      differences_(rest_.ring.size() * count_),
      softening_(rest_.softening.size() * count_) {
    parallel_for(rest_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        std::vector<Spoke> spokes;
        for (Index v = begin; v < end; ++v) {
            const Index first = rest_.ring_offsets[v];
            const Index valence = rest_.ring_offsets[v + 1] - first;
            spokes.resize(valence);
            measure_spokes(cells_.edges.data() + first, valence, spokes.data());
            for (Index k = 0; k < valence; ++k)
                cell_weights_[first + k] = spokes[k].spoke;
        }
    });
    for (Index example = 0; example < count_; ++example)
        measure(example, shapes[example], threads, execution);
    std::vector<Index> vertices;
    for (Index v = 0; v < rest_.vertex_count(); ++v) {
        if (rest_.predictable(v)) vertices.push_back(v);
    }
    const std::size_t step = std::max<std::size_t>(1, vertices.size() / kSample);
    for (std::size_t k = 0; k < vertices.size(); k += step)
        sample_.push_back(vertices[k]);
    factorise(execution);
}

void ExampleSpace::measure(std::size_t example, const PositionsView& shape, int threads, const Execution& execution) {
    const RestCells cells = rest_cells(rest_, shape, threads, execution);
    parallel_for(rest_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        RingEncoder encoder(shape);
        for (Index v = begin; v < end; ++v) {
            if (!rest_.predictable(v)) continue;
            const Index first = rest_.ring_offsets[v];
            const Index valence = rest_.ring_offsets[v + 1] - first;
            const Vector3* const rest_edges = cells_.edges.data() + first;
            const Matrix3 rotation =
                rotation_onto(cells.edges.data() + first, rest_edges, cell_weights_.data() + first, valence);
            for (Index k = 0; k < valence; ++k) {
                const Vector3 edge = rotation * cells.edges[first + k] - rest_edges[k];
                Difference& difference = differences_[static_cast<std::size_t>(first + k) * count_ + example];
                for (int c = 0; c < 3; ++c)
                    difference.edge[c] = static_cast<float>(edge[c]);
            }
            const EncodedRing ring = rest_.ring_of(v);
            const std::uint8_t flags = encoder.encode(v, ring.ring, valence);
            // Where it can't be encoded as the rest shape is, or both are steep, it has no difference.
            if ((flags & (kNotPredictable | kSteepEdge)) != 0 || ring.normal_weights != nullptr) continue;
            for (Index k = 0; k < valence; ++k) {
                Difference& difference = differences_[static_cast<std::size_t>(first + k) * count_ + example];
                difference.weight = static_cast<float>(encoder.weights()[k] - ring.weights[k]);
                difference.height = static_cast<float>(encoder.heights()[k] - ring.heights[k]);
            }
            softening_[static_cast<std::size_t>(v) * count_ + example] =
                static_cast<float>(encoder.softening() - ring.softening);
        }
    });
}

void ExampleSpace::factorise(const Execution& execution) {
    const Eigen::Index size = Eigen::Index{functions_.count} * count_;
    if (size == 0) return;
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
    Eigen::MatrixXd overlap = Eigen::MatrixXd::Zero(functions_.count, functions_.count);
    Eigen::MatrixXd of_vertex(count_, count_);
    Eigen::MatrixXd edges(3, count_);
    for (const Index v : sample_) {
        execution.check();
        of_vertex.setZero();
        for (Index half_edge = rest_.ring_offsets[v]; half_edge < rest_.ring_offsets[v + 1]; ++half_edge) {
            const Difference* const of = differences_of(half_edge);
            for (Index e = 0; e < count_; ++e)
                edges.col(e) << of[e].edge[0], of[e].edge[1], of[e].edge[2];
            of_vertex += cell_weights_[half_edge] * edges.transpose().lazyProduct(edges);
        }
        for (const auto& a : functions_.values.of(v)) {
            for (const auto& b : functions_.values.of(v)) {
                normal.block(a.function * count_, b.function * count_, count_, count_) +=
                    a.value * b.value * of_vertex;
                if (a.function != b.function) overlap(a.function, b.function) += a.value * b.value;
            }
        }
    }
    const double scale = normal.diagonal().mean();
    const Eigen::VectorXd degrees = overlap.rowwise().sum();
    const double mean_degree = degrees.mean();
    for (Index a = 0; a < functions_.count; ++a) {
        for (Index b = 0; b < functions_.count; ++b) {
            const double laplacian = a == b ? degrees[a] : -overlap(a, b);
            const double cost = mean_degree > 0.0 ? kDifferenceCost * laplacian / mean_degree : 0.0;
            normal.block(a * count_, b * count_, count_, count_).diagonal().array() +=
                scale * (cost + (a == b ? kSizeCost : 0.0));
        }
    }
    factor_.compute(normal);
}

ExampleWeights ExampleSpace::fit(const PositionsView& shape, int threads, const Execution& execution) const {
    const auto count = static_cast<Index>(sample_.size());
    if (functions_.count == 0) return ExampleWeights(0, count_);
    Eigen::MatrixXd pulls(count_, count);  // of each sampled vertex
    parallel_for(count, threads, execution, [&](Index begin, Index end) {
        std::vector<Vector3> edges;
        for (Index s = begin; s < end; ++s) {
            const Index v = sample_[s];
            const Index first = rest_.ring_offsets[v];
            const Index valence = rest_.ring_offsets[v + 1] - first;
            edges.resize(valence);
            for (Index k = 0; k < valence; ++k)
                edges[k] = (shape.row(v) - shape.row(rest_.ring[first + k])).transpose();
            const Vector3* const rest_edges = cells_.edges.data() + first;
            const Matrix3 rotation = rotation_onto(edges.data(), rest_edges, cell_weights_.data() + first, valence);
            pulls.col(s).setZero();
            for (Index k = 0; k < valence; ++k) {
                const Vector3 difference = cell_weights_[first + k] * (rotation * edges[k] - rest_edges[k]);
                const Difference* const of = differences_of(first + k);
                for (Index e = 0; e < count_; ++e)
                    pulls(e, s) += of[e].edge[0] * difference.x() + of[e].edge[1] * difference.y() +
                                   of[e].edge[2] * difference.z();
            }
        }
    });
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count_, functions_.count);
    for (Index s = 0; s < count; ++s) {
        for (const auto& [function, value] : functions_.values.of(sample_[s]))
            right.col(function) += value * pulls.col(s);
    }
    const Eigen::VectorXd solved = factor_.solve(Eigen::Map<const Eigen::VectorXd>(right.data(), right.size()));
    return Eigen::Map<const Eigen::MatrixXd>(solved.data(), count_, functions_.count).transpose();
}

void ExampleSpace::find_shares(Index vertex, const ExampleWeights& weights, Eigen::VectorXd& shares) const {
    shares.setZero(count_);
    for (const auto& [function, value] : functions_.values.of(vertex))
        shares += value * weights.row(function).transpose();
}

void ExampleSpace::blend(const ExampleWeights& weights, int threads, const Execution& execution, Encoding& encoding,
                         RestCells& cells) const {
    parallel_for(rest_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        Eigen::VectorXd shares;
        for (Index v = begin; v < end; ++v) {
            if (!rest_.predictable(v)) continue;
            find_shares(v, weights, shares);
            for (Index half_edge = rest_.ring_offsets[v]; half_edge < rest_.ring_offsets[v + 1]; ++half_edge) {
                const Difference* const of = differences_of(half_edge);
                Vector3 edge = cells_.edges[half_edge];
                double weight = rest_.weights[half_edge];
                double height = rest_.heights[half_edge];
                for (Index e = 0; e < count_; ++e) {
                    edge += shares[e] * Vector3(of[e].edge[0], of[e].edge[1], of[e].edge[2]);
                    weight += shares[e] * of[e].weight;
                    height += shares[e] * of[e].height;
                }
                cells.edges[half_edge] = edge;
                encoding.weights[half_edge] = weight;
                encoding.heights[half_edge] = height;
            }
            double softening = rest_.softening[v];
            for (Index e = 0; e < count_; ++e)
                softening += shares[e] * softening_[static_cast<std::size_t>(v) * count_ + e];
            encoding.softening[v] = std::max(0.0, softening);
        }
    });
}

void ExampleSpace::weights_at(Index vertex, const ExampleWeights& weights, double* shares) const {
    Eigen::VectorXd of_examples;
    find_shares(vertex, weights, of_examples);
    shares[0] = 1.0 - of_examples.sum();
    std::copy_n(of_examples.data(), count_, shares + 1);
}

}  // namespace meanvalue
