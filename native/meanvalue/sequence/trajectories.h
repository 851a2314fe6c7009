// Where anchors go.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// Where the anchors go at each frame of a clip, in the order of the anchors.
struct Trajectories {
    Index frame_count = 0;
    Index anchor_count = 0;
    std::vector<double> targets;  ///< frames x anchors x 3
    std::vector<double> weights;  ///< frames x anchors, or empty: SolveOptions::weights of each frame

    /// anchors x 3.
    PositionsView targets_at(Index frame) const;
    std::vector<double> weights_at(Index frame) const;  ///< empty where there are none
};

}  // namespace meanvalue
