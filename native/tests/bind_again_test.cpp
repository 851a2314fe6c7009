// Binding the same mesh to other anchors: the bits are those of a fresh bind, whatever was bound before.
#include <algorithm>
#include <random>
#include <thread>

#include "meanvalue/deform/bound_mesh.h"
#include "meanvalue/deform/deformer.h"
#include "meanvalue/mesh/region.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

constexpr Method kMethods[] = {Method::kFast, Method::kPaper, Method::kFull};

Mesh mesh_for(Method method) {
    return method == Method::kFast ? with_noise(capped_tube(40, 60, 8.0), 0.05, 1) : capped_tube(12, 25, 8.0);
}

/// The `count` vertices nearest to `centre`, itself among them.
std::vector<Index> around(const Mesh& mesh, Index centre, Index count) {
    std::vector<Index> vertices(mesh.vertex_count());
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        vertices[v] = v;
    const auto distance = [&](Index v) { return (mesh.vertices.row(v) - mesh.vertices.row(centre)).norm(); };
    std::sort(vertices.begin(), vertices.end(),
              [&](Index a, Index b) { return std::pair(distance(a), a) < std::pair(distance(b), b); });
    vertices.resize(count);
    return vertices;
}

/// Patches of vertices about random centres, each a handle; none shares a vertex with another.
struct Handles {
    std::vector<Index> anchors;
    std::vector<Index> handles;
    std::vector<double> strengths;

    Handles(const Mesh& mesh, std::mt19937& random, int count, Index largest, bool has_soft) {
        std::vector<char> taken(mesh.vertex_count(), 0);
        for (int handle = 0; handle < count; ++handle) {
            const auto centre = static_cast<Index>(random() % mesh.vertex_count());
            const bool is_soft = has_soft && random() % 2 == 0;
            for (const Index v : around(mesh, centre, 1 + static_cast<Index>(random() % largest))) {
                if (taken[v]) continue;
                taken[v] = 1;
                add(v, handle, is_soft ? 0.5 : std::numeric_limits<double>::infinity());
            }
        }
    }

    void add(Index vertex, Index handle, double strength = std::numeric_limits<double>::infinity()) {
        anchors.push_back(vertex);
        handles.push_back(handle);
        strengths.push_back(strength);
    }

    Binding binding(Binding of) const {
        of.anchors = anchors;
        of.handles = handles;
        if (of.method == Method::kFast) of.strengths = strengths;
        return of;
    }
    /// Every handle moved, each another way.
    Positions targets(const Mesh& mesh) const {
        Positions rows = rows_of(mesh.vertices, anchors);
        for (std::size_t k = 0; k < anchors.size(); ++k)
            rows.row(k) +=
                0.05 * mesh.diagonal() * Eigen::RowVector3d(std::sin(handles[k]), 0.3, std::cos(handles[k]));
        return rows;
    }
};

Binding fresh_binding(const Mesh& mesh, Method method, int threads = 1) {
    return binding_of(mesh, {}, method, threads);
}

TEST(BindAgain, HasTheBitsOfAFreshBind) {
    for (const Method method : kMethods) {
        const Mesh mesh = mesh_for(method);
        std::mt19937 random(3);
        Handles handles(mesh, random, 3, 30, method == Method::kFast);
        auto deformer = bound(handles.binding(fresh_binding(mesh, method)));
        // From each to the next: with other handles, more of them and fewer, hard and soft ones.
        for (int round = 0; round < (method == Method::kFast ? 6 : 3); ++round) {
            handles = Handles(mesh, random, 2 + round % 3, 30, method == Method::kFast && round % 2 == 1);
            auto again = bound(handles.binding(deformer->binding_again()), deformer.get());
            const auto fresh = bound(handles.binding(fresh_binding(mesh, method, 2)));
            EXPECT_EQ(again->report().level_sizes, fresh->report().level_sizes);
            EXPECT_EQ(again->report().guarded, fresh->report().guarded);
            const Solution expected = solve(*fresh, handles.targets(mesh));
            const Solution found = solve(*again, handles.targets(mesh));
            EXPECT_EQ(found.vertices, expected.vertices) << static_cast<int>(method) << " " << round;
            EXPECT_EQ(found.energies, expected.energies);
            deformer = std::move(again);  // the earlier one goes first
        }
    }
}

TEST(BindAgain, SharesTheEncodingAndLeavesTheEarlierOneAsItWas) {
    for (const Method method : kMethods) {
        const Mesh mesh = mesh_for(method);
        std::mt19937 random(5);
        const Handles first(mesh, random, 2, 1, false);
        const auto deformer = bound(first.binding(fresh_binding(mesh, method)));
        const Solution before = solve(*deformer, first.targets(mesh));
        const Handles second(mesh, random, 3, 1, false);
        const auto again = bound(second.binding(deformer->binding_again()), deformer.get());
        EXPECT_EQ(&again->bound().parts().front().decoder->encoding(),
                  &deformer->bound().parts().front().decoder->encoding());
        EXPECT_EQ(solve(*deformer, first.targets(mesh)).vertices, before.vertices);
        EXPECT_EQ(deformer->report().anchor_count, static_cast<Index>(first.anchors.size()));
    }
}

TEST(BindAgain, LargeHandlesAndNewPartsAreBoundAfresh) {
    const Mesh part = capped_tube(12, 25, 8.0);
    Mesh two = joined(part, part);
    std::mt19937 random(7);
    const Handles few(part, random, 2, 1, false);
    const auto deformer = bound(few.binding(fresh_binding(two, Method::kFull)));
    Handles large = few;
    for (const Index v : around(part, 150, 60)) {
        if (std::find(few.anchors.begin(), few.anchors.end(), v) == few.anchors.end()) large.add(v, 2);
    }
    Handles other_part = few;
    other_part.add(part.vertex_count() + 3, 2);
    for (const Handles& handles : {large, other_part}) {
        const auto again = bound(handles.binding(deformer->binding_again()), deformer.get());
        EXPECT_NE(&again->bound().parts().front().decoder->encoding(),
                  &deformer->bound().parts().front().decoder->encoding());
        const auto fresh = bound(handles.binding(fresh_binding(two, Method::kFull)));
        EXPECT_EQ(solve(*again, handles.targets(two)).vertices, solve(*fresh, handles.targets(two)).vertices);
    }
}

TEST(BindAgain, CanBeCancelledEverywhere) {
    const Mesh mesh = mesh_for(Method::kFast);
    std::mt19937 random(9);
    const Handles first(mesh, random, 2, 20, false);
    const Handles second(mesh, random, 3, 20, true);
    const auto deformer = bound(first.binding(fresh_binding(mesh, Method::kFast)));
    const Solution before = solve(*deformer, first.targets(mesh));
    const std::vector<std::string> stages = cancelled_everywhere([&](Execution& execution) {
        Deformer(second.binding(deformer->binding_again()), execution, deformer.get());
    });
    EXPECT_EQ(stages.back(), "factor");
    EXPECT_EQ(solve(*deformer, first.targets(mesh)).vertices, before.vertices);
}

TEST(BindAgain, SeveralAtOnceShareOneEarlierDeformer) {
    const Mesh mesh = mesh_for(Method::kFast);
    std::mt19937 random(11);
    const auto deformer = bound(Handles(mesh, random, 2, 20, false).binding(fresh_binding(mesh, Method::kFast)));
    std::vector<Handles> handles;
    std::vector<Positions> expected;
    for (int k = 0; k < 3; ++k) {
        handles.emplace_back(mesh, random, 2 + k, 20, k == 1);
        const auto fresh = bound(handles[k].binding(fresh_binding(mesh, Method::kFast)));
        expected.push_back(solve(*fresh, handles[k].targets(mesh)).vertices);
    }
    std::vector<Positions> found(handles.size());
    std::vector<std::thread> threads;
    threads.reserve(handles.size());
    for (std::size_t k = 0; k < handles.size(); ++k) {
        threads.emplace_back([&, k] {
            const auto again = bound(handles[k].binding(deformer->binding_again()), deformer.get());
            found[k] = solve(*again, handles[k].targets(mesh)).vertices;
        });
    }
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(found, expected);
}

TEST(Region, SmallPatchesOfAnchorsDoNotCutIt) {
    const Mesh mesh = grid(40, 40, 0.0);
    std::vector<char> is_fixed(mesh.vertex_count(), 0);
    const std::vector<char> may_move(mesh.vertex_count(), 1);
    for (const Index v : around(mesh, 410, 25))  // as many as a 64th
        is_fixed[v] = 1;
    EXPECT_EQ(without_small_patches(is_fixed, may_move, mesh.faces, Execution()),
              std::vector<char>(mesh.vertex_count(), 0));
    std::vector<char> with_large = is_fixed;
    std::vector<char> large_alone(mesh.vertex_count(), 0);
    for (const Index v : around(mesh, 1230, 30))
        with_large[v] = large_alone[v] = 1;
    EXPECT_EQ(without_small_patches(with_large, may_move, mesh.faces, Execution()), large_alone);
    // What is fixed because it may not move is no anchor.
    EXPECT_EQ(without_small_patches(is_fixed, std::vector<char>(mesh.vertex_count(), 0), mesh.faces, Execution()),
              is_fixed);
}

}  // namespace
}  // namespace meanvalue::tests
