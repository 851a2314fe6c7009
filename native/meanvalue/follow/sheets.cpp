#include "meanvalue/follow/sheets.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "meanvalue/common/parallel.h"
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
    unknowns_.free.resize(vertices_.size());
    std::iota(unknowns_.free.begin(), unknowns_.free.end(), 0);
    unknowns_.number = unknowns_.free;
    for (const Index v : unknowns_.free) {
        if (encoding_.predictable(v) && encoding_.ring_of(v).valence <= kMostNeighbours) unknowns_.rows.push_back(v);
    }
    const double unit = energy_unit(encoding_, unknowns_, cells);
    std::vector<SoftAnchor> springs;
    for (const Index v : unknowns_.free) {
        const double length = std::max(cells.mean_edge(encoding_, v), kLeastEdge * size);
        const double reach =
            std::max(kDecay * size + kDecayByDistance * holds_[v].offset.norm(), kDecayByEdge * length);
        const double pull = std::max(1.0 / squared(reach), kRigidity / squared(size)) / squared(reach);
        const double strength = std::min(1.0, squared(squared(length)) * pull) + kLeastSpring;
        springs.push_back({v, v, 0.5 * unit / squared(length) * strength});
    }
    energy_ = std::make_unique<DeformationEnergy>(encoding_, unknowns_, cells, size, 1.0, execution, instructions,
                                                  SoftConstraints(std::move(springs), unknowns_), threads);
    const SparseMatrix lower = energy_->initial_hessian(kRigidity, threads, execution).matrix;
    factor_.analyse(lower, execution, threads);
    if (!factor_.factorise(lower, execution, threads)) energy_.reset();  // numbers leave the range of a factor
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
    Positions own(count, 3);  // in the size that each sheet has at rest
    parallel_for(count, threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v)
            rotations[v] = patches_[v].covariance(positions, normals);
        closest_rotations(rotations.data() + begin, end - begin);
        for (Index v = begin; v < end; ++v)
            own.row(v) = holds_[v].place.of(positions) / growth[holds_[v].sheet] + rotations[v] * holds_[v].offset;
    });
    if (energy_) {
        DeformationEnergy::Workspace workspace = energy_->make_workspace();
        workspace.soft_targets = own;
        workspace.holds_normals = true;  // targets are torn between thighs that turn apart
        SupernodalFactor::Workspace solving;
        Positions moves(count, 3);
        energy_->evaluate(own, kRigidity, moves, threads, execution, workspace);
        factor_.solve(moves, moves, threads, execution, solving);
        own -= moves;
    }
    for (Index v = 0; v < count; ++v)
        own.row(v) *= growth[holds_[v].sheet];
    lift_.apply(positions, normals, growth, encoding_, threads, execution, own);
    Eigen::Map<Positions>(positions, carrier_fans_.size(), 3)(vertices_, Eigen::all) = own;
}

}  // namespace meanvalue
