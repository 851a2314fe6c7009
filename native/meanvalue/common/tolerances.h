// What is nothing beside what it is compared with. None of these is tuned: a hundred times more or less gives the
// same results on models as they come.
#pragma once

namespace meanvalue {

/// What a few operations in double precision leave of a zero, as a share of their operands.
constexpr double kRounding = 1e-12;
/// What sums over many of them leave. Below it two results are equal, and a matrix is singular.
constexpr double kNegligible = 1e-9;
/// Points nearer to each other than this share of what is around them are in one place, on one line or in one plane:
/// what depends on how they differ is lost in rounding.
constexpr double kCoincident = 1e-6;
/// What sums over many operations leave of a zero in single precision.
constexpr double kSinglePrecision = 1e-6;

}  // namespace meanvalue
