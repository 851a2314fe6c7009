// How much memory the computer has, and the error for what takes more.
#pragma once

#include <cstdint>
#include <stdexcept>

namespace meanvalue {

/// What was asked for takes more memory than the computer has; the text tells how much both are. Nothing was begun.
class TooLittleMemory : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// In bytes, whatever is in use; or the highest number where the system does not tell.
std::uint64_t physical_memory();

}  // namespace meanvalue
