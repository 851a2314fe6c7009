// Values of shape keys over the frames of a motion.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/sliders/frame_fit.h"

namespace meanvalue {

/// Each frame by itself first; then values are drawn to those of the frames beside them, as strongly as they change
/// little from frame to frame beside their noise (a random walk whose variance is estimated from the differences over
/// one and over two frames).
/// @param least_known frames with fewer known targets take their values and motion from the frames beside them; one
/// frame at least has as many.
/// The same bits for any number of threads. @throws Cancelled.
std::vector<FrameEstimate> estimate_sequence(const SliderModel& model, const std::vector<FrameTargets>& frames,
                                             std::size_t least_known, int threads, const Execution& execution);

}  // namespace meanvalue
