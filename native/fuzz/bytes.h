// What a fuzzer hands over, taken from the front; beyond the end there are zeros.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>

#include "meanvalue/common/types.h"

namespace meanvalue::fuzz {

class Bytes {
  public:
    Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

    std::uint8_t byte() {
        if (left_ == 0) return 0;
        --left_;
        return *data_++;
    }

    /// From 0 to count - 1. @pre 0 < count <= 65536.
    Index below(Index count) {
        const Index low = byte();
        return (low + 256 * byte()) % count;
    }

    /// True once in `times`.
    bool once_in(int times) { return byte() % times == times - 1; }

    /// Mostly between -8 and 8; else what arithmetic stumbles on, or any bits at all.
    double number() {
        const std::uint8_t kind = byte();
        if (kind < 240) return (kind - 120) / 15.0 + byte() / 4096.0;
        constexpr double kOdd[] = {0.0,
                                   -0.0,
                                   1e-300,
                                   1e300,
                                   5e-324,
                                   1e-30,
                                   -1e30,
                                   1e6,
                                   1e-6,
                                   std::numeric_limits<double>::infinity(),
                                   -std::numeric_limits<double>::infinity(),
                                   std::numeric_limits<double>::quiet_NaN(),
                                   1.0 + std::numeric_limits<double>::epsilon()};
        if (kind - 240 < static_cast<int>(std::size(kOdd))) return kOdd[kind - 240];
        std::uint64_t bits = 0;
        for (int k = 0; k < 8; ++k)
            bits = bits << 8 | byte();
        double value = 0.0;
        std::memcpy(&value, &bits, sizeof value);
        return value;
    }

  private:
    const std::uint8_t* data_;
    std::size_t left_;
};

}  // namespace meanvalue::fuzz
