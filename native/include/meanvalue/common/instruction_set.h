// Which of the forms that the inner loops are compiled in is used.
#pragma once  // SPDX-License-Identifier: MPL-2.0

namespace meanvalue {

enum class InstructionSet {
    kFastest,  ///< with AVX2 and FMA where the processor has them, which round less often than others
    kPortable  ///< what all processors of an architecture have: the same bits on each of them
};

/// Whether this processor has AVX2 and FMA and the system keeps their registers. Asked of the processor once.
bool has_avx2_and_fma();

/// Has Eigen divide its products alike on every processor, and so sum them alike: by its default it asks for the
/// caches. For the process, once.
void pin_eigen_cache_sizes();

/// Whether the form with AVX2 and FMA is to be used.
inline bool use_avx2_and_fma(InstructionSet instructions) {
    return instructions == InstructionSet::kFastest && has_avx2_and_fma();
}

}  // namespace meanvalue
