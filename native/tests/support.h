// What several tests need: the encoding of a test mesh, and the message of an expected error.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/execution.h"
#include "meanvalue/deform/bound_mesh.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/triangle_mesh.h"
#include "tests/meshes.h"

namespace meanvalue::tests {

inline Encoding encoding_of(const Mesh& mesh, int threads = 1) {
    Execution execution;
    const TriangleMesh connectivity(mesh.vertex_count(), mesh.faces, execution);
    return encode(collect_one_rings(connectivity, execution), mesh.vertices, threads, execution);
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

inline double largest_distance(const Positions& a, const Positions& b) {
    return (a - b).rowwise().norm().maxCoeff();
}

/// Runs action(execution) again and again, each time cancelled at a later look at the flag, until it gets through.
/// @return the stages in which it was cancelled, without repetitions.
template <typename Action>
std::vector<std::string> cancelled_everywhere(const Action& action) {
    std::vector<std::string> stages;
    for (std::int64_t look = 1;; look += 1 + look / 16) {
        Execution execution;
        execution.cancel_at_look(look);
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
