#include "meanvalue/mesh/region.h"

#include <algorithm>

namespace meanvalue {
namespace {

/// Marks every corner of the triangles that have a marked corner.
std::vector<char> grown(const TrianglesView& faces, const std::vector<char>& marked) {
    std::vector<char> result = marked;
    for (Index f = 0; f < faces.rows(); ++f) {
        if (!marked[faces(f, 0)] && !marked[faces(f, 1)] && !marked[faces(f, 2)]) continue;
        for (int k = 0; k < 3; ++k)
            result[faces(f, k)] = 1;
    }
    return result;
}

}  // namespace

Region surroundings_of_free(const PositionsView& positions, const TrianglesView& faces,
                            const std::vector<char>& is_fixed) {
    std::vector<char> is_free(is_fixed.size());
    std::transform(is_fixed.begin(), is_fixed.end(), is_free.begin(), [](char fixed) { return fixed ? 0 : 1; });
    const std::vector<char> near = grown(faces, is_free);
    const std::vector<char> inside = grown(faces, near);

    Region region;
    std::vector<Index> number(is_fixed.size(), -1);
    for (std::size_t v = 0; v < inside.size(); ++v) {
        if (!inside[v]) continue;
        number[v] = static_cast<Index>(region.vertices.size());
        region.vertices.push_back(static_cast<Index>(v));
        region.is_fixed.push_back(is_fixed[v]);
    }
    region.positions.resize(static_cast<Eigen::Index>(region.vertices.size()), 3);
    for (std::size_t k = 0; k < region.vertices.size(); ++k) {
        region.positions.row(k) = positions.row(region.vertices[k]);
    }
    std::vector<Index> kept;
    for (Index f = 0; f < faces.rows(); ++f) {
        if (near[faces(f, 0)] || near[faces(f, 1)] || near[faces(f, 2)]) kept.push_back(f);
    }
    region.faces.resize(static_cast<Eigen::Index>(kept.size()), 3);
    for (std::size_t k = 0; k < kept.size(); ++k) {
        for (int c = 0; c < 3; ++c)
            region.faces(k, c) = number[faces(kept[k], c)];
    }
    return region;
}

}  // namespace meanvalue
