#include "fuzz/odd_input.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace meanvalue::fuzz {
namespace {

Mesh read_plain_surface(Bytes& bytes, int kind) {
    const Index size = 3 + bytes.below(8);
    const Index other_size = 3 + bytes.below(6);
    const double height = 0.1 * bytes.below(3);
    switch (kind) {
        case 0:
            return tests::grid(size, other_size, height);
        case 1:
            return tests::capped_tube(size, other_size, 4.0);
        case 2:
            return tests::torus(size, other_size);
        case 3:
            return tests::sphere(other_size % 3);
        case 4:
            return tests::joined(tests::grid(size, 3, height), tests::sphere(other_size % 2));
        default:
            return bytes.once_in(2) ? tests::triangle() : tests::strip();
    }
}

Mesh read_heap(Bytes& bytes) {
    Mesh mesh;
    mesh.vertices.resize(bytes.below(24), 3);
    mesh.faces.resize(mesh.vertex_count() == 0 ? 0 : bytes.below(40), 3);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        for (int axis = 0; axis < 3; ++axis)
            mesh.vertices(v, axis) = bytes.number();
    }
    for (Eigen::Index t = 0; t < mesh.faces.rows(); ++t) {
        for (int corner = 0; corner < 3; ++corner)
            mesh.faces(t, corner) = bytes.once_in(200) ? bytes.below(99) - 50 : bytes.below(mesh.vertex_count());
    }
    return mesh;
}

/// With a small ball or a triangle beside it, inside it or far away, which mostly nothing holds.
Mesh with_another_part(Bytes& bytes, const Mesh& mesh) {
    Mesh part = bytes.once_in(4) ? tests::triangle() : tests::sphere(bytes.below(2));
    part.vertices *= 0.05 * bytes.below(8);
    const Index near = bytes.below(mesh.vertex_count());
    part.vertices.rowwise() += mesh.vertices.row(near);
    part.vertices.col(bytes.below(3)).array() += bytes.once_in(4) ? bytes.number() : 0.1 * bytes.below(4);
    return tests::joined(mesh, part);
}

void add_face(Mesh& mesh, Index a, Index b, Index c) {
    mesh.faces.conservativeResize(mesh.faces.rows() + 1, 3);
    mesh.faces.row(mesh.faces.rows() - 1) << a, b, c;
}

/// One thing that may be wrong with a mesh. @pre it has vertices and faces.
void spoil(Bytes& bytes, Mesh& mesh) {
    const Index v = bytes.below(mesh.vertex_count());
    const Index w = bytes.below(mesh.vertex_count());
    const auto t = bytes.below(static_cast<Index>(mesh.faces.rows()));
    switch (bytes.below(10)) {
        case 0:
            mesh.vertices.row(v) = mesh.vertices.row(w);
            break;
        case 1:
            mesh.vertices(v, bytes.below(3)) = bytes.number();
            break;
        case 2:
            mesh.vertices.row(v) += 1e-9 * (mesh.vertices.row(w) - mesh.vertices.row(v));
            break;
        case 3:
            std::swap(mesh.faces(t, 0), mesh.faces(t, 1));
            break;
        case 4:
            add_face(mesh, mesh.faces(t, 0), mesh.faces(t, 1), mesh.faces(t, 2));
            break;
        case 5:
            add_face(mesh, mesh.faces(t, 0), mesh.faces(t, 1), w);
            break;
        case 6:
            mesh.faces(t, bytes.below(3)) = w;
            break;
        case 7:
            mesh.faces(t, bytes.below(3)) = bytes.once_in(4) ? bytes.below(2000) - 1000 : v;
            break;
        case 8:
            mesh.vertices.col(bytes.below(3)) *= bytes.once_in(2) ? 0.0 : bytes.number();
            break;
        default:
            mesh.faces.conservativeResize(mesh.faces.rows() - 1, 3);
            break;
    }
}

}  // namespace

Mesh read_mesh(Bytes& bytes) {
    Mesh mesh;
    const int kind = bytes.below(8);
    if (kind > 5) {
        mesh = read_heap(bytes);
    } else {
        mesh = read_plain_surface(bytes, kind);
        for (int parts = bytes.once_in(4) ? 1 + bytes.below(3) : 0; parts > 0; --parts)
            mesh = with_another_part(bytes, mesh);
        for (int flaws = bytes.below(8); flaws > 0 && mesh.faces.rows() > 0; --flaws)
            spoil(bytes, mesh);
    }
    if (bytes.once_in(4)) mesh.vertices *= std::pow(10.0, bytes.below(140) - 70);
    if (bytes.once_in(8)) mesh.vertices.col(bytes.below(3)).array() += 1e6 * bytes.number();
    return mesh;
}

Positions read_other_shape(Bytes& bytes, const Mesh& mesh) {
    Positions shape = mesh.vertices;
    if (bytes.once_in(4)) {
        const double turned = -1.0 + bytes.below(3);
        shape.col(0) = turned * mesh.vertices.col(1);
        shape.col(1) = -mesh.vertices.col(0);
    }
    const double reach =
        bounding_box_diagonal(mesh.vertices) * std::pow(10.0, bytes.once_in(8) ? bytes.below(9) - 4 : -1);
    for (int moved = bytes.below(20); moved > 0 && mesh.vertex_count() > 0; --moved) {
        const Index v = bytes.below(mesh.vertex_count());
        shape(v, bytes.below(3)) += reach * bytes.number();
    }
    if (bytes.once_in(64)) shape.conservativeResize(bytes.below(6), 3);
    return shape;
}

Positions read_targets(Bytes& bytes, const Mesh& mesh, const std::vector<Index>& anchors) {
    Positions targets(static_cast<Eigen::Index>(anchors.size()), 3);
    const double reach =
        bounding_box_diagonal(mesh.vertices) * std::pow(10.0, bytes.once_in(8) ? bytes.below(12) - 5 : -1);
    for (std::size_t k = 0; k < anchors.size(); ++k) {
        const bool is_vertex = anchors[k] >= 0 && anchors[k] < mesh.vertex_count();
        for (int axis = 0; axis < 3; ++axis)
            targets(k, axis) = (is_vertex ? mesh.vertices(anchors[k], axis) : 0.0) + reach * bytes.number();
    }
    if (bytes.once_in(16)) targets.conservativeResize(bytes.below(4), 3);
    return targets;
}

namespace {

/// Some of the anchors, mostly soft ones.
void read_border(Bytes& bytes, Binding& binding) {
    const bool is_soft = !bytes.once_in(8);
    for (std::size_t k = 0; k < binding.anchors.size(); ++k) {
        binding.is_border.push_back(bytes.once_in(2) ? 1 : 0);
        if (binding.is_border.back() && is_soft && k < binding.strengths.size()) binding.strengths[k] = 0.1;
    }
    if (bytes.once_in(16)) binding.is_border.push_back(1);
}

}  // namespace

void read_anchors(Bytes& bytes, Index vertex_count, Binding& binding) {
    binding.anchors.clear();
    const bool is_wild = bytes.once_in(16);
    for (Index k = bytes.below(9); k > 0 && vertex_count > 0; --k) {
        const Index first = is_wild ? bytes.below(vertex_count + 4) - 2 : bytes.below(vertex_count);
        const Index length = bytes.once_in(3) ? 1 + bytes.below(12) : 1;
        for (Index v = first; v < first + length && (is_wild || v < vertex_count); ++v) {
            if (is_wild || std::find(binding.anchors.begin(), binding.anchors.end(), v) == binding.anchors.end())
                binding.anchors.push_back(v);
        }
    }
    binding.handles.clear();
    binding.strengths.clear();
    const std::size_t count = binding.anchors.size() + (bytes.once_in(32) ? 1 : 0);
    if (bytes.once_in(3)) {
        for (std::size_t k = 0; k < count; ++k)
            binding.handles.push_back(bytes.below(4) - (bytes.once_in(64) ? 1 : 0));
    }
    if (bytes.once_in(3)) {
        for (std::size_t k = 0; k < count; ++k) {
            binding.strengths.push_back(bytes.once_in(3) ? std::numeric_limits<double>::infinity()
                                                         : std::pow(10.0, bytes.below(18) - 8));
            if (bytes.once_in(64)) binding.strengths.back() = bytes.number();
        }
    }
    binding.is_border.clear();
    if (!binding.strengths.empty() && bytes.once_in(4)) read_border(bytes, binding);
    binding.rigidity.reset();
    if (bytes.once_in(3)) binding.rigidity = bytes.once_in(2) ? 0.0 : std::pow(10.0, bytes.below(14) - 4);
    if (bytes.once_in(32)) binding.rigidity = bytes.number();
    binding.stiffness.clear();
    if (!bytes.once_in(4)) return;
    for (Index v = bytes.once_in(32) ? 1 : 0; v < vertex_count; ++v)
        binding.stiffness.push_back(bytes.once_in(64) ? bytes.number() : std::pow(10.0, bytes.below(12) - 6));
}

Binding read_binding(Bytes& bytes, const Mesh& mesh) {
    Binding binding{mesh.vertices, mesh.faces, {}, {}};
    constexpr Method kMethods[] = {Method::kFast, Method::kPaper, Method::kFull, Method::kFast};
    binding.method = kMethods[bytes.below(4)];
    binding.threads = bytes.once_in(8) ? 2 : 1;
    if (bytes.once_in(4)) binding.instructions = InstructionSet::kPortable;
    read_anchors(bytes, mesh.vertex_count(), binding);
    if (binding.method != Method::kFast && !bytes.once_in(8)) {  // the others know neither
        binding.rigidity.reset();
        binding.strengths.clear();
        binding.stiffness.clear();
    }
    if (bytes.once_in(3)) {
        binding.roi.emplace(mesh.vertex_count() + (bytes.once_in(32) ? 1 : 0));
        for (char& flag : *binding.roi)
            flag = bytes.once_in(4) ? 0 : 1;
    }
    const std::uint8_t kind = bytes.byte();
    if (kind % 2 == 1) binding.loose = LooseRule::kFollow;
    for (Index more = kind % 8 == 0 || kind % 16 == 15 ? 1 + bytes.below(3) : 0; more > 0; --more)
        binding.examples.push_back(share(read_other_shape(bytes, mesh), "example"));
    return binding;
}

std::vector<double> read_weights(Bytes& bytes, std::size_t anchor_count) {
    std::vector<double> weights;
    if (!bytes.once_in(4)) return weights;
    for (std::size_t k = 0; k < anchor_count; ++k)
        weights.push_back(bytes.once_in(32) ? bytes.number() : bytes.once_in(2) ? 0.0 : bytes.byte() / 255.0);
    return weights;
}

int read_max_iterations(Bytes& bytes) {
    const Index kind = bytes.below(8);
    return kind == 0 ? bytes.below(30) - 1 : kind == 1 ? 100 : 8;
}

std::optional<double> read_tolerance(Bytes& bytes) {
    if (!bytes.once_in(4)) return {};
    return bytes.once_in(16) ? bytes.number() : std::pow(10.0, -bytes.below(14));
}

}  // namespace meanvalue::fuzz
