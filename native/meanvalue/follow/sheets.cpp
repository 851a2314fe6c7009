#include "meanvalue/follow/sheets.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "meanvalue/common/parallel.h"
#include "meanvalue/decode/fast/deformation_energy.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue {
namespace {

// As that of poses.
constexpr double kRigidity = 15.0;
// A patch reaches as far as the vertex is away from it, but for what is beyond so many edges; and by so many edges
// more.
constexpr double kMostEdgesAway = 6.0;
constexpr double kEdgesAround = 2.5;
// How far a spring's pull decays along the sheet: this share of the carrier's size, and so many times the distance;
// at least so many edges.
constexpr double kDecay = 0.015;
constexpr double kDecayByDistance = 2.0;
constexpr double kDecayByEdge = 1.2;
// Keeps the matrix positive definite where no spring counts.
constexpr double kLeastSpring = 1e-9;
// What couples two vertices by less is rounding.
constexpr double kLeastCoupling = 1e-12;
// Edges that are shorter than this share of the carrier's size count as that.
constexpr double kLeastEdge = 1e-4;
// Of a vertex that keeps its shape: its neighbors all act on each other, as many as they are.
constexpr Index kMostNeighbours = 256;

double squared(double number) {
    return number * number;
}

}  // namespace

Sheets::Sheets(const PositionsView& rest, const CarrierSurface& carrier, double size, const TrianglesView& faces,
               const std::vector<Index>& sheet_of, InstructionSet instructions, int threads,
               const Execution& execution)
    : carrier_fans_(carrier.fans()), factor_(instructions) {
    std::vector<Index> number(sheet_of.size(), -1);
    for (std::size_t v = 0; v < sheet_of.size(); ++v) {
        if (sheet_of[v] < 0) continue;
        number[v] = static_cast<Index>(vertices_.size());
        vertices_.push_back(static_cast<Index>(v));
        holds_.emplace_back().sheet = sheet_of[v];
    }
    own_ = rest(vertices_, Eigen::all);
    std::vector<Index> used;
    for (Index f = 0; f < faces.rows(); ++f) {
        if (number[faces(f, 0)] >= 0) used.push_back(f);
    }
    Triangles own_faces = faces(used, Eigen::all);
    for (Index& corner : own_faces.reshaped())
        corner = number[corner];
    hold(rest, carrier, threads, execution);
    Execution encoding_stage(&execution);
    encoding_ = encode(collect_one_rings(static_cast<Index>(own_.rows()), own_faces, execution), own_, threads,
                       encoding_stage);
    bind(size, instructions, threads, execution);
    lift_ = Lift(rest, carrier, size, own_, own_faces, holds_, threads, execution);
    std::vector<char> is_read(rest.rows(), 0);
    const auto read = [&](Index v) {
        if (std::exchange(is_read[v], 1) == 0) read_.push_back(v);
    };
    for (const SurfacePatch& patch : patches_) {
        for (const SurfacePatch::Point& point : patch.points)
            read(point.vertex);
    }
    for (const Lift::Height& height : lift_.heights())
        std::for_each(height.below.corners.begin(), height.below.corners.end(), read);
    for (const SheetHold& hold : holds_) {
        edges_below_.resize(std::max<std::size_t>(edges_below_.size(), hold.sheet + 1));
        for (int c = 0; c < 3; ++c)
            edges_below_[hold.sheet].add(hold.place.corners[c], hold.place.corners[(c + 1) % 3], rest.data());
    }
}

/// Place and patch of each vertex.
void Sheets::hold(const PositionsView& rest, const CarrierSurface& carrier, int threads, const Execution& execution) {
    patches_.resize(vertices_.size());
    parallel_for(static_cast<Index>(vertices_.size()), threads, execution, [&](Index begin, Index end) {
        std::vector<Index> reached(rest.rows(), -1);
        for (Index v = begin; v < end; ++v) {
            execution.check();
            const Vector3 point = own_.row(v);
            SheetHold& hold = holds_[v];
            hold.place = carrier.nearest(point);
            hold.offset = point - hold.place.of(rest.data());
            double edge = 0.0;
            for (int c = 0; c < 3; ++c)
                edge += hold.place.weights[c] * carrier.mean_edge(hold.place.corners[c]);
            const double away = std::min(hold.offset.norm(), kMostEdgesAway * edge);
            patches_[v] = carrier.patch_at(hold.place, away + kEdgesAround * edge, v, reached);
        }
    });
}

/// Springs that count beside the row of each vertex, so that what is elsewhere changes nothing of a sheet.
void Sheets::bind(double size, InstructionSet instructions, int threads, const Execution& execution) {
    const RestCells cells = rest_cells(encoding_, own_, threads, execution);
    Unknowns unknowns;
    unknowns.free.resize(vertices_.size());
    std::iota(unknowns.free.begin(), unknowns.free.end(), 0);
    unknowns.number = unknowns.free;
    for (const Index v : unknowns.free) {
        if (encoding_.predictable(v) && encoding_.ring_of(v).valence <= kMostNeighbours) unknowns.rows.push_back(v);
    }
    const double unit = energy_unit(encoding_, unknowns, cells);
    std::vector<SoftAnchor> springs;
    bending_.assign(vertices_.size(), 0.0);
    for (const Index v : unknowns.free) {
        const double length = std::max(cells.mean_edge(encoding_, v), kLeastEdge * size);
        const double reach =
            std::max(kDecay * size + kDecayByDistance * holds_[v].offset.norm(), kDecayByEdge * length);
        const double pull = std::max(1.0 / squared(reach), kRigidity / squared(size)) / squared(reach);
        const double strength = std::min(1.0, squared(squared(length)) * pull) + kLeastSpring;
        springs.push_back({v, v, 0.5 * unit / squared(length) * strength});
    }
    for (const Index v : unknowns.rows)
        bending_[v] = unit / squared(std::max(cells.mean_edge(encoding_, v), kLeastEdge * size));
    const DeformationEnergy energy(encoding_, unknowns, cells, size, 1.0, execution, instructions,
                                   SoftConstraints(std::move(springs), unknowns), threads);
    const SparseMatrix lower = energy.initial_hessian(kRigidity, threads, execution).matrix;
    factor_.analyse(lower, execution, threads);
    is_factored_ = factor_.factorise(lower, execution, threads);
    const SparseMatrix edges =
        (lower - energy.initial_hessian(0.0, threads, execution).matrix).pruned(1.0, kLeastCoupling);
    edges_ = edges.selfadjointView<Eigen::Lower>();
    columns_ = grouped<Link>(vertices_.size(), [&](const auto& visit) {
        for (const Index v : unknowns.rows) {
            const EncodedRing ring = encoding_.ring_of(v);
            for (Index k = 0; k < ring.valence; ++k)
                visit(ring.ring[k], Link{v, ring.weights[k]});
        }
    });
}

/// How the sheet pulls each vertex from its target: not where it keeps its shape there. @param rotations and sizes.
Positions Sheets::pulls(const Positions& targets, const std::vector<Matrix3>& rotations, int threads,
                        const Execution& execution) const {
    const auto count = static_cast<Index>(targets.rows());
    Positions details(count, 3), result(count, 3);
    parallel_for(count, threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const EncodedRing ring = encoding_.ring_of(v);
            Vector3 rest = Vector3::Zero(), now = Vector3::Zero();
            for (Index k = 0; k < ring.valence; ++k) {
                rest += ring.weights[k] * (own_.row(v) - own_.row(ring.ring[k])).transpose();
                now += ring.weights[k] * (targets.row(v) - targets.row(ring.ring[k])).transpose();
            }
            details.row(v) = bending_[v] * (rotations[v] * rest - now);
        }
    });
    parallel_for(count, threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            Vector3 sum = details.row(v), edges = Vector3::Zero();
            for (const auto& [row, weight] : columns_.of(v))
                sum -= weight * details.row(row).transpose();
            for (SparseMatrix::InnerIterator entry(edges_, v); entry; ++entry) {
                const auto other = static_cast<Index>(entry.row());
                const Vector3 edge = 0.5 * entry.value() * (own_.row(v) - own_.row(other)).transpose();
                edges += edge;
                sum += entry.value() * (targets.row(v) - targets.row(other)).transpose() - rotations[other] * edge;
            }
            result.row(v) = sum - rotations[v] * edges;
        }
    });
    return result;
}

void Sheets::carry(double* positions, int threads, const Execution& execution) const {
    const auto count = static_cast<Index>(vertices_.size());
    std::vector<Vector3> normals(carrier_fans_.size());
    parallel_for(static_cast<Index>(read_.size()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k)
            normals[read_[k]] = area_around(carrier_fans_, positions, read_[k]).normalized();
    });
    std::vector<double> growth(edges_below_.size());
    parallel_items(growth.size(), threads, execution,
                   [&](int, std::size_t sheet) { growth[sheet] = edges_below_[sheet].growth(positions); });
    std::vector<Matrix3> rotations(count);
    Positions own(count, 3);
    parallel_for(count, threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v)
            rotations[v] = patches_[v].covariance(positions, normals);
        closest_rotations(rotations.data() + begin, end - begin);
        for (Index v = begin; v < end; ++v) {
            rotations[v] *= growth[holds_[v].sheet];
            own.row(v) = holds_[v].place.of(positions) + rotations[v] * holds_[v].offset;
        }
    });
    if (is_factored_) {
        Positions moves = pulls(own, rotations, threads, execution);
        SupernodalFactor::Workspace solving;
        factor_.solve(moves, moves, threads, execution, solving);
        own += moves;
    }
    lift_.apply(positions, normals, growth, encoding_, threads, execution, own);
    Eigen::Map<Positions>(positions, carrier_fans_.size(), 3)(vertices_, Eigen::all) = own;
}

}  // namespace meanvalue
