// What a report says of one connected part of a mesh.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include "meanvalue/common/types.h"

namespace meanvalue {

/// One connected part of a mesh.
struct Component {
    Index vertex_count = 0;
    Index free_count = 0;
    Index fixed_count = 0;
    Index soft_count = 0;  ///< of the free ones: soft anchors
    /// Degrees of freedom of a similarity that the fixed points and soft anchors leave open: 7 without any, 4 with
    /// one, 1 with two or with collinear ones, 0 with three that are not collinear.
    int undetermined = 7;
    Index first_vertex = 0;  ///< the lowest vertex number in it, to name it by
};

}  // namespace meanvalue
