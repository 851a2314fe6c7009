// The short lane of fuzzing, with bytes of a fixed seed: ./dev fuzz goes on with others, under sanitizers.
#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <map>
#include <random>
#include <vector>

#include "fuzz/entries.h"

namespace meanvalue::tests {
namespace {

using fuzz::Outcome;

int from_environment(const char* name, int otherwise) {
    const char* wanted = std::getenv(name);
    return wanted != nullptr ? std::atoi(wanted) : otherwise;
}

/// Of each entry; MEANVALUE_FUZZ_RUNS is another number.
int wanted_runs(int by_itself) {
    return from_environment("MEANVALUE_FUZZ_RUNS", by_itself);
}

/// Each run has bytes of its own number, so that MEANVALUE_FUZZ_FIRST repeats it alone.
std::vector<std::uint8_t> bytes_of(int run) {
    std::mt19937 random(run);
    std::vector<std::uint8_t> bytes(random() % 2000);
    for (std::uint8_t& byte : bytes)
        byte = static_cast<std::uint8_t>(random());
    return bytes;
}

/// Seconds of processor time after which an input is taken to hang, as libFuzzer's -timeout in ./dev.
constexpr double kHangsAfter = 10.0;

/// How often each outcome came about in so many runs.
std::map<Outcome, int> outcomes(Outcome (*entry)(fuzz::Bytes), int runs) {
    const int first = from_environment("MEANVALUE_FUZZ_FIRST", 0);
    std::map<Outcome, int> counts;
    for (int run = first; run < first + runs; ++run) {
        const std::vector<std::uint8_t> bytes = bytes_of(run);
        const std::clock_t begun = std::clock();
        try {
            ++counts[entry({bytes.data(), bytes.size()})];
        } catch (const std::exception& error) {
            ADD_FAILURE() << "run " << run << ": " << error.what();
        }
        EXPECT_LT(static_cast<double>(std::clock() - begun), kHangsAfter * CLOCKS_PER_SEC) << "run " << run;
    }
    return counts;
}

void expect_both(std::map<Outcome, int> counts, int runs) {
    EXPECT_GT(counts[Outcome::kSolved], runs / 10);
    EXPECT_GT(counts[Outcome::kRefused], runs / 10);
    EXPECT_LT(counts[Outcome::kFailed], runs / 10);
}

TEST(Fuzz, BindAndSolveEndInAResultOrAnErrorOfOurs) {
    const int runs = wanted_runs(400);
    expect_both(outcomes(&fuzz::bind_and_solve, runs), runs);
}

TEST(Fuzz, WhatWasFoundIsMended) {
    for (const int run :
         {300179, 300489, 303328, 447875, 474707, 485865}) {  // soft borders of loose parts; far from the origin
        const std::vector<std::uint8_t> bytes = bytes_of(run);
        EXPECT_NO_THROW(fuzz::bind_and_solve({bytes.data(), bytes.size()})) << run;
    }
}

TEST(Fuzz, MorphsEndInAResultOrAnErrorOfOurs) {
    const int runs = wanted_runs(200);
    expect_both(outcomes(&fuzz::morph, runs), runs);
}

TEST(Fuzz, SurfacesEndInAResultOrAnErrorOfOurs) {
    const int runs = wanted_runs(400);
    expect_both(outcomes(&fuzz::surface, runs), runs);
}

TEST(Fuzz, SequencesEndInAResultOrAnErrorOfOurs) {
    const int runs = wanted_runs(200);
    expect_both(outcomes(&fuzz::sequence, runs), runs);
}

}  // namespace
}  // namespace meanvalue::tests
