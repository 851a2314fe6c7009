#include "meanvalue/common/instruction_set.h"

#include <Eigen/Core>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace meanvalue {
namespace {

#if defined(__x86_64__)
// Instead of __builtin_cpu_supports(), which needs the compiler's run-time library to have asked before: that of the
// compiler which the wheels are made with never does, and every processor seems to be the plainest.
bool ask_processor() {
    unsigned a = 0;
    unsigned b = 0;
    unsigned c = 0;
    unsigned d = 0;
    const unsigned needed = bit_FMA | bit_AVX | bit_OSXSAVE;
    if (__get_cpuid(1, &a, &b, &c, &d) == 0 || (c & needed) != needed) return false;
    unsigned low = 0;
    unsigned high = 0;
    __asm__ __volatile__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    const unsigned sse_and_avx_registers = 6;
    if ((low & sse_and_avx_registers) != sse_and_avx_registers) return false;
    return __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (b & bit_AVX2) != 0;
}
#else
bool ask_processor() {
    return false;
}
#endif

}  // namespace

bool has_avx2_and_fma() {
    static const bool answer = ask_processor();
    return answer;
}

void pin_eigen_cache_sizes() {
    static const bool is_done = [] {
        Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 2 << 20);
        return true;
    }();
    static_cast<void>(is_done);
}

}  // namespace meanvalue
