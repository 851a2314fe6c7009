// Which of the forms that the inner loops are compiled in is used.
#pragma once

namespace meanvalue {

enum class InstructionSet {
    kFastest,  ///< with AVX2 and FMA where the processor has them, which round less often than others
    kPortable  ///< what all processors of an architecture have: the same bits on each of them
};

/// Whether the form with AVX2 and FMA is to be used.
inline bool use_avx2_and_fma([[maybe_unused]] InstructionSet instructions) {
#if defined(__x86_64__)
    return instructions == InstructionSet::kFastest && __builtin_cpu_supports("avx2") &&
           __builtin_cpu_supports("fma");
#else
    return false;
#endif
}

}  // namespace meanvalue
