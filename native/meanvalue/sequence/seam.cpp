#include "meanvalue/sequence/seam.h"

#include <utility>

namespace meanvalue {
namespace {

/// 0 to 1 with no slope at either end, and the least second difference. @param frame of `count`, counted from 0.
double fade(Index frame, Index count) {
    const double t = (frame + 1.0) / (count + 1.0);
    return t < 0.5 ? 2.0 * t * t : 1.0 - 2.0 * (1.0 - t) * (1.0 - t);
}

}  // namespace

void Seam::add(Index frame, Shape shape) {
    if (shape) after_.push_back({frame, std::move(shape)});
}

void Seam::close(Index overlap, std::size_t numbers, const std::function<float*(Index frame)>& row) {
    if (++sides_done_ < 2) return;
    for (const After& after : after_) {
        const auto first = static_cast<Index>(at_ - overlap);
        const auto share = static_cast<float>(fade(after.frame - first, overlap));
        float* const to = row(after.frame);
        for (std::size_t number = 0; number < numbers; ++number)
            to[number] += share * (after.shape[number] - to[number]);
    }
    after_.clear();
}

}  // namespace meanvalue
