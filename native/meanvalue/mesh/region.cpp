#include "meanvalue/mesh/region.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "meanvalue/common/grouped.h"
#include "meanvalue/mesh/components.h"
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

/// The region of `vertices`, in this order, and of the faces `kept`. @param number n: receives those of its vertices.
Region taken_from(const PositionsView& positions, const TrianglesView& faces, const std::vector<char>& is_fixed,
                  std::vector<Index> vertices, const std::vector<Index>& kept, std::vector<Index>& number,
                  const Execution& execution) {
    Region region;
    region.vertices = std::move(vertices);
    execution.check();
    region.positions = positions(region.vertices, Eigen::all);
    region.is_fixed = picked(is_fixed, region.vertices);
    for (std::size_t k = 0; k < region.vertices.size(); ++k)
        number[region.vertices[k]] = static_cast<Index>(k);
    region.faces.resize(static_cast<Eigen::Index>(kept.size()), 3);
    execution.check();
    for (std::size_t k = 0; k < kept.size(); ++k) {
        for (int c = 0; c < 3; ++c)
            region.faces(k, c) = number[faces(kept[k], c)];
    }
    return region;
}

// A patch of anchors is cut out if it has more than one in so many of the vertices that may move and hang together
// with it. Not one so small that no vertex of it is beyond the surroundings of what is free.
constexpr Index kPatchesPerArea = 64;
constexpr Index kAlwaysNear = 2;

/// Some vertices along a Z-order curve.
std::vector<Index> in_spatial_order(const Positions& positions, const Execution& execution) {
    const auto count = static_cast<std::size_t>(positions.rows());
    const Positions along = positions * principal_axes(positions, execution);
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
    for (const auto& [code, v] : order)
        vertices.push_back(v);
    return vertices;
}

}  // namespace

std::vector<char> without_small_patches(std::vector<char> is_fixed, const std::vector<char>& may_move,
                                        const TrianglesView& faces, const Execution& execution) {
    const auto is_anchor = [&](Index v) { return is_fixed[v] != 0 && may_move[v] != 0; };
    const auto count = static_cast<Index>(is_fixed.size());
    DisjointSets patches(count);
    DisjointSets areas(count);
    execution.check();
    for (Index f = 0; f < faces.rows(); ++f) {
        for (int k = 0; k < 3; ++k) {
            const Index v = faces(f, k);
            const Index next = faces(f, k < 2 ? k + 1 : 0);
            if (may_move[v] && may_move[next]) areas.join(v, next);
            if (is_anchor(v) && is_anchor(next)) patches.join(v, next);
        }
    }
    std::vector<Index> of_patch(count, 0);
    std::vector<Index> of_area(count, 0);
    for (Index v = 0; v < count; ++v) {
        ++of_patch[patches.root(v)];
        ++of_area[areas.root(v)];
    }
    std::vector<char> result = is_fixed;
    for (Index v = 0; v < count; ++v) {
        const Index patch = of_patch[patches.root(v)];
        const Index area = of_area[areas.root(v)];
        if (is_anchor(v) && patch < area && patch <= std::max(kAlwaysNear, area / kPatchesPerArea)) result[v] = 0;
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
    std::vector<Index> number(inside.size());
    execution.check();
    for (Index f = 0; f < faces.rows(); ++f) {
        if (near[faces(f, 0)] || near[faces(f, 1)] || near[faces(f, 2)]) kept.push_back(f);
    }
    return taken_from(positions, faces, is_fixed, std::move(vertices), kept, number, execution);
}

std::vector<Region> parts_in_spatial_order(const Region& region, const Execution& execution) {
    const Components parts = find_components(region.positions, region.faces, region.is_fixed, execution);
    const auto vertices = grouped<Index>(parts.parts.size(), [&](const auto& visit) {
        for (std::size_t v = 0; v < parts.part_of.size(); ++v)
            visit(parts.part_of[v], static_cast<Index>(v));
    });
    const auto faces = grouped<Index>(parts.parts.size(), [&](const auto& visit) {
        for (Index f = 0; f < region.faces.rows(); ++f)
            visit(parts.part_of[region.faces(f, 0)], f);
    });
    std::vector<Index> place(parts.part_of.size());
    std::vector<Region> result;
    for (std::size_t part = 0; part < parts.parts.size(); ++part) {
        const std::vector<Index> all(vertices.of(part).begin(), vertices.of(part).end());
        std::vector<Index> order = picked(all, in_spatial_order(region.positions(all, Eigen::all), execution));
        for (std::size_t k = 0; k < order.size(); ++k)
            place[order[k]] = static_cast<Index>(k);
        execution.check();
        const auto kept = grouped<Index>(order.size(), [&](const auto& visit) {
            for (const Index f : faces.of(part))
                visit(std::min({place[region.faces(f, 0)], place[region.faces(f, 1)], place[region.faces(f, 2)]}), f);
        });
        result.push_back(taken_from(region.positions, region.faces, region.is_fixed, std::move(order), kept.items,
                                    place, execution));
        for (Index& v : result.back().vertices)
            v = region.vertices[v];
    }
    if (result.empty()) result.push_back(region);
    return result;
}

}  // namespace meanvalue
