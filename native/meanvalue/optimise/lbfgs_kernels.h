// The loops over long vectors of LbfgsHistory.
#pragma once

#include <cstdint>

#include "meanvalue/common/instruction_set.h"

namespace meanvalue {

/// Sums are in double precision.
struct LbfgsKernels {
    /// sum_k a[k] b[k]
    double (*dot)(const float* a, const double* b, std::int64_t count);
    /// sums[0] += step . other_change, sums[1] += other_step . change
    void (*cross_dots)(const float* step, const float* change, const float* other_step, const float* other_change,
                       std::int64_t count, double* sums);
    /// to += factor * from
    void (*add_scaled)(double factor, const float* from, std::int64_t count, double* to);
};
LbfgsKernels lbfgs_kernels(InstructionSet instructions);

}  // namespace meanvalue
