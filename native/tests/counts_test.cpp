// What fixed cases cost, in counts that no machine changes: beside those of counts.txt none may grow by over 3 %.
// `MEANVALUE_WRITE_COUNTS=1 ./dev test --only native -k Counts` writes that table anew, to be committed with what
// changed it.
#include <cstdlib>
#include <fstream>
#include <map>

#include "tests/failing_allocations.h"
#include "tests/fast_poses.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

using Counts = std::map<std::string, std::int64_t>;

constexpr double kMostGrowth = 1.03;
constexpr int kFrames = 8;
constexpr std::int64_t kMany = std::int64_t{1} << 40;

/// A bind, a solve from rest and a drag. Of bits that all processors have.
void count(const std::string& name, const Mesh& mesh, double strength, Counts& counts) {
    const auto at = [&](double angle_rad) { return bend("", mesh, angle_rad); };
    Binding binding = binding_of(mesh, at(1.0).anchors, Method::kFast, 1);
    binding.instructions = InstructionSet::kPortable;
    if (strength > 0.0) binding.strengths.assign(binding.anchors.size(), strength);
    std::unique_ptr<Deformer> deformer;
    {
        const FailingAllocation never(kMany);
        deformer = bound(binding);
        counts[name + " bind allocations"] = kMany - never.remaining();
    }
    counts[name + " bytes"] = static_cast<std::int64_t>(deformer->report().bytes);
    counts[name + " rows"] = deformer->report().row_count;
    const Solution cold = solve(*deformer, at(1.2).targets);
    counts[name + " cold iterations"] = cold.iterations;
    counts[name + " cold iterations of all levels"] = cold.all_iterations;
    Deformer::Drag drag(*deformer);
    solve_next(drag, at(0.05).targets);
    std::int64_t& iterations = counts[name + " drag iterations"];
    const FailingAllocation never(kMany);
    for (int frame = 2; frame <= kFrames; ++frame)
        iterations += solve_next(drag, at(0.05 * frame).targets).all_iterations;
    counts[name + " drag allocations"] = kMany - never.remaining();
}

TEST(Counts, AreThoseOfTheTable) {
#ifndef __x86_64__
    GTEST_SKIP() << "the table is of x86-64, others have other bits";
#endif
    if (!FailingAllocation::is_there()) GTEST_SKIP() << "sanitizers have allocations of their own";
    Counts counts;
    count("small tube", capped_tube(16, 25, 8.0), 0.0, counts);
    count("large tube", capped_tube(60, 120, 8.0), 0.0, counts);
    count("soft tube", capped_tube(40, 60, 8.0), 10.0, counts);
    count("bar", bar(12, 72), 0.0, counts);
    if (std::getenv("MEANVALUE_WRITE_COUNTS") != nullptr) {
        std::ofstream table(MEANVALUE_COUNTS);
        for (const auto& [name, value] : counts)
            table << value << ' ' << name << '\n';
        return;
    }
    std::ifstream table(MEANVALUE_COUNTS);
    std::int64_t value = 0;
    for (std::string name; table >> value && std::getline(table >> std::ws, name);) {
        ASSERT_EQ(counts.count(name), 1u) << name;
        EXPECT_LE(static_cast<double>(counts[name]), kMostGrowth * static_cast<double>(value))
            << name << ": if that is meant, write counts.txt anew, see above";
        counts.erase(name);
    }
    EXPECT_TRUE(counts.empty()) << "not in counts.txt: " << counts.begin()->first;
}

}  // namespace
}  // namespace meanvalue::tests
