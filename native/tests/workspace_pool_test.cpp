#include "meanvalue/deform/workspace_pool.h"

#include <thread>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

struct FakeWorkspace : Workspace {
    FakeWorkspace(int number_of_it, std::size_t held) : number(number_of_it), held_bytes(held) {}
    bool has_answer() const override { return answer.size() > 0; }
    bool goes_on_from(const Positions& positions) const override { return has_answer() && answer == positions; }
    std::size_t bytes() const override { return held_bytes; }

    int number;
    std::size_t held_bytes;
    Positions answer;
};

/// Numbers its workspaces from 0.
class FakeDecoder : public Decoder {
  public:
    explicit FakeDecoder(std::size_t workspace_bytes, EncodedRegion shape = {})
        : Decoder(shape, 1), workspace_bytes_(workspace_bytes) {}
    std::unique_ptr<Workspace> make_workspace(const Execution& execution) const override {
        execution.check();
        return std::make_unique<FakeWorkspace>(made_++, workspace_bytes_);
    }
    DecodeReport decode(const DecodeOptions&, Workspace&, Positions&, Execution&) const override { return {}; }
    Index row_count() const override { return 0; }
    std::size_t bytes() const override { return 0; }
    std::vector<Index> level_sizes() const override { return {}; }
    Index longest_ring() const override { return 0; }
    int made() const { return made_; }

  private:
    std::size_t workspace_bytes_;
    mutable int made_ = 0;
};

constexpr std::size_t kSmall = 1000;
constexpr std::size_t kLarge = std::size_t{1} << 30;

Positions shape(double x) {
    return Positions::Constant(2, 3, x);
}

/// A solve from `from`, or from rest, that leaves an answer behind, or none. @return which workspace it had.
int solve(WorkspacePool& pool, const Positions* from, const Positions& answer) {
    const Execution execution;
    WorkspacePool::Loan loan(pool, from, execution);
    auto& workspace = static_cast<FakeWorkspace&>(loan.workspace());
    workspace.answer = answer;
    return workspace.number;
}

TEST(WorkspacePool, OneSolveAfterAnotherNeedsOne) {
    const FakeDecoder decoder(kSmall);
    WorkspacePool pool(decoder);
    for (int k = 0; k < 5; ++k)
        EXPECT_EQ(solve(pool, nullptr, {}), 0);
}

TEST(WorkspacePool, ADragGetsTheOneThatRemembersIt) {
    const FakeDecoder decoder(kSmall);
    WorkspacePool pool(decoder);
    const Positions one = shape(1), other = shape(2), stranger = shape(3);
    EXPECT_EQ(solve(pool, &stranger, one), 0);
    EXPECT_EQ(solve(pool, &stranger, other), 1);
    EXPECT_EQ(solve(pool, nullptr, {}), 2);
    EXPECT_EQ(solve(pool, &one, one), 0);
    EXPECT_EQ(solve(pool, &other, other), 1);
    EXPECT_EQ(solve(pool, nullptr, {}), 2);
}

TEST(WorkspacePool, KeepsAtMostEightOrTwoLargeOnesAndTheLastUsed) {
    for (const auto& [bytes, most] : {std::pair{kSmall, 8}, std::pair{kLarge, 2}}) {
        const FakeDecoder decoder(bytes);
        WorkspacePool pool(decoder);
        const Positions stranger = shape(-1);
        for (int drag = 0; drag < most; ++drag)
            EXPECT_EQ(solve(pool, &stranger, shape(drag)), drag);
        const Positions first = shape(0);
        EXPECT_EQ(solve(pool, &first, first), 0);
        // No room for another: the one that was used longest ago begins anew.
        EXPECT_EQ(solve(pool, &stranger, shape(100)), 1);
        EXPECT_EQ(decoder.made(), most);
        EXPECT_EQ(solve(pool, &first, first), 0);
    }
}

TEST(WorkspacePool, SolvesAtOnceHaveOneEachAndSurplusOnesAreFreed) {
    const FakeDecoder decoder(kLarge);
    WorkspacePool pool(decoder);
    const Execution execution;
    {
        std::vector<std::unique_ptr<WorkspacePool::Loan>> loans;
        loans.reserve(5);
        for (int k = 0; k < 5; ++k) {
            loans.push_back(std::make_unique<WorkspacePool::Loan>(pool, nullptr, execution));
            EXPECT_EQ(static_cast<FakeWorkspace&>(loans.back()->workspace()).number, k);
        }
    }
    std::vector<std::unique_ptr<WorkspacePool::Loan>> loans;
    loans.reserve(3);
    for (int k = 0; k < 3; ++k)
        loans.push_back(std::make_unique<WorkspacePool::Loan>(pool, nullptr, execution));
    EXPECT_EQ(decoder.made(), 6);
}

TEST(WorkspacePool, WaitsForWhatACancelledSolveHoldsAndNotForOthers) {
    const FakeDecoder decoder(kSmall);
    WorkspacePool pool(decoder);
    const Positions answer = shape(1);
    solve(pool, nullptr, answer);
    Execution cancelled;
    auto held = std::make_unique<WorkspacePool::Loan>(pool, &answer, cancelled);
    EXPECT_EQ(solve(pool, &answer, {}), 1);  // it runs on: another one
    cancelled.cancel();
    std::thread giving_back([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        held.reset();
    });
    EXPECT_EQ(solve(pool, &answer, {}), 0);
    giving_back.join();
}

TEST(WorkspacePool, ACancelWhileAWorkspaceIsMadeLeavesNothing) {
    const FakeDecoder decoder(kSmall);
    WorkspacePool pool(decoder);
    Execution cancelled;
    cancelled.cancel();
    EXPECT_THROW(WorkspacePool::Loan(pool, nullptr, cancelled), Cancelled);
    const Positions stranger = shape(1);
    EXPECT_EQ(solve(pool, &stranger, {}), 0);  // does not wait for it
}

}  // namespace
}  // namespace meanvalue::tests
