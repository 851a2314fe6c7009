#include "meanvalue/common/archive.h"

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

constexpr std::uint64_t kPrime = 1099511628211U;

[[noreturn]] void refuse() {
    throw InvalidInput("what was kept of a clip is damaged; solve its frames from the beginning");
}

}  // namespace

std::uint64_t checksum_of(const void* bytes, std::size_t count, std::uint64_t begun) {
    const auto* from = static_cast<const std::uint8_t*>(bytes);
    std::uint64_t sum = begun;
    for (; count >= sizeof(std::uint64_t); count -= sizeof(std::uint64_t), from += sizeof(std::uint64_t)) {
        std::uint64_t eight = 0;
        std::memcpy(&eight, from, sizeof eight);
        sum = (sum ^ eight) * kPrime;
        sum ^= sum >> 32U;  // multiplying carries upwards only
    }
    for (; count > 0; --count, ++from)
        sum = (sum ^ *from) * kPrime;
    return sum;
}

Archive::Archive(const Bytes& bytes) : from_(bytes.data()), left_(bytes.size()) {
    std::uint64_t told = 0;
    if (left_ < sizeof told) refuse();
    left_ -= sizeof told;
    std::memcpy(&told, from_ + left_, sizeof told);
    if (told != checksum_of(from_, left_)) refuse();
}

Archive::Bytes Archive::finish() {
    std::uint64_t sum = checksum_of(written_.data(), written_.size());
    pass(sum);
    return std::move(written_);
}

void Archive::require(bool holds) const {
    if (!holds) refuse();
}

std::size_t Archive::pass_count(std::size_t count, std::size_t bytes) {
    std::uint64_t told = count;
    pass(told);
    if (is_reading() && told > left_ / bytes) refuse();
    return static_cast<std::size_t>(told);
}

void Archive::pass_bytes(void* to_or_from, std::size_t count) {
    if (count == 0) return;
    if (!is_reading()) {
        const auto* from = static_cast<const std::uint8_t*>(to_or_from);
        written_.insert(written_.end(), from, from + count);
        return;
    }
    if (count > left_) refuse();
    std::memcpy(to_or_from, from_, count);
    from_ += count;
    left_ -= count;
}

}  // namespace meanvalue
