// State as bytes, for whoever goes on with it later: by the same program, on the same kind of machine.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// Writes numbers in a row, or reads them back: pass() does either, so that what is written and what is read cannot
/// differ. A checksum at the end tells damaged bytes.
class Archive {
  public:
    using Bytes = std::vector<std::uint8_t>;

    Archive() = default;  ///< writes
    /// Reads. @pre `bytes` outlives it. @throws InvalidInput where they are not what finish() has given.
    explicit Archive(const Bytes& bytes);

    /// For about so many bytes, so that they are not moved as they become more.
    void expect(std::size_t bytes) { written_.reserve(bytes); }
    bool is_reading() const { return from_ != nullptr; }
    /// What was written; nothing more may be. Not for reading.
    Bytes finish();

    template <typename Number>
    std::enable_if_t<std::is_arithmetic_v<Number>> pass(Number& number) {
        pass_bytes(&number, sizeof(Number));
    }
    /// @pre room for `count`.
    template <typename Number>
    std::enable_if_t<std::is_arithmetic_v<Number>> pass(Number* numbers, std::size_t count) {
        pass_bytes(numbers, count * sizeof(Number));
    }
    template <typename Number>
    std::enable_if_t<std::is_arithmetic_v<Number>> pass(std::vector<Number>& numbers) {
        numbers.resize(pass_count(numbers.size(), sizeof(Number)));
        pass(numbers.data(), numbers.size());
    }
    void pass(std::string& text) {
        text.resize(pass_count(text.size(), 1));
        pass(text.data(), text.size());
    }
    void pass(Positions& positions) {
        positions.resize(static_cast<Eigen::Index>(pass_count(positions.rows(), 3 * sizeof(double))), 3);
        pass(positions.data(), static_cast<std::size_t>(positions.size()));
    }
    /// What has to hold of what was read. @throws InvalidInput as for damaged bytes.
    void require(bool holds) const;
    /// How many of something follow. @param bytes of each at least. @throws InvalidInput where no more are there.
    std::size_t pass_count(std::size_t count, std::size_t bytes = 1);

  private:
    void pass_bytes(void* to_or_from, std::size_t count);

    Bytes written_;
    const std::uint8_t* from_ = nullptr;
    std::size_t left_ = 0;
};

/// FNV-1a (Fowler, Noll and Vo), eight bytes at a time: tells inputs apart, not forgeries.
std::uint64_t checksum_of(const void* bytes, std::size_t count, std::uint64_t begun = 14695981039346656037U);

}  // namespace meanvalue
