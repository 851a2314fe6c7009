// One exception class for each kind of blame, and message() to put the numbers into the text.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <sstream>
#include <stdexcept>
#include <string>

namespace meanvalue {

/// The caller's data is at fault; the text names the item and how to mend it.
class InvalidInput : public std::invalid_argument {
  public:
    using std::invalid_argument::invalid_argument;
};

/// The input was acceptable, but the numbers could not be computed.
class SolverFailure : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Execution::cancel() was called; nothing was changed.
class Cancelled : public std::runtime_error {
  public:
    Cancelled() : std::runtime_error("cancelled") {}
};

/// Joins its arguments into one text: `message("anchor ", i, " is vertex ", v)`.
template <typename... Parts>
std::string message(const Parts&... parts) {
    std::ostringstream text;
    (text << ... << parts);
    return text.str();
}

}  // namespace meanvalue
