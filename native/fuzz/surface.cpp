#include <algorithm>
#include <cmath>
#include <limits>

#include "fuzz/entries.h"
#include "fuzz/odd_input.h"
#include "meanvalue/mesh/surface_ways.h"
#include "meanvalue/mesh/triangle_tree.h"

namespace meanvalue::fuzz {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

SurfaceWays::Edges read_edges(Bytes& bytes, const Mesh& mesh) {
    std::vector<Index> ends;
    for (Eigen::Index t = 0; t < mesh.faces.rows(); ++t) {
        for (int corner = 0; corner < 3; ++corner)
            ends.insert(ends.end(), {mesh.faces(t, corner), mesh.faces(t, (corner + 1) % 3)});
    }
    if (bytes.once_in(16)) ends.insert(ends.end(), {bytes.below(99) - 9, 0});
    return Eigen::Map<const SurfaceWays::Edges>(ends.data(), static_cast<Index>(ends.size() / 2), 2);
}

std::vector<Index> read_seeds(Bytes& bytes, const Mesh& mesh) {
    std::vector<Index> seeds;
    for (Index more = bytes.below(4); more > 0 && mesh.vertex_count() > 0; --more)
        seeds.push_back(bytes.below(mesh.vertex_count() + (bytes.once_in(16) ? 1 : 0)));
    return seeds;
}

/// Mostly of the mesh's size.
double read_length(Bytes& bytes, double size) {
    return bytes.once_in(8) ? bytes.number() : size * std::pow(10.0, bytes.below(5) - 3);
}

void require_ways(const SurfaceWays& ways, const std::vector<Index>& seeds, double limit, double free) {
    const std::vector<double> distances = ways.distances(seeds, limit);
    require(
        std::all_of(distances.begin(), distances.end(),
                    [&](double each) { return each == -1.0 || each == kInfinite || (each >= 0.0 && each <= limit); }),
        "a distance is within the limit, or infinite, or that of a piece within it");
    const std::vector<double> weights = ways.falloff(seeds, limit, free);
    require(std::all_of(weights.begin(), weights.end(), [](double each) { return each >= 0.0 && each <= 1.0; }),
            "a weight is between 0 and 1");
    if (seeds.empty()) return;
    const double limb = ways.limb(seeds.front(), 0.01 * limit, limit);
    require(limb == 0.0 || (limb > 0.0 && limb <= limit), "a limb is within the limit");
}

void require_place(const TriangleTree& tree, const TriangleTree::Query& query) {
    const TriangleTree::Place place = tree.nearest(query, std::numeric_limits<double>::max());
    if (place.triangle < 0) return;
    require(place.triangle < tree.triangles().rows(), "a place is on a triangle of the surface");
    require(place.weights.minCoeff() >= 0.0 && std::abs(place.weights.sum() - 1.0) < 1e-9, "weights sum to one");
    require(place.point.allFinite(), "a place is one of finite numbers");
}

}  // namespace

Outcome surface(Bytes bytes) {
    const Mesh mesh = read_mesh(bytes);
    return outcome_of([&] {
        const double size = bounding_box_diagonal(mesh.vertices);
        const double gap = bytes.once_in(2) ? read_length(bytes, 0.1 * size) : 0.0;
        const SurfaceWays ways(mesh.vertices, read_edges(bytes, mesh), mesh.faces, gap, bytes.once_in(4) ? 2 : 1,
                               Execution());
        const std::vector<Index> seeds = read_seeds(bytes, mesh);
        const double limit = read_length(bytes, size);
        require_ways(ways, seeds, limit, bytes.once_in(8) ? bytes.number() : bytes.byte() / 255.0);
        const std::vector<Index> part_of(mesh.vertex_count(), 0);
        const TriangleTree tree(mesh.vertices, mesh.faces, part_of, Execution());
        const Vector3 normal = Vector3(bytes.number(), bytes.number(), bytes.number()).normalized();
        for (int more = bytes.below(20); more > 0; --more) {
            TriangleTree::Query query;
            query.point = size * Vector3(bytes.number(), bytes.number(), bytes.number());
            if (bytes.once_in(2)) query.normal = &normal;
            query.least_cosine = bytes.once_in(8) ? bytes.number() : 0.0;
            require_place(tree, query);
        }
    });
}

}  // namespace meanvalue::fuzz
