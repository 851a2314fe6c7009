// What is fuzzed: each takes bytes, makes input of them and calls the library.
#pragma once

#include <stdexcept>

#include "fuzz/bytes.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/deform/deformer.h"

namespace meanvalue::fuzz {

enum class Outcome {
    kSolved,   ///< with a result that is as documented
    kRefused,  ///< InvalidInput
    kFailed,   ///< SolverFailure
};

/// A result is not what the library promises. Nothing catches it.
class BrokenPromise : public std::logic_error {
  public:
    using std::logic_error::logic_error;
};

/// Bind, solve from rest, solve on from there, bind again to other anchors and solve. Of all that, the outcome of the
/// last. @throws BrokenPromise, and whatever the library throws and should not.
Outcome bind_and_solve(Bytes bytes);
/// A Morpher of two or three shapes, mixed twice. @throws as bind_and_solve().
Outcome morph(Bytes bytes);
/// A clip of a few frames on one Deformer. @throws as bind_and_solve().
Outcome sequence(Bytes bytes);
/// Ways over a surface, and the nearest places on it. @throws as bind_and_solve().
Outcome surface(Bytes bytes);

/// Runs `action`, whose errors by name become an outcome.
template <typename Action>
Outcome outcome_of(const Action& action) {
    try {
        action();
        return Outcome::kSolved;
    } catch (const InvalidInput&) {
        return Outcome::kRefused;
    } catch (const SolverFailure&) {
        return Outcome::kFailed;
    }
}

/// @throws BrokenPromise unless `holds`.
inline void require(bool holds, const char* promise) {
    if (!holds) throw BrokenPromise(promise);
}

/// Finite, of the mesh's size, with energies that are none below zero. @throws BrokenPromise.
void require_solution(const Solution& solution, Eigen::Index vertex_count);

}  // namespace meanvalue::fuzz
