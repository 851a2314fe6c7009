// Calls of the fast method that several tests make, and the poses that they make it take.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "meanvalue/deform/deformer.h"
#include "tests/support.h"

namespace meanvalue::tests {

inline std::unique_ptr<Deformer> bound_to(const Mesh& mesh, const std::vector<Index>& anchors,
                                          std::optional<double> rigidity = {}, int threads = 1,
                                          const std::optional<std::vector<char>>& roi = {}) {
    Binding binding = binding_of(mesh, anchors, Method::kFast, threads, rigidity);
    binding.roi = roi;
    return bound(binding);
}

/// A mesh and anchors that are bent, twisted or pulled.
struct Pose {
    std::string name;
    Mesh mesh;
    std::vector<Index> anchors;
    Positions targets;
};

inline void PrintTo(const Pose& pose, std::ostream* stream) {
    *stream << pose.name;
}

/// A tube or bar whose lowest and highest vertices are anchors; the upper ones move.
inline Pose two_ends(const std::string& name, const Mesh& mesh, const Vector3& axis, double angle_rad,
                     const Vector3& translation) {
    Pose pose{name, mesh, {}, {}};
    const double low = mesh.vertices.col(2).minCoeff() + 0.2;
    const double high = mesh.vertices.col(2).maxCoeff() - 0.2;
    const Vector3 pivot(0, 0, high);
    Positions moved =
        moved_by_similarity(mesh.vertices.rowwise() - pivot.transpose(), 1.0, axis, angle_rad, pivot + translation);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.vertices(v, 2) < low || mesh.vertices(v, 2) > high) pose.anchors.push_back(v);
        if (mesh.vertices(v, 2) < low) moved.row(v) = mesh.vertices.row(v);
    }
    pose.targets = rows_of(moved, pose.anchors);
    return pose;
}

/// Its middle line becomes an arc of its own length, from z to -y.
inline Pose bend(const std::string& name, const Mesh& mesh, double angle_rad) {
    const double length = mesh.vertices.col(2).maxCoeff();
    const double radius = length / angle_rad;
    return two_ends(name, mesh, Vector3::UnitX(), angle_rad,
                    {0, -radius * (1 - std::cos(angle_rad)), radius * std::sin(angle_rad) - length});
}

inline Pose spread_pull(const std::string& name, const Mesh& mesh, Index count, const Vector3& pull) {
    Pose pose{name, mesh, spread_vertices(mesh, count), {}};
    pose.targets = rows_of(mesh.vertices, pose.anchors);
    pose.targets.row(count / 2) += pull.transpose();
    return pose;
}

inline std::vector<Pose> poses() {
    return {bend("bend", capped_tube(16, 25, 8.0), 1.5),
            two_ends("sheared bend", capped_tube(16, 25, 8.0), Vector3::UnitX(), 1.0, {0, 2, -1}),
            two_ends("twist", capped_tube(16, 25, 8.0), Vector3::UnitZ(), kPi / 2, {0, 0, 0}),
            bend("bend of a bar", bar(4, 16), 1.0),
            spread_pull("pull of a sphere", sphere(4), 6, {0.4, 0.2, 0.0}),
            spread_pull("pull of a torus", with_noise(torus(40, 20), 0.05, 1), 10, {0.5, 0.5, 1.0}),
            spread_pull("pull of a grid", grid(20, 18, 0.02), 9, {1.0, 0.0, 4.0}),
            spread_pull("pull of a large torus", with_noise(torus(80, 60), 0.05, 1), 8, {0.5, 0.5, 1.0}),
            bend("bend of a large bar", bar(12, 72), 1.2),
            bend("bend of a large tube", capped_tube(24, 150, 20.0), 1.2)};
}

/// Without the long thin tube, for which the iterations do not suffice without rigidity: see the disabled test.
inline std::vector<Pose> plain_poses() {
    std::vector<Pose> most = poses();
    most.pop_back();
    return most;
}

}  // namespace meanvalue::tests
