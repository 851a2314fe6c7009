// Which form of the inner loops is taken.
#include "meanvalue/common/instruction_set.h"

#include <gtest/gtest.h>

namespace meanvalue {
namespace {

TEST(InstructionSet, PortableTakesThePlainForm) {
    EXPECT_FALSE(use_avx2_and_fma(InstructionSet::kPortable));
}

TEST(InstructionSet, FastestTakesWhatTheCompilerFindsInTheProcessor) {
#if defined(__x86_64__)
    const bool expected = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
#else
    const bool expected = false;
#endif
    EXPECT_EQ(use_avx2_and_fma(InstructionSet::kFastest), expected);
}

}  // namespace
}  // namespace meanvalue
