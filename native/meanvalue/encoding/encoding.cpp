#include "meanvalue/encoding/encoding.h"

#include <algorithm>
#include <array>
#include <utility>

namespace meanvalue {
namespace {

constexpr std::array<std::pair<GuardReason, const char*>, 7> kReasonNames = {{
    {kOnRingEdge, "on ring edge"},
    {kOnRingVertex, "on ring vertex"},
    {kLargeWeights, "large weights"},
    {kSteepEdge, "steep edge"},
    {kExtendedRing, "extended ring"},
    {kNonManifold, "non-manifold"},
    {kNotPredictable, "not predictable"},
}};

}  // namespace

Index Encoding::longest_ring() const {
    Index longest = 0;
    for (Index v = 0; v < vertex_count(); ++v)
        longest = std::max(longest, ring_offsets[v + 1] - ring_offsets[v]);
    return longest;
}

std::map<std::string, std::vector<Index>> Encoding::guarded_by_reason() const {
    std::map<std::string, std::vector<Index>> result;
    for (std::size_t k = 0; k < guarded.size(); ++k) {
        for (const auto& [reason, name] : kReasonNames) {
            if ((guard_reasons[k] & reason) != 0) result[name].push_back(guarded[k]);
        }
    }
    return result;
}

}  // namespace meanvalue
