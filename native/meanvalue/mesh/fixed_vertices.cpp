#include "meanvalue/mesh/fixed_vertices.h"

#include <string>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

constexpr double kFarthestStart = 10.0 * kFarthestDiagonals;

/// Empty where it is near enough, else how far it is and what to do. Without squares, which may overflow.
/// @param most in diagonals. A mesh without an extent has no near and far.
std::string refusal(const Eigen::RowVector3d& place, const Eigen::RowVector3d& rest, double diagonal, double most) {
    if (diagonal == 0.0 || (place - rest).cwiseAbs().sum() <= most * diagonal) return {};
    const double distance = (place - rest).stableNorm();
    if (distance <= most * diagonal) return {};
    return message(" is ", distance, " away from where the vertex rests, ", distance / diagonal,
                   " bounding-box diagonals of the mesh, and at most ", most,
                   " can be solved for; move it nearer, or scale the mesh to its targets first");
}

}  // namespace

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

void require_targets(const PositionsView& targets, const std::vector<Index>& anchors, const PositionsView& rest,
                     double diagonal) {
    require_count("targets", targets.rows(), "row", anchors.size(), "anchors");
    require_finite(targets, "targets");
    for (std::size_t k = 0; k < anchors.size(); ++k) {
        const std::string why = refusal(targets.row(k), rest.row(anchors[k]), diagonal, kFarthestDiagonals);
        if (!why.empty()) throw InvalidInput(message("targets[", k, "], of vertex ", anchors[k], ",", why));
    }
}

void require_start(const PositionsView& start, const PositionsView& rest, double diagonal,
                   const std::vector<char>& is_fixed) {
    require_count("start", start.rows(), "row", rest.rows(), "vertices");
    require_finite(start, "start");
    for (Index v = 0; v < rest.rows(); ++v) {
        if (is_fixed[v]) continue;
        const std::string why = refusal(start.row(v), rest.row(v), diagonal, kFarthestStart);
        if (!why.empty()) throw InvalidInput(message("start[", v, "]", why));
    }
}

}  // namespace meanvalue
