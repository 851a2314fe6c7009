// Keeps Eigen from fusing products and sums: native/CMakeLists.txt includes it first in every file of ours, except on
// x86-64.
//
// Eigen fuses wherever __ARM_FEATURE_FMA is defined, even with -ffp-contract=off; the bits would not be those of
// x86-64. Clang's arm_neon.h needs the macro itself, so that header comes first.
#pragma once

#if defined(__aarch64__)
#include <arm_neon.h>
#undef __ARM_FEATURE_FMA
#endif
