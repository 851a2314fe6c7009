#include <algorithm>

#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/linalg/simd_closest_rotation.h"

namespace meanvalue {

void closest_rotations(Matrix3* matrices, Index count) {
    for (Index first = 0; first < count; first += kLaneCount) {
        const int used = std::min<int>(kLaneCount, count - first);
        LaneMatrix four;
        for (int lane = 0; lane < kLaneCount; ++lane)
            set_lane(lane < used ? matrices[first + lane] : Matrix3::Identity(), lane, four);
        const LaneMatrix rotations = closest_rotations(four);
        for (int lane = 0; lane < used; ++lane)
            matrices[first + lane] = lane_of(rotations, lane);
    }
}

Matrix3 closest_rotation(Matrix3 matrix) {
    closest_rotations(&matrix, 1);
    return matrix;
}

}  // namespace meanvalue
