#include "meanvalue/mesh/region.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "meanvalue/common/grouped.h"
#include "meanvalue/mesh/disjoint_sets.h"
#include "meanvalue/mesh/extent.h"

namespace meanvalue {
namespace {

/// Marks every corner of the triangles that have a marked corner.
std::vector<char> grown(const TrianglesView& faces, const std::vector<char>& marked, const Execution& execution) {
    std::vector<char> result = marked;
    execution.check();
    for (Index f = 0; f < faces.rows(); ++f) {
        if (!marked[faces(f, 0)] && !marked[faces(f, 1)] && !marked[faces(f, 2)]) continue;
        for (int k = 0; k < 3; ++k)
            result[faces(f, k)] = 1;
    }
    return result;
}

/// Spreads the lowest 21 bits so that two zeros follow each.
std::uint64_t spread_bits(std::uint64_t bits) {
    bits = (bits | bits << 32) & 0x001f00000000ffffULL;
    bits = (bits | bits << 16) & 0x001f0000ff0000ffULL;
    bits = (bits | bits << 8) & 0x100f00f00f00f00fULL;
    bits = (bits | bits << 4) & 0x10c30c30c30c30c3ULL;
    return (bits | bits << 2) & 0x1249249249249249ULL;
}

/// The region of `vertices`, in this order, and of the faces `kept`.
Region taken_from(const PositionsView& positions, const TrianglesView& faces, const std::vector<char>& is_fixed,
                  std::vector<Index> vertices, const std::vector<Index>& kept, const Execution& execution) {
    Region region;
    region.vertices = std::move(vertices);
    region.positions.resize(static_cast<Eigen::Index>(region.vertices.size()), 3);
    std::vector<Index> number(positions.rows(), -1);
    execution.check();
    for (std::size_t k = 0; k < region.vertices.size(); ++k) {
        number[region.vertices[k]] = static_cast<Index>(k);
        region.positions.row(k) = positions.row(region.vertices[k]);
        region.is_fixed.push_back(is_fixed[region.vertices[k]]);
    }
    region.faces.resize(static_cast<Eigen::Index>(kept.size()), 3);
    execution.check();
    for (std::size_t k = 0; k < kept.size(); ++k) {
        for (int c = 0; c < 3; ++c)
            region.faces(k, c) = number[faces(kept[k], c)];
    }
    return region;
}

// A patch of anchors is cut out if it has more than one in so many of the vertices that may move.
constexpr std::ptrdiff_t kPatchesPerRegion = 64;

}  // namespace

std::vector<char> without_small_patches(std::vector<char> is_fixed, const std::vector<char>& may_move,
                                        const TrianglesView& faces, const Execution& execution) {
    const auto is_anchor = [&](Index v) { return is_fixed[v] != 0 && may_move[v] != 0; };
    DisjointSets patches(static_cast<Index>(is_fixed.size()));
    execution.check();
    for (Index f = 0; f < faces.rows(); ++f) {
        for (int k = 0; k < 3; ++k) {
            const Index next = faces(f, k < 2 ? k + 1 : 0);
            if (is_anchor(faces(f, k)) && is_anchor(next)) patches.join(faces(f, k), next);
        }
    }
    std::vector<Index> sizes(is_fixed.size(), 0);
    for (std::size_t v = 0; v < sizes.size(); ++v)
        ++sizes[patches.root(static_cast<Index>(v))];
    const auto largest = static_cast<Index>(std::count(may_move.begin(), may_move.end(), 1) / kPatchesPerRegion);
    std::vector<char> result = is_fixed;
    for (std::size_t v = 0; v < sizes.size(); ++v) {
        const auto vertex = static_cast<Index>(v);
        if (is_anchor(vertex) && sizes[patches.root(vertex)] <= largest) result[v] = 0;
    }
    return result;
}

Region surroundings_of_free(const PositionsView& positions, const TrianglesView& faces,
                            const std::vector<char>& is_fixed, const Execution& execution) {
    std::vector<char> is_free(is_fixed.size());
    std::transform(is_fixed.begin(), is_fixed.end(), is_free.begin(), [](char fixed) { return fixed ? 0 : 1; });
    const std::vector<char> near = grown(faces, is_free, execution);
    const std::vector<char> inside = grown(faces, near, execution);
    std::vector<Index> vertices;
    for (std::size_t v = 0; v < inside.size(); ++v) {
        if (inside[v]) vertices.push_back(static_cast<Index>(v));
    }
    std::vector<Index> kept;
    execution.check();
    for (Index f = 0; f < faces.rows(); ++f) {
        if (near[faces(f, 0)] || near[faces(f, 1)] || near[faces(f, 2)]) kept.push_back(f);
    }
    return taken_from(positions, faces, is_fixed, std::move(vertices), kept, execution);
}

Region in_spatial_order(const Region& region, const Execution& execution) {
    const std::size_t count = region.vertices.size();
    if (count == 0) return region;
    const Positions along = region.positions * principal_axes(region.positions, execution);
    const Eigen::RowVector3d low = along.colwise().minCoeff();
    const double extent = (along.colwise().maxCoeff() - low).maxCoeff();
    const double scale = extent > 0.0 ? static_cast<double>((1 << 21) - 1) / extent : 0.0;
    std::vector<std::pair<std::uint64_t, Index>> order(count);  // code and vertex
    execution.check();
    for (std::size_t v = 0; v < count; ++v) {
        std::uint64_t code = 0;
        for (int c = 0; c < 3; ++c) {
            code |= spread_bits(static_cast<std::uint64_t>((along(v, c) - low(c)) * scale)) << c;
        }
        order[v] = {code, static_cast<Index>(v)};
    }
    std::size_t comparisons = 0;  // a million take a tenth of a second
    std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
        execution.check_every(++comparisons);
        return a < b;
    });
    std::vector<Index> vertices;
    vertices.reserve(count);
    std::vector<Index> place(count);
    for (const auto& [code, v] : order) {
        place[v] = static_cast<Index>(vertices.size());
        vertices.push_back(v);
    }
    execution.check();
    const auto faces = grouped<Index>(count, [&](const auto& visit) {
        for (Index f = 0; f < region.faces.rows(); ++f)
            visit(std::min({place[region.faces(f, 0)], place[region.faces(f, 1)], place[region.faces(f, 2)]}), f);
    });
    Region result =
        taken_from(region.positions, region.faces, region.is_fixed, std::move(vertices), faces.items, execution);
    for (Index& v : result.vertices)
        v = region.vertices[v];
    return result;
}

}  // namespace meanvalue
