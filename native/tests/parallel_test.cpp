#include "meanvalue/common/parallel.h"

#include <stdexcept>
#include <vector>

#include "meanvalue/common/errors.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

TEST(ParallelFor, VisitsEveryItemOnce) {
    for (const Index count : {0, 1, 2047, 2048, 2049, 100000}) {
        for (const int threads : {1, 2, 7}) {
            std::vector<int> visits(count, 0);
            parallel_for(count, threads, Execution(), [&](Index begin, Index end) {
                for (Index k = begin; k < end; ++k)
                    ++visits[k];
            });
            EXPECT_EQ(visits, std::vector<int>(count, 1));
        }
    }
}

TEST(ParallelFor, GivesTheFirstExceptionToTheCaller) {
    const auto fail_in_second_half = [](Index begin, Index) {
        if (begin >= 50000) throw std::logic_error(message(begin));
    };
    EXPECT_THROW(parallel_for(100000, 4, Execution(), fail_in_second_half), std::logic_error);
}

TEST(ParallelFor, StopsWhenCancelled) {
    Execution execution;
    std::atomic<int> pieces{0};
    const auto cancel_at_once = [&](Index, Index) {
        ++pieces;
        execution.cancel();
    };
    EXPECT_THROW(parallel_for(1 << 20, 2, execution, cancel_at_once), Cancelled);
    EXPECT_LE(pieces, 2);
}

TEST(ThreadCount, RefusesANegativeNumber) {
    EXPECT_GE(thread_count(0), 1);
    EXPECT_EQ(thread_count(3), 3);
    EXPECT_TRUE(contains(message_of<InvalidInput>([] { thread_count(-2); }), "-2"));
}

}  // namespace
}  // namespace meanvalue::tests
