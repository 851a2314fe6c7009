#include "meanvalue/optimise/lbfgs_kernels.h"

#include <cstring>

#define MEANVALUE_INLINE inline __attribute__((always_inline))

namespace meanvalue {
namespace {

using Double4 = double __attribute__((vector_size(32)));
using Float4 = float __attribute__((vector_size(16)));

MEANVALUE_INLINE Double4 load(const double* from) {
    Double4 result;
    std::memcpy(&result, from, sizeof result);
    return result;
}

MEANVALUE_INLINE Double4 load(const float* from) {
    Float4 result;
    std::memcpy(&result, from, sizeof result);
    return __builtin_convertvector(result, Double4);
}

MEANVALUE_INLINE double sum(const Double4& of) {
    return (of[0] + of[1]) + (of[2] + of[3]);
}

MEANVALUE_INLINE double dot(const float* a, const double* b, std::int64_t count) {
    Double4 even{}, odd{};
    std::int64_t k = 0;
    for (; k + 8 <= count; k += 8) {
        even += load(a + k) * load(b + k);
        odd += load(a + k + 4) * load(b + k + 4);
    }
    double rest = 0.0;
    for (; k < count; ++k)
        rest += static_cast<double>(a[k]) * b[k];
    return sum(even + odd) + rest;
}

MEANVALUE_INLINE void cross_dots(const float* step, const float* change, const float* other_step,
                                 const float* other_change, std::int64_t count, double* sums) {
    Double4 first{}, second{};
    std::int64_t k = 0;
    for (; k + 4 <= count; k += 4) {
        first += load(step + k) * load(other_change + k);
        second += load(other_step + k) * load(change + k);
    }
    double rest[2] = {0.0, 0.0};
    for (; k < count; ++k) {
        rest[0] += static_cast<double>(step[k]) * other_change[k];
        rest[1] += static_cast<double>(other_step[k]) * change[k];
    }
    sums[0] += sum(first) + rest[0];
    sums[1] += sum(second) + rest[1];
}

MEANVALUE_INLINE void add_scaled(double factor, const float* from, std::int64_t count, double* to) {
    std::int64_t k = 0;
    for (; k + 4 <= count; k += 4) {
        const Double4 result = load(to + k) + factor * load(from + k);
        std::memcpy(to + k, &result, sizeof result);
    }
    // By the same instructions, since the number of threads decides which rows these are.
    if (k < count) {
        Double4 rest{};
        Float4 added{};
        std::memcpy(&rest, to + k, (count - k) * sizeof(double));
        std::memcpy(&added, from + k, (count - k) * sizeof(float));
        const Double4 result = rest + factor * __builtin_convertvector(added, Double4);
        std::memcpy(to + k, &result, (count - k) * sizeof(double));
    }
}

double dot_portable(const float* a, const double* b, std::int64_t count) {
    return dot(a, b, count);
}
void cross_dots_portable(const float* step, const float* change, const float* other_step, const float* other_change,
                         std::int64_t count, double* sums) {
    cross_dots(step, change, other_step, other_change, count, sums);
}
void add_scaled_portable(double factor, const float* from, std::int64_t count, double* to) {
    add_scaled(factor, from, count, to);
}

#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) double dot_avx2(const float* a, const double* b, std::int64_t count) {
    return dot(a, b, count);
}
__attribute__((target("avx2,fma"))) void cross_dots_avx2(const float* step, const float* change,
                                                         const float* other_step, const float* other_change,
                                                         std::int64_t count, double* sums) {
    cross_dots(step, change, other_step, other_change, count, sums);
}
__attribute__((target("avx2,fma"))) void add_scaled_avx2(double factor, const float* from, std::int64_t count,
                                                         double* to) {
    add_scaled(factor, from, count, to);
}
#endif

}  // namespace

LbfgsKernels lbfgs_kernels([[maybe_unused]] InstructionSet instructions) {
#if defined(__x86_64__)
    if (use_avx2_and_fma(instructions)) return {dot_avx2, cross_dots_avx2, add_scaled_avx2};
#endif
    return {dot_portable, cross_dots_portable, add_scaled_portable};
}

}  // namespace meanvalue
