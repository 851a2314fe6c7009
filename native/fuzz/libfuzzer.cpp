// The main program of a fuzzer is libFuzzer's, which calls this; built once for each of entries.h.
#include "fuzz/entries.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    meanvalue::fuzz::MEANVALUE_FUZZ_ENTRY(meanvalue::fuzz::Bytes(data, size));
    return 0;
}
