// A run of a clip on its way.
#pragma once

#include <memory>
#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/sequence/seam.h"

namespace meanvalue {

/// The frames that a run solves, and those that it goes through on the way.
struct Run {
    Index number = 0;
    Index begin = 0;
    Index end = 0;  // of what is solved
    // Until it is done, of each frame that was gone through so far:
    std::vector<float*> shapes;      // in the result or in `aside`
    std::vector<Seam::Shape> aside;  // none where it is in the result
    std::vector<char> is_solved;     // whether it could be

    /// Nothing is looked at any more.
    void finish();
};

}  // namespace meanvalue
