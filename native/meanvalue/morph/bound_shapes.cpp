#include "meanvalue/morph/bound_shapes.h"

#include <algorithm>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/mesh/disjoint_sets.h"
#include "meanvalue/mesh/extent.h"
#include "meanvalue/mesh/fixed_vertices.h"
#include "meanvalue/mesh/region.h"
#include "meanvalue/mesh/triangle_mesh.h"
#include "meanvalue/optimise/ring_room.h"

namespace meanvalue {
namespace {

constexpr double kMostRigidity = 1e9;
// On the diagonal of the constant matrix, as a share of itself: as in FastDecoder.
constexpr double kLeastDiagonal = 1e-9;
// Vertices stay that move less than this share of the diagonal; what others count beside them when the whole is
// placed.
constexpr double kStays = 0.02;
constexpr double kMoves = 1e-3;

double rigidity_of(const MorphBinding& binding) {
    const double rigidity = binding.rigidity.value_or(kDefaultRigidity);
    if (!(rigidity >= 0.0) || rigidity > kMostRigidity) {
        throw InvalidInput(message("rigidity is ", rigidity, "; give a number from 0 to ", kMostRigidity));
    }
    return rigidity;
}

double hold_of(const MorphBinding& binding) {
    const double hold = binding.hold.value_or(kDefaultHold);
    if (!(hold >= 0.0) || hold > kMostRigidity) {
        throw InvalidInput(message("hold is ", hold, "; give a number from 0 to ", kMostRigidity));
    }
    return hold;
}

/// Six times the volume inside. @return 0 where the mesh is open.
double signed_volume(const PositionsView& positions, const TrianglesView& faces, bool is_closed) {
    if (!is_closed) return 0.0;
    const Vector3 origin = positions.row(0);
    double sum = 0.0;
    for (Index f = 0; f < faces.rows(); ++f) {
        const auto corner = [&](int c) -> Vector3 { return Vector3(positions.row(faces(f, c))) - origin; };
        sum += corner(0).dot(corner(1).cross(corner(2)));
    }
    return sum;
}

void check_shapes(const MorphBinding& binding) {
    if (binding.shapes.size() < 2) {
        throw InvalidInput(message("shapes has ", binding.shapes.size(), " shapes; give two or more"));
    }
    for (std::size_t k = 0; k < binding.shapes.size(); ++k) {
        const std::string name = message("shapes[", k, "]");
        if (binding.shapes[k].rows() != binding.shapes[0].rows()) {
            throw InvalidInput(message(name, " has ", binding.shapes[k].rows(), " vertices, but shapes[0] has ",
                                       binding.shapes[0].rows(), "; all must be of one mesh"));
        }
        require_finite(binding.shapes[k], name.c_str());
        require_moderate_extent(binding.shapes[k]);
    }
}

/// A shape that is turned inside out has its cells the other way round: nothing is between.
void refuse_mirrored(const MorphBinding& binding, const OneRings& rings) {
    const bool is_closed = std::all_of(rings.closed.begin(), rings.closed.end(), [](char c) { return c != 0; });
    const double first = signed_volume(binding.shapes[0], binding.faces, is_closed);
    for (std::size_t k = 1; k < binding.shapes.size(); ++k) {
        const double other = signed_volume(binding.shapes[k], binding.faces, is_closed);
        if (first * other >= 0.0) continue;
        throw InvalidInput(message("shapes[", k, "] is mirrored, or inside out: its volume is ", other / 6.0,
                                   ", that of shapes[0] is ", first / 6.0,
                                   "; mirror it back along one axis, or flip its faces"));
    }
}

}  // namespace

Morpher::Bound::Bound(const MorphBinding& binding, Execution& execution)
    : anchors(binding.anchors),
      rigidity(rigidity_of(binding)),
      hold(hold_of(binding)),
      threads(thread_count(binding.threads)),
      instructions(binding.instructions) {
    check_shapes(binding);
    for (const PositionsView& shape : binding.shapes) {
        execution.check();
        shapes.push_back(shape);
        diagonals.push_back(mean_diagonal(shape, threads, execution));
    }
    for (std::size_t k = 0; k < diagonals.size(); ++k) {
        if (!(diagonals[k] > 0.0))
            throw InvalidInput(message("all vertices of shapes[", k, "] are in one place; give a shape"));
    }
    is_fixed = fixed_flags(static_cast<Index>(shapes[0].rows()), anchors, {});
    encode_shapes(binding, execution);
    find_parts(execution);
    following = FollowingParts(shapes, binding.faces, is_fixed, threads, execution);
    find_what_stays(execution);
    factorise(execution);
}

void Morpher::Bound::encode_shapes(const MorphBinding& binding, Execution& execution) {
    execution.begin_stage("encode");
    const auto vertices = static_cast<Index>(shapes[0].rows());
    Region whole;
    whole.vertices.resize(vertices);
    for (Index v = 0; v < vertices; ++v)
        whole.vertices[v] = v;
    whole.positions = shapes[0];
    whole.faces = binding.faces;
    whole.is_fixed = is_fixed;
    std::vector<Encoding> encoded;
    {
        const StageTimer timer(timings, "encode");
        const TriangleMesh mesh(vertices, binding.faces, execution);
        require_room_for_rings(whole, is_fixed, kNumberPairs, execution);
        const OneRings rings = collect_one_rings(mesh, execution);
        refuse_mirrored(binding, rings);
        encoded = encode_alike(rings, binding.shapes, threads, execution);
        std::vector<const Encoding*> of_shapes;
        of_shapes.reserve(encoded.size());
        for (const Encoding& encoding : encoded)
            of_shapes.push_back(&encoding);
        encodings = std::make_unique<EncodingBlend>(of_shapes, execution);
    }
    const StageTimer timer(timings, "cells");
    execution.begin_stage("cells");
    cells = std::make_unique<TurnedCells>(encodings->layout(), binding.shapes, threads, execution);
}

void Morpher::Bound::find_parts(const Execution& execution) {
    const Encoding& layout = encodings->layout();
    const Index vertices = layout.vertex_count();
    DisjointSets sets(vertices);
    for (Index v = 0; v < vertices; ++v) {
        execution.check_every(v);
        for (Index place = layout.ring_offsets[v]; place < layout.ring_offsets[v + 1]; ++place)
            sets.join(v, layout.ring[place]);
    }
    std::vector<Index> part_of(vertices, -1);
    for (Index v = 0; v < vertices; ++v) {
        execution.check_every(v);
        const Index root = sets.root(v);
        if (root == v) {
            part_of[v] = static_cast<Index>(parts.members.size());
            parts.members.emplace_back();
            parts.is_anchored.push_back(0);
        }
        parts.members[part_of[root]].push_back(v);
        if (is_fixed[v]) parts.is_anchored[part_of[root]] = 1;
        part_of[v] = part_of[root];
    }
}

/// The body is not to rock because an arm swings. Where nothing stays, all vertices count alike.
void Morpher::Bound::find_what_stays(const Execution& execution) {
    const auto vertices = static_cast<std::size_t>(shapes[0].rows());
    const double even = 1.0 / static_cast<double>(shapes.size());
    const double size = TurnedCells::geometric_mean(diagonals, std::vector<double>(shapes.size(), even).data());
    stays.assign(vertices, 0.0);
    for (std::size_t v = 0; v < vertices; ++v) {
        execution.check_every(v);
        Vector3 mean = Vector3::Zero();
        for (const Positions& shape : shapes)
            mean += even * shape.row(v).transpose();
        double moves = 0.0;  // squared, in units of what is little
        for (const Positions& shape : shapes)
            moves += even * (Vector3(shape.row(v)) - mean).squaredNorm() / (kStays * kStays * size * size);
        stays[v] = kMoves + std::max(0.0, 1.0 - moves) * std::max(0.0, 1.0 - moves);
    }
}

void Morpher::Bound::factorise(Execution& execution) {
    const StageTimer timer(timings, "factor");
    execution.begin_stage("factor");
    const auto vertices = static_cast<Index>(shapes[0].rows());
    const auto count = static_cast<Index>(shapes.size());
    const ShapeWeights even(std::vector<double>(count, 1.0 / count), count, vertices);
    Encoding encoding = encodings->layout();
    encodings->fill(even, threads, execution, encoding);
    RestCells mean;
    std::vector<Quaternion> rotations;
    cells->fill(even, cells->common_sizes(even.mean()), {}, Quaternion::Identity(), threads, execution, rotations,
                mean);
    const double size = TurnedCells::geometric_mean(diagonals, even.mean().data());
    assembly =
        std::make_unique<CellAssembly>(encodings->layout(), mean, parts.members, instructions, threads, execution);
    unknowns = find_unknowns(encodings->layout(), is_fixed);
    if (unknowns.free.empty()) return;
    if (hold > 0.0) {
        const double share = hold / vertices;
        for (std::size_t k = 0; k < unknowns.free.size(); ++k)
            springs.push_back({unknowns.free[k], static_cast<Index>(k), share * share});
    }
    factorise(energy_of(encoding, mean, size, execution), execution);
}

DeformationEnergy Morpher::Bound::energy_of(const Encoding& encoding, const RestCells& of_cells, double size,
                                            const Execution& execution) const {
    return {encoding,
            unknowns,
            of_cells,
            size,
            DeformationEnergy::weights_for(rigidity),
            execution,
            instructions == InstructionSet::kFastest ? DeformationEnergy::Kernel::kFastest
                                                     : DeformationEnergy::Kernel::kPortable,
            SoftConstraints(springs, unknowns)};
}

/// Without springs a vertex of each part that has no fixed one is held, which only decides where the part is.
void Morpher::Bound::factorise(const DeformationEnergy& energy, Execution& execution) {
    SparseMatrix hessian = energy.constant_hessian(rigidity, threads, execution);
    std::vector<char> is_pinned(unknowns.free.size(), 0);
    for (const std::vector<Index>& part : parts.members) {
        const bool is_held =
            !springs.empty() || std::any_of(part.begin(), part.end(), [&](Index v) { return unknowns.slot[v] < 0; });
        if (!is_held) is_pinned[unknowns.slot[part.front()]] = 1;
    }
    for (Eigen::Index k = 0; k < hessian.cols(); ++k) {
        double& diagonal = hessian.valuePtr()[hessian.outerIndexPtr()[k]];
        diagonal = diagonal > 0.0 ? diagonal * ((is_pinned[k] ? 2.0 : 1.0) + kLeastDiagonal) : 1.0;
    }
    factor = SupernodalFactor(instructions);
    factor.analyse(hessian, execution, threads);
    if (!factor.factorise(hessian, execution, threads))
        throw SolverFailure(message("the system of ", hessian.cols(), " free vertices is singular"));
}

std::size_t Morpher::Bound::bytes() const {
    return shapes.size() * static_cast<std::size_t>(shapes[0].size()) * sizeof(double) + encodings->bytes() +
           cells->bytes() + following.bytes() + assembly->bytes() + factor.bytes();
}

Morpher::Workspace::Workspace(const Bound& bound, const Execution& execution)
    : encoding(bound.encodings->layout()), minimiser(bound.unknowns, bound.diagonals[0], bound.instructions) {
    const auto count = static_cast<Index>(bound.shapes.size());
    const ShapeWeights even(std::vector<double>(count, 1.0), count, encoding.vertex_count());
    bound.cells->fill(even, bound.cells->common_sizes(even.mean()), {}, Quaternion::Identity(), bound.threads,
                      execution, rotations, cells);
    energy = std::make_unique<DeformationEnergy>(bound.energy_of(encoding, cells, bound.diagonals[0], execution));
    energy_room = energy->make_workspace();
    gradient.resize(static_cast<Eigen::Index>(bound.unknowns.free.size()), 3);
}

std::size_t Morpher::Workspace::bytes() const {
    return encoding.bytes() + cells.edges.capacity() * sizeof(Vector3) + energy->bytes() + energy_room.bytes() +
           minimiser.bytes() + static_cast<std::size_t>(last.correction.size() + gradient.size()) * sizeof(double);
}

}  // namespace meanvalue
