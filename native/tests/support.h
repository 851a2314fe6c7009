// What several tests need: the encoding of a test mesh, and the message of an expected error.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "meanvalue/common/execution.h"
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

inline double largest_distance(const Positions& a, const Positions& b) {
    return (a - b).rowwise().norm().maxCoeff();
}

inline bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace meanvalue::tests
