// How much memory the computer has, and the error for what takes more.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <cstdint>
#include <stdexcept>
#include <string>

namespace meanvalue {

/// What was asked for takes more memory than there is; the text tells how much both are. Nothing was begun.
class TooLittleMemory : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// In bytes, whatever is in use, and no more than a container of Linux may take; or the highest number where the
/// system does not tell.
std::uint64_t physical_memory();

/// The least that a control group of this process may take, or the highest number where none is limited.
/// @param groups the system's list of them. @param root the folder where they are.
std::uint64_t group_memory(const std::string& groups, const std::string& root);

}  // namespace meanvalue
