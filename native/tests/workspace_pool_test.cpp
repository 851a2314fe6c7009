#include "meanvalue/deform/workspace_pool.h"

#include <array>
#include <optional>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

class FakeDecoder : public Decoder {
  public:
    explicit FakeDecoder(std::size_t workspace_bytes, EncodedRegion shape = {})
        : Decoder(shape, 1), workspace_bytes_(workspace_bytes) {}
    std::unique_ptr<Workspace> make_workspace(const Execution&) const override {
        ++made_;
        return std::make_unique<Workspace>();
    }
    DecodeReport decode(const DecodeOptions&, Workspace&, Positions&, Execution&) const override { return {}; }
    Index row_count() const override { return 0; }
    MemoryUse memory() const override { return {0, workspace_bytes_}; }
    std::vector<Index> level_sizes() const override { return {}; }
    Index longest_ring() const override { return 0; }
    int made() const { return made_; }

  private:
    std::size_t workspace_bytes_;
    mutable int made_ = 0;
};

/// Has ten loans at once, twice. @return how many workspaces were made.
int made_for_ten(std::size_t workspace_bytes) {
    const FakeDecoder decoder(workspace_bytes);
    WorkspacePool pool(decoder);
    for (int round = 0; round < 2; ++round) {
        std::array<std::optional<WorkspacePool::Loan>, 10> loans;
        for (auto& loan : loans)
            loan.emplace(pool, Execution());
    }
    return decoder.made();
}

TEST(WorkspacePool, KeepsWhatFits) {
    EXPECT_EQ(made_for_ten(1000), 12);
    EXPECT_EQ(made_for_ten(std::size_t{1} << 30), 18);
}

}  // namespace
}  // namespace meanvalue::tests
