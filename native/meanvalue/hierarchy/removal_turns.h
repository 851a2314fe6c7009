// The order in which vertices are considered when a mesh is coarsened.
#pragma once

#include <cstdint>
#include <cstring>
#include <limits>

#include "meanvalue/common/types.h"

namespace meanvalue {

// Costs of a class count as equal. A class has 32 bits: the sign and the exponent of a double, and so many of its
// digits. All that fit are as good as no classes; two make classes 19 % wide: vertices that are neighbors in memory
// are removed one after another, which is faster on large meshes, for removals that are not quite the cheapest first.
constexpr int kFineBits = 20;
constexpr int kCoarseBits = 2;
constexpr std::uint64_t kNoClass = 0xffffffff;

/// Positive numbers are ordered as their bits are, so that the leading bits are a class.
class CostClasses {
  public:
    explicit CostClasses(int bits) : shift_(52 - bits) {}

    std::uint32_t of(double cost) const {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &cost, sizeof(bits));
        return static_cast<std::uint32_t>(bits >> shift_);
    }

    double lowest_cost(std::uint32_t cost_class) const {
        const std::uint64_t bits = std::uint64_t{cost_class} << shift_;
        double cost = 0.0;
        std::memcpy(&cost, &bits, sizeof(cost));
        return cost;
    }

  private:
    int shift_;
};

/// A place in the queue: first by class, then by vertex number. So the order is the same everywhere, and vertices of
/// a class are mostly visited in an order in which neighbors, and what is known of them, are near each other in
/// memory.
using Candidate = std::uint64_t;

inline Candidate candidate(std::uint64_t cost_class, Index vertex) {
    return cost_class << 32 | static_cast<std::uint32_t>(vertex);
}

constexpr Candidate kLastCandidate = std::numeric_limits<Candidate>::max();

}  // namespace meanvalue
