// What several tests need: encodings, binds and solves of a test mesh, and what is expected of errors and cancels.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/execution.h"
#include "meanvalue/deform/deformer.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/mesh/one_ring.h"
#include "tests/meshes.h"

namespace meanvalue::tests {

inline OneRings rings_of(const Mesh& mesh) {
    return collect_one_rings(mesh.vertex_count(), mesh.faces, Execution());
}

inline Encoding encoding_of(const Mesh& mesh, int threads = 1, bool with_cotangents = false) {
    Execution execution;
    return encode(rings_of(mesh), mesh.vertices, threads, execution, with_cotangents);
}

/// The text of the Error that `action` throws; fails the test where it throws none.
template <typename Error, typename Action>
std::string message_of(Action&& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return {};
}

inline Binding binding_of(const Mesh& mesh, const std::vector<Index>& anchors, Method method = Method::kFast,
                          int threads = 0, std::optional<double> rigidity = {}) {
    Binding binding(mesh.vertices, mesh.faces, anchors);
    binding.method = method;
    binding.threads = threads;
    binding.rigidity = rigidity;
    return binding;
}

inline std::unique_ptr<Deformer> bound(const Binding& binding, const Deformer* earlier = nullptr) {
    Execution execution;
    return std::make_unique<Deformer>(binding, execution, earlier);
}

inline Solution solve(const Deformer& deformer, const Positions& targets, const SolveOptions& options = {}) {
    return deformer.solve(targets, options);
}

inline Solution solve_from(const Deformer& deformer, const Positions& targets, const Positions& start,
                           const SolveOptions& options = {}) {
    Execution execution;
    return deformer.solve(targets, PositionsView(start), options, execution);
}

inline Solution solve_next(Deformer::Drag& drag, const Positions& targets, const SolveOptions& options = {}) {
    Execution execution;
    return drag.solve(targets, options, execution);
}

inline void expect_energy_never_rises(const Solution& solution) {
    for (std::size_t k = 1; k < solution.energies.size(); ++k)
        EXPECT_LE(solution.energies[k], solution.energies[k - 1]) << "iteration " << k;
}

inline double largest_distance(const Positions& a, const Positions& b) {
    return (a - b).rowwise().norm().maxCoeff();
}

/// Runs action(execution) again and again, each time cancelled at a later check, until it gets through.
/// @return the stages in which it was cancelled, without repetitions.
template <typename Action>
std::vector<std::string> cancelled_everywhere(const Action& action) {
    std::vector<std::string> stages;
    for (std::int64_t check = 1;; check += 1 + check / 16) {
        Execution execution;
        execution.cancel_at_check(check);
        try {
            action(execution);
            return stages;
        } catch (const Cancelled&) {
            if (stages.empty() || stages.back() != execution.stage()) stages.emplace_back(execution.stage());
        }
    }
}

inline bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace meanvalue::tests
