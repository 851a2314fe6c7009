#include "meanvalue/baselines/pyramid.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/encoding/projection_plane.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue::baselines {
namespace {

// Share of the way to its decoded place that a vertex goes in a sweep.
constexpr double kSweepShare = 0.7;
// Rounds of the implicit decoding of one vertex that is put back into the mesh.
constexpr int kSplitRounds = 5;

/// Normalised sum of the unit normals of the faces at `vertex`; zero where they cancel or have no area.
/// Of the unit normals: the sum of the area vectors would be that of the ring polygon wherever the ring is closed,
/// and would not depend on the vertex.
Vector3 face_normal(const OneRings& rings, const PositionsView& positions, Index vertex) {
    const Index valence = rings.valence(vertex);
    const Index* ring = rings.begin(vertex);
    const Vector3 centre = positions.row(vertex);
    Vector3 sum = Vector3::Zero();
    for (Index k = 0; k < rings.triangle_count(vertex); ++k) {
        const Vector3 edge = Vector3(positions.row(ring[k])) - centre;
        const Vector3 next = Vector3(positions.row(ring[(k + 1) % valence])) - centre;
        sum += edge.cross(next).normalized();  // zero stays zero
    }
    return sum.normalized();
}

Positions face_normals(const OneRings& rings, const PositionsView& positions, int threads,
                       const Execution& execution) {
    Positions normals(positions.rows(), 3);
    parallel_for(static_cast<Index>(positions.rows()), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v)
            normals.row(v) = face_normal(rings, positions, v);
    });
    return normals;
}

/// From a vertex to its decoded place; zero where it has none.
Vector3 decoded_move(const OneRings& rings, const Encoding& encoding, const Positions& positions, Index vertex) {
    const Vector3 normal = face_normal(rings, positions, vertex);
    if (!encoding.predictable(vertex) || normal.isZero(0.0)) return Vector3::Zero();
    const Vector3 decoded = predict_along(encoding.ring_of(vertex), positions, kRestNormalLength * normal);
    return decoded - Vector3(positions.row(vertex));
}

/// One damped Jacobi sweep over the free vertices; reads `from` alone.
/// @param longest_step no vertex moves farther. @param steps scratch, |V'|. @return the longest step made.
double sweep(const Setup& setup, const Encoding& encoding, double longest_step, const Positions& from, Positions& to,
             std::vector<double>& steps, const Execution& execution) {
    const std::vector<Index>& free = setup.unknowns.free;
    steps.resize(free.size());
    parallel_for(static_cast<Index>(free.size()), setup.threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            Vector3 move = kSweepShare * decoded_move(setup.rings, encoding, from, free[k]);
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
    const TriangleMesh mesh(vertex_count, region.faces, execution);
    const Hierarchy hierarchy = encode_along(find_removal_order(collect_one_rings(mesh, execution), region.positions,
                                                                region.is_fixed, {}, setup.threads, execution),
                                             region.positions, SplitBy::kEncoding, setup.threads, execution);
    const OneRings rings = removal_rings(hierarchy.base().splits, vertex_count, execution);
    const Encoding encoding =
        encode_with_normals(rings, region.positions, face_normals(rings, region.positions, setup.threads, execution),
                            setup.threads, execution);

    Positions positions(vertex_count, 3);
    for (Index v = 0; v < vertex_count; ++v)
        positions.row(v) = setup.start.row(region.vertices[v]);
    const Splits& splits = hierarchy.base().splits;
    for (Index k = 0; k < splits.size(); ++k) {
        execution.check_every(k);
        const Index vertex = splits.vertices[k];
        positions.row(vertex) = predict(splits.ring_of(k), positions);
        double last_length = std::numeric_limits<double>::infinity();
        for (int round = 0; round < kSplitRounds; ++round) {
            const Vector3 move = decoded_move(rings, encoding, positions, vertex);
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
    const Encoding encoding = encode_with_normals(
        setup.rings, problem.vertices, face_normals(setup.rings, problem.vertices, setup.threads, execution),
        setup.threads, execution);
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
        longest_step = sweep(setup, encoding, longest_step, positions, next, steps, execution);
        std::swap(positions, next);
    }
    return positions;
}

}  // namespace meanvalue::baselines
