// When a step of a minimiser is taken.
#pragma once

namespace meanvalue {

/// Whether the energy falls by enough of what its slope at the start promises (Armijo).
/// @param promised the length of the step times the slope, below 0. False also for an energy that is not a number.
inline bool falls_enough(double energy, double energy_then, double promised) {
    constexpr double kSufficientDecrease = 1e-4;
    return energy_then < energy && energy_then <= energy + kSufficientDecrease * promised;
}

}  // namespace meanvalue
