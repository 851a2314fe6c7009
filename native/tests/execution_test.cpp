#include "meanvalue/common/execution.h"

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

TEST(Execution, ChecksThrowOnceCancelled) {
    Execution execution;
    EXPECT_NO_THROW(execution.check());
    execution.begin_stage("encode");
    EXPECT_STREQ(execution.stage(), "encode");
    execution.cancel();
    EXPECT_THROW(execution.check(), Cancelled);
    EXPECT_THROW(execution.begin_stage("solve"), Cancelled);
    EXPECT_STREQ(execution.stage(), "encode");
}

TEST(WorkMeter, LooksByTheWorkDone) {
    Execution execution;
    WorkMeter work(execution);
    execution.cancel();
    EXPECT_NO_THROW(work.add(1000));
    EXPECT_THROW(work.add(10'000'000), Cancelled);
    EXPECT_NO_THROW(work.add(1000));
}

}  // namespace
}  // namespace meanvalue::tests
