#include "meanvalue/mesh/fixed_vertices.h"

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"

namespace meanvalue {

std::vector<char> fixed_flags(Index vertex_count, const std::vector<Index>& anchors,
                              const std::optional<std::vector<char>>& roi) {
    std::vector<char> fixed(vertex_count, 0);
    std::vector<Index> named_by(vertex_count, -1);
    for (std::size_t k = 0; k < anchors.size(); ++k) {
        const Index v = anchors[k];
        if (v < 0 || v >= vertex_count) {
            throw InvalidInput(message("anchor ", k, " is vertex ", v, ", but the mesh has ", vertex_count,
                                       " vertices, numbered from 0"));
        }
        if (named_by[v] >= 0) {
            throw InvalidInput(
                message("anchors ", named_by[v], " and ", k, " are both vertex ", v, "; name each vertex once"));
        }
        named_by[v] = static_cast<Index>(k);
        fixed[v] = 1;
    }
    if (roi) {
        if (roi->size() != fixed.size()) {
            throw InvalidInput(
                message("roi has ", roi->size(), " entries, but the mesh has ", vertex_count, " vertices"));
        }
        for (Index v = 0; v < vertex_count; ++v)
            fixed[v] |= static_cast<char>(!(*roi)[v]);
    }
    return fixed;
}

std::vector<char> solved_as_fixed(std::vector<char> is_fixed, const Components& components) {
    for (std::size_t v = 0; v < is_fixed.size(); ++v) {
        if (components.fixed[components.part_of[v]].empty()) is_fixed[v] = 1;
    }
    return is_fixed;
}

void require_targets(const PositionsView& targets, const std::vector<Index>& anchors) {
    if (targets.rows() != static_cast<Eigen::Index>(anchors.size())) {
        throw InvalidInput(
            message("targets has ", targets.rows(), " rows, but there are ", anchors.size(), " anchors"));
    }
    require_finite(targets, "targets");
}

}  // namespace meanvalue
