// What every file of ours begins with where processors are no x86-64 ones (native/CMakeLists.txt).
//
// Eigen makes one rounding of a product and a sum where it is told that the processor can, whatever the compiler is
// told. Clang's own header needs the word, so it is taken back after that.
#pragma once

#if defined(__aarch64__)
#include <arm_neon.h>
#undef __ARM_FEATURE_FMA
#endif
