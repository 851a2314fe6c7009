#include "meanvalue/sequence/trajectories.h"

#include <cstddef>

namespace meanvalue {

PositionsView Trajectories::targets_at(Index frame) const {
    return Eigen::Map<const Positions>(targets.data() + static_cast<std::size_t>(frame) * anchor_count * 3,
                                       anchor_count, 3);
}

std::vector<double> Trajectories::weights_at(Index frame) const {
    if (weights.empty()) return {};
    const auto first = weights.begin() + static_cast<std::ptrdiff_t>(frame) * anchor_count;
    return {first, first + anchor_count};
}

}  // namespace meanvalue
