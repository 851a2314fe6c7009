#include "reference/pyramid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/encoding/ring_encoder.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue::baselines {
namespace {

// Share of the way to its decoded place that a vertex goes in a sweep.
constexpr double kSweepShare = 0.7;
// Rounds of the implicit decoding of one vertex that is put back into the mesh.
constexpr int kSplitRounds = 5;
// An edge less than about 3 degrees off the normal: its cotangent is unbounded.
constexpr double kSteepestCotangent = 20.0;
// Weights must give the rest position back to this share of the ring's radius.
constexpr double kLargestError = 1e-9;

/// The pyramid of a vertex: v = sum_k weights_k v_k + n sum_k heights_k |v'_k - v'|, in the plane across the mean
/// normal n of its faces.
struct Pyramid {
    RingView faces;               ///< the ring that the normal is of
    std::vector<Index> ring;      ///< the same, or a wider one; empty where nothing spans a plane
    std::vector<double> weights;  ///< mean-value coordinates, or what stands in for them
    std::vector<double> heights;  ///< weight times cotangent, or what stands in for it where an edge is steep
};

/// Normalized sum of the unit normals of the faces at `vertex`; zero where they cancel or have no area.
/// Of the unit normals: the sum of the area vectors would be that of the ring polygon wherever the ring is closed,
/// and would not depend on the vertex.
Vector3 face_normal(const RingView& ring, const PositionsView& positions, Index vertex) {
    const Vector3 centre = positions.row(vertex);
    Vector3 sum = Vector3::Zero();
    for (Index k = 0; k < ring.triangle_count(); ++k) {
        const Vector3 edge = Vector3(positions.row(ring.vertices[k])) - centre;
        const Vector3 next = Vector3(positions.row(ring.vertices[(k + 1) % ring.valence])) - centre;
        sum += edge.cross(next).normalized();  // zero stays zero
    }
    return sum.normalized();
}

/// The ring as the vertex sees it across its normal.
ProjectedRing project(const Pyramid& pyramid, const PositionsView& positions, Index vertex, const Vector3& normal) {
    ProjectedRing seen;
    seen.normal = normal;
    for (const Index j : pyramid.ring) {
        const Vector3 edge = Vector3(positions.row(j) - positions.row(vertex));
        seen.height.push_back(normal.dot(edge));
        seen.tangential.emplace_back(edge - seen.height.back() * normal);
        seen.radius.push_back(seen.tangential.back().norm());
        seen.largest_radius = std::max(seen.largest_radius, seen.radius.back());
        seen.mean_radius += seen.radius.back() / static_cast<double>(pyramid.ring.size());
    }
    return seen;
}

double tangential_error(const ProjectedRing& seen, const std::vector<double>& weights) {
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < weights.size(); ++k)
        sum += weights[k] * seen.tangential[k];
    return sum.norm();
}

/// @param ring of the normal, or a wider one.
Pyramid encode_vertex(const RingView& faces, std::vector<Index> ring, const PositionsView& positions, Index vertex) {
    Pyramid pyramid{faces, std::move(ring), {}, {}};
    const Vector3 normal = face_normal(faces, positions, vertex);
    const ProjectedRing seen = project(pyramid, positions, vertex, normal);
    std::vector<double>& weights = pyramid.weights;
    if (pyramid.ring.empty() || normal.isZero(0.0)) return {faces, {}, {}, {}};
    mean_value_weights(seen, weights);
    if (!weights_are_tame(weights) || tangential_error(seen, weights) > kLargestError * seen.largest_radius)
        least_norm_weights(seen, weights);
    if (!(tangential_error(seen, weights) < kLargestError * seen.largest_radius)) return {faces, {}, {}, {}};
    double height = 0.0;  // of the vertex over the weighted mean of its ring
    bool steep = false;
    for (std::size_t k = 0; k < weights.size(); ++k) {
        height -= weights[k] * seen.height[k];
        steep = steep || std::abs(seen.height[k]) > kSteepestCotangent * seen.radius[k];
    }
    for (std::size_t k = 0; k < weights.size(); ++k) {
        const double radius = std::max(seen.radius[k], kLargestError * seen.largest_radius);
        const double radius_sum = seen.mean_radius * static_cast<double>(weights.size());
        pyramid.heights.push_back(steep ? height / radius_sum : -weights[k] * seen.height[k] / radius);
    }
    return pyramid;
}

/// From a vertex to its decoded place; zero where it has none.
Vector3 decoded_move(const Pyramid& pyramid, const Positions& positions, Index vertex) {
    if (pyramid.ring.empty()) return Vector3::Zero();
    const Vector3 normal = face_normal(pyramid.faces, positions, vertex);
    if (normal.isZero(0.0)) return Vector3::Zero();
    const Vector3 here = positions.row(vertex);
    Vector3 centre = Vector3::Zero();  // relative to here, so that nothing is lost far from the origin
    for (std::size_t k = 0; k < pyramid.ring.size(); ++k)
        centre += pyramid.weights[k] * (Vector3(positions.row(pyramid.ring[k])) - here);
    double height = 0.0;
    for (std::size_t k = 0; k < pyramid.ring.size(); ++k) {
        const Vector3 edge = Vector3(positions.row(pyramid.ring[k])) - here - centre;
        height += pyramid.heights[k] * (edge - normal.dot(edge) * normal).norm();
    }
    return centre + height * normal;
}

/// One damped Jacobi sweep over the free vertices; reads `from` alone.
/// @param longest_step no vertex moves farther. @param steps scratch, |V'|. @return the longest step made.
double sweep(const Setup& setup, const std::vector<Pyramid>& pyramids, double longest_step, const Positions& from,
             Positions& to, std::vector<double>& steps, const Execution& execution) {
    const std::vector<Index>& free = setup.unknowns.free;
    steps.resize(free.size());
    parallel_for(static_cast<Index>(free.size()), setup.threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            Vector3 move = kSweepShare * decoded_move(pyramids[k], from, free[k]);
            const double length = move.norm();
            if (length > longest_step) move *= longest_step / length;
            steps[k] = std::min(length, longest_step);
            to.row(free[k]) = from.row(free[k]) + move.transpose();
        }
    });
    return steps.empty() ? 0.0 : *std::max_element(steps.begin(), steps.end());
}

/// The hierarchical decoding: the coarsest mesh in place, then vertex after vertex put back where its pyramid
/// coordinates, taken in the mesh that it was removed from, say. @return n x 3.
Positions decode_hierarchy(const Problem& problem, const Setup& setup, Execution& execution) {
    const Region region = surroundings_of_free(problem.vertices, problem.faces, setup.is_fixed, execution);
    const Index vertex_count = static_cast<Index>(region.vertices.size());
    const OneRings rings = collect_one_rings(vertex_count, region.faces, execution);
    const Hierarchy hierarchy =
        build_hierarchy(rings, region.positions, region.is_fixed, {}, setup.threads, execution);
    Positions positions(vertex_count, 3);
    for (Index v = 0; v < vertex_count; ++v)
        positions.row(v) = setup.start.row(region.vertices[v]);
    const Splits& splits = hierarchy.levels.back().splits;
    const Encoding encoding = encode(splits.rings, region.positions, setup.threads, execution);
    for (const Index vertex : splits.vertices) {
        execution.check_every(vertex);
        const EncodedRing ring = encoding.ring_of(vertex);
        const Pyramid pyramid = encode_vertex({ring.ring, ring.valence, splits.rings.closed[vertex] != 0},
                                              {ring.ring, ring.ring + ring.valence}, region.positions, vertex);
        positions.row(vertex) = predict(ring, positions);
        double last_length = std::numeric_limits<double>::infinity();
        for (int round = 0; round < kSplitRounds; ++round) {
            const Vector3 move = decoded_move(pyramid, positions, vertex);
            if (move.norm() >= last_length) break;  // it does not converge here
            last_length = move.norm();
            positions.row(vertex) += kSweepShare * move.transpose();
        }
    }
    Positions result = setup.start;
    for (Index v = 0; v < vertex_count; ++v)
        result.row(region.vertices[v]) = positions.row(v);
    return result;
}

}  // namespace

Positions pyramid(const Problem& problem, const PyramidOptions& options, Execution& execution) {
    if (options.sweeps < 0) throw InvalidInput(message("sweeps is ", options.sweeps, "; give 0 or more"));
    const Setup setup = set_up(problem, execution);
    const std::vector<Index>& free = setup.unknowns.free;
    std::vector<Pyramid> pyramids(free.size());
    parallel_for(static_cast<Index>(free.size()), setup.threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            const Index v = free[k];
            const RingView faces{setup.rings.begin(v), setup.rings.valence(v), setup.rings.closed[v] != 0};
            std::vector<Index> ring(faces.begin(), faces.end());
            if (!spans_a_plane(problem.vertices, faces.vertices, faces.valence))
                ring = extended_ring(problem.vertices, setup.rings, v);
            pyramids[k] = encode_vertex(faces, std::move(ring), problem.vertices, v);
        }
    });
    Positions positions = decode_hierarchy(problem, setup, execution);
    execution.begin_stage("solve");
    Positions next = positions;
    // On noisy rings the rest shape itself may be an unstable fixed point. That no sweep steps farther than the one
    // before keeps rounding from growing into an explosion there, and hardly ever binds elsewhere.
    double longest_step = std::numeric_limits<double>::infinity();
    std::vector<double> steps;
    for (int done = 0; done < options.sweeps; ++done) {
        execution.check();
        execution.set_progress(static_cast<double>(done) / options.sweeps);
        longest_step = sweep(setup, pyramids, longest_step, positions, next, steps, execution);
        std::swap(positions, next);
    }
    return positions;
}

}  // namespace meanvalue::baselines
