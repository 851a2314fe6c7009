#include "meanvalue/follow/sheets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/linalg/closest_rotation.h"
#include "meanvalue/linalg/sparse_matrix.h"
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
// Edges that are shorter than this share of the carrier's size count as that, or those of no length would count
// alone.
constexpr double kLeastEdge = 1e-4;
// Of a vertex that keeps its shape: its neighbors all act on each other, as many as they are.
constexpr Index kMostNeighbours = 256;
constexpr double kTiny = 1e-60;  // where the carrier has no size
// So many edges stand for all below a sheet.
constexpr std::size_t kMostCarrierEdges = 2048;

double squared(double number) {
    return number * number;
}

}  // namespace

Sheets::Sheets(const PositionsView& rest, CarrierSurface carrier, const TriangleTree& carrier_tree,
               const TrianglesView& faces, const std::vector<Index>& sheet_of, InstructionSet instructions,
               int threads, const Execution& execution)
    : carrier_(std::move(carrier)), factor_(instructions) {
    std::vector<Index> number(sheet_of.size(), -1);
    for (std::size_t v = 0; v < sheet_of.size(); ++v) {
        if (sheet_of[v] < 0) continue;
        number[v] = static_cast<Index>(vertices_.size());
        vertices_.push_back(static_cast<Index>(v));
        holds_.emplace_back();
        holds_.back().sheet = sheet_of[v];
        sheet_count_ = std::max(sheet_count_, sheet_of[v] + 1);
    }
    own_ = rest(vertices_, Eigen::all);
    std::vector<Index> used;
    for (Index f = 0; f < faces.rows(); ++f) {
        if (number[faces(f, 0)] >= 0) used.push_back(f);
    }
    Triangles own_faces = faces(used, Eigen::all);
    for (Index& corner : own_faces.reshaped())
        corner = number[corner];
    hold(rest, carrier_tree, threads, execution);
    Execution encoding_stage(&execution);
    const Encoding encoding = encode(collect_one_rings(static_cast<Index>(own_.rows()), own_faces, execution), own_,
                                     threads, encoding_stage);
    const RestCells cells = rest_cells(encoding, own_, threads, execution);
    weigh(encoding, cells);
    link(encoding, cells, execution);
    factorise(threads, execution);
    lift_ = Lift(rest, carrier_, carrier_tree, own_, own_faces, holds_, threads, execution);
    list_carrier(rest.data());
}

/// Place and patch of each vertex.
void Sheets::hold(const PositionsView& rest, const TriangleTree& carrier_tree, int threads,
                  const Execution& execution) {
    patches_.resize(vertices_.size());
    parallel_for(static_cast<Index>(vertices_.size()), threads, execution, [&](Index begin, Index end) {
        CarrierSurface::Scratch scratch;
        for (Index v = begin; v < end; ++v) {
            execution.check();
            const Vector3 point = own_.row(v);
            const TriangleTree::Place place = carrier_tree.nearest({point}, std::numeric_limits<double>::infinity());
            const auto corners = carrier_tree.triangles().row(place.triangle);
            holds_[v].place = {{corners[0], corners[1], corners[2]}, place.weights};
            holds_[v].offset = point - holds_[v].place.of(rest.data());
            double edge = 0.0;
            for (int c = 0; c < 3; ++c)
                edge += place.weights[c] * carrier_.mean_edge(corners[c]);
            const double away = std::min(holds_[v].offset.norm(), kMostEdgesAway * edge);
            patches_[v] = carrier_.patch_at(rest.data(), holds_[v].place, away + kEdgesAround * edge, scratch);
        }
    });
}

/// What the rows, the lengths and the springs of each vertex count: as in DeformationEnergy, each sheet in its own
/// unit, so that what stands beside it changes nothing of it.
void Sheets::weigh(const Encoding& encoding, const RestCells& cells) {
    const double size = carrier_.size();
    std::vector<double> lengths, inverse_squares(sheet_count_, 0.0), counts(sheet_count_, 0.0);
    for (std::size_t v = 0; v < holds_.size(); ++v) {
        lengths.push_back(std::max({cells.mean_edge(encoding, static_cast<Index>(v)), kLeastEdge * size, kTiny}));
        inverse_squares[holds_[v].sheet] += 1.0 / squared(lengths[v]);
        counts[holds_[v].sheet] += 1.0;
    }
    for (std::size_t v = 0; v < holds_.size(); ++v) {
        const auto vertex = static_cast<Index>(v);
        const double unit = counts[holds_[v].sheet] / inverse_squares[holds_[v].sheet];
        const Index first = encoding.ring_offsets[v];
        const Index valence = encoding.ring_offsets[v + 1] - first;
        const bool bends = encoding.predictable(vertex) && valence <= kMostNeighbours;
        bending_.push_back(bends ? unit / squared(lengths[v]) : 0.0);
        const double rigidity = rigidity_of_cell(cells.edges.data() + first, valence, size);
        stretching_.push_back(kRigidity * rigidity * unit / squared(size));
        const double reach =
            std::max(kDecay * size + kDecayByDistance * holds_[v].offset.norm(), kDecayByEdge * lengths[v]);
        const double pull = std::max(1.0 / squared(reach), kRigidity / squared(size)) / squared(reach);
        springs_.push_back(std::min(1.0, unit * squared(lengths[v]) * pull) + kLeastSpring);
    }
}

/// The rows of W, and edges with what their lengths count.
void Sheets::link(const Encoding& encoding, const RestCells& cells, const Execution& execution) {
    const auto count = static_cast<Index>(vertices_.size());
    rows_ = grouped<SheetEdge>(count, [&](const auto& visit) {
        for (Index v = 0; v < count; ++v) {
            for (Index k = encoding.ring_offsets[v]; k < encoding.ring_offsets[v + 1]; ++k)
                visit(v, SheetEdge{encoding.ring[k], encoding.weights[k]});
        }
    });
    columns_ = grouped<SheetEdge>(count, [&](const auto& visit) {
        for (Index v = 0; v < count; ++v) {
            for (const auto& [to, weight] : rows_.of(v))
                visit(to, SheetEdge{v, weight});
        }
    });
    edges_ = grouped<SheetEdge>(count, [&](const auto& visit) {
        std::vector<Spoke> spokes;
        for (Index v = 0; v < count; ++v) {
            execution.check_every(v);
            const EncodedRing ring = encoding.ring_of(v);
            spokes.resize(ring.valence);
            if (ring.valence > 0)
                measure_spokes(cells.edges.data() + encoding.ring_offsets[v], ring.valence, spokes.data());
            const auto add = [&](Index a, Index b, double weight) {
                visit(a, SheetEdge{b, stretching_[v] * weight});
                visit(b, SheetEdge{a, stretching_[v] * weight});
            };
            for (Index k = 0; k < ring.valence; ++k) {
                add(v, ring.ring[k], spokes[k].spoke);
                add(ring.ring[k], ring.ring[k + 1 == ring.valence ? 0 : k + 1], spokes[k].rim);
            }
        }
    });
}

/// (I - W)^T a (I - W), the Laplacian of the edges, and the springs on the diagonal.
void Sheets::factorise(int threads, const Execution& execution) {
    using Entry = Eigen::Triplet<double, Index>;
    const auto count = static_cast<Index>(vertices_.size());
    std::vector<Entry> of_rows, of_matrix;
    for (Index v = 0; v < count; ++v) {
        execution.check_every(v);
        if (const double root = std::sqrt(bending_[v]); root > 0.0) {
            of_rows.emplace_back(v, v, root);
            for (const auto& [to, weight] : rows_.of(v))
                of_rows.emplace_back(v, to, -root * weight);
        }
        of_matrix.emplace_back(v, v, springs_[v]);
        for (const auto& [to, weight] : edges_.of(v)) {
            of_matrix.emplace_back(v, v, weight);
            of_matrix.emplace_back(v, to, -weight);
        }
    }
    SparseMatrix rows(count, count), matrix(count, count);
    rows.setFromTriplets(of_rows.begin(), of_rows.end());
    matrix.setFromTriplets(of_matrix.begin(), of_matrix.end());
    matrix += SparseMatrix(rows.transpose()) * rows;
    execution.check();
    const SparseMatrix lower = matrix.triangularView<Eigen::Lower>();
    factor_.analyse(lower, execution, threads);
    // Where numbers leave the range of a factor, sheets go to where their springs draw them.
    is_factored_ = factor_.factorise(lower, execution, threads);
}

/// What of the carrier is read in each pose.
void Sheets::list_carrier(const double* rest) {
    carrier_vertices_ = lift_.carrier_vertices();
    carrier_edges_.resize(sheet_count_);
    for (std::size_t v = 0; v < holds_.size(); ++v) {
        const auto& corners = holds_[v].place.corners;
        carrier_vertices_.insert(carrier_vertices_.end(), corners.begin(), corners.end());
        carrier_vertices_.insert(carrier_vertices_.end(), patches_[v].points.begin(),
                                 patches_[v].points.begin() + patches_[v].count);
        for (int c = 0; c < 3; ++c) {
            const Index a = std::min(corners[c], corners[(c + 1) % 3]),
                        b = std::max(corners[c], corners[(c + 1) % 3]);
            carrier_edges_[holds_[v].sheet].push_back({a, b, (point_at(rest, a) - point_at(rest, b)).norm()});
        }
    }
    std::sort(carrier_vertices_.begin(), carrier_vertices_.end());
    carrier_vertices_.erase(std::unique(carrier_vertices_.begin(), carrier_vertices_.end()), carrier_vertices_.end());
}

/// How much the carrier grows below each sheet: the median over edges, which a few stretched ones do not move.
std::vector<double> Sheets::growths(const double* positions, int threads, const Execution& execution) const {
    std::vector<double> result(sheet_count_, 1.0);
    parallel_items(carrier_edges_.size(), threads, execution, [&](int, std::size_t sheet) {
        std::vector<double> ratios;
        const std::size_t step = 1 + carrier_edges_[sheet].size() / kMostCarrierEdges;
        for (std::size_t k = 0; k < carrier_edges_[sheet].size(); k += step) {
            const auto& [a, b, length] = carrier_edges_[sheet][k];
            if (length > 0.0) ratios.push_back((point_at(positions, a) - point_at(positions, b)).norm() / length);
        }
        if (ratios.empty()) return;
        const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
        std::nth_element(ratios.begin(), middle, ratios.end());
        result[sheet] = *middle;
    });
    return result;
}

/// What the right side is at the targets: nothing where the sheet keeps its shape there.
Positions Sheets::pulls(const Positions& targets, const std::vector<Matrix3>& rotations, int threads,
                        const Execution& execution) const {
    const auto count = static_cast<Index>(vertices_.size());
    Positions details(count, 3), result(count, 3);
    parallel_for(count, threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            Vector3 rest = Vector3::Zero();
            Vector3 now = Vector3::Zero();
            for (const auto& [to, weight] : rows_.of(v)) {
                rest += weight * (own_.row(v) - own_.row(to)).transpose();
                now += weight * (targets.row(v) - targets.row(to)).transpose();
            }
            details.row(v) = bending_[v] * (rotations[v] * rest - now).transpose();
        }
    });
    parallel_for(count, threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            Vector3 sum = details.row(v);
            for (const auto& [row, weight] : columns_.of(v))
                sum -= weight * details.row(row).transpose();
            for (const auto& [to, weight] : edges_.of(v)) {
                const Vector3 rest = own_.row(v) - own_.row(to);
                sum += weight *
                       (0.5 * (rotations[v] + rotations[to]) * rest - (targets.row(v) - targets.row(to)).transpose());
            }
            result.row(v) = sum;
        }
    });
    return result;
}

void Sheets::carry(double* positions, int threads, const Execution& execution) const {
    const auto count = static_cast<Index>(vertices_.size());
    std::vector<Vector3> normals(carrier_.rest_normals().size());
    carrier_.find_normals(positions, carrier_vertices_, threads, execution, normals);
    const std::vector<double> growth = growths(positions, threads, execution);
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
        SupernodalFactor::Workspace workspace;
        factor_.solve(moves, moves, threads, execution, workspace);
        own += moves;
    }
    lift_.apply(positions, normals, growth, edges_, threads, execution, own);
    for (Index v = 0; v < count; ++v)
        Eigen::Map<Vector3>(positions + 3 * static_cast<std::ptrdiff_t>(vertices_[v])) = own.row(v);
}

}  // namespace meanvalue
