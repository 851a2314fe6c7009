#include "meanvalue/fast/deformation_energy.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/solver/closest_rotation.h"

namespace meanvalue {
namespace {

// Edges shorter than this share of D count as so long: weights stay finite where vertices coincide.
constexpr double kShortestEdge = 1e-9;
// Cotangents are clamped: positive, so that no edge may gain by stretching; finite, where a triangle has no area.
constexpr double kLeastCotangent = 0.05;
constexpr double kMostCotangent = 10.0;
// Each triangle's half cotangent, scaled to make an edge between equilateral triangles 1.
constexpr double kCotangentScale = 0.86602540378443865;

// How many times the row of a lone anchor counts, a fixed vertex whose ring is free: the surface passes through it
// with the curvature that it had, instead of hanging from it like a tent. Measured on the ground-truth poses of
// docs/benchmarks.md, rms as a share of the peer's: 1: 0.896; 30: 0.859; 50 to 100: 0.84 to 0.87; 300: 1.07. Its
// neighbours' rows must not count more: limbs turn about their anchors.
constexpr double kLoneAnchorWeight = 70.0;

Index next_of(Index k, Index valence) { return k + 1 == valence ? 0 : k + 1; }

double cotangent_weight(const Vector3& a, const Vector3& b) {
    const double sine = a.cross(b).norm();
    const double cosine = a.dot(b);
    const double cotangent = sine * kMostCotangent > cosine ? cosine / sine : kMostCotangent;
    return kCotangentScale * std::max(cotangent, kLeastCotangent);
}

}  // namespace

DeformationEnergy::DeformationEnergy(const Encoding& encoding, const Unknowns& unknowns, const PositionsView& rest,
                                     double size, Weights weights, const Execution& execution)
    : encoding_(encoding), unknowns_(unknowns) {
    measure(rest, size, weights, execution);
    index_uses(execution);
    row_energy_.resize(unknowns_.rows.size());
    by_centre_.resize(unknowns_.rows.size());
    by_ring_.resize(spokes_.size());
}

void DeformationEnergy::measure(const PositionsView& rest, double size, Weights weights, const Execution& execution) {
    row_start_.reserve(unknowns_.rows.size() + 1);
    row_start_.push_back(0);
    bending_.reserve(unknowns_.rows.size());
    double inverse_squares = 0.0;
    for (const Index i : unknowns_.rows) {
        execution.check_every(bending_.size());
        const EncodedRing ring = encoding_.ring_of(i);
        const std::size_t first = spokes_.size();
        double length = 0.0;
        for (Index k = 0; k < ring.valence; ++k) {
            spokes_.push_back({(rest.row(i) - rest.row(ring.ring[k])).transpose(), 0.0, 0.0});
            length += spokes_.back().rest.norm();
        }
        for (Index k = 0; k < ring.valence; ++k) {
            // The triangle of i and the ring's k and next; where an open ring is closed by its chord, that too.
            Spoke& here = spokes_[first + k];
            Spoke& next = spokes_[first + next_of(k, ring.valence)];
            here.rim = cotangent_weight(here.rest, next.rest);
            here.spoke += cotangent_weight(next.rest, next.rest - here.rest);
            next.spoke += cotangent_weight(here.rest, here.rest - next.rest);
        }
        row_start_.push_back(static_cast<std::int64_t>(spokes_.size()));
        const double mean = std::max(length / ring.valence, kShortestEdge * size);
        bending_.push_back(1.0 / (mean * mean));
        inverse_squares += bending_.back();
    }
    if (bending_.empty()) return;
    const double square = static_cast<double>(bending_.size()) / inverse_squares;
    for (std::size_t row = 0; row < bending_.size(); ++row) {
        bending_[row] = weights == Weights::kPlain ? 1.0 : bending_[row] * square;
        if (weights == Weights::kByLength && is_lone_anchor(row)) bending_[row] *= kLoneAnchorWeight;
    }
    resolution_ = square;
    stretching_ = square / (size * size);
}

bool DeformationEnergy::is_lone_anchor(std::size_t row) const {
    const Index i = unknowns_.rows[row];
    if (unknowns_.slot[i] >= 0) return false;
    const EncodedRing ring = encoding_.ring_of(i);
    return std::all_of(ring.ring, ring.ring + ring.valence, [&](Index j) { return unknowns_.slot[j] >= 0; });
}

void DeformationEnergy::index_uses(const Execution& execution) {
    use_start_.assign(unknowns_.free.size() + 1, 0);
    own_row_.assign(unknowns_.free.size(), -1);
    const auto for_each_use = [&](const auto& visit) {
        for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
            execution.check_every(row);
            const EncodedRing ring = encoding_.ring_of(unknowns_.rows[row]);
            for (Index k = 0; k < ring.valence; ++k) {
                const Index slot = unknowns_.slot[ring.ring[k]];
                if (slot >= 0) visit(slot, row_start_[row] + k);
            }
        }
    };
    for_each_use([&](Index slot, std::int64_t) { ++use_start_[slot + 1]; });
    for (std::size_t slot = 0; slot < unknowns_.free.size(); ++slot)
        use_start_[slot + 1] += use_start_[slot];
    uses_.resize(use_start_.back());
    std::vector<std::int64_t> next(use_start_.begin(), use_start_.end() - 1);
    for_each_use([&](Index slot, std::int64_t use) { uses_[next[slot]++] = use; });
    for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
        const Index slot = unknowns_.slot[unknowns_.rows[row]];
        if (slot >= 0) own_row_[slot] = static_cast<Index>(row);
    }
}

double DeformationEnergy::evaluate(const PositionsView& positions, double rigidity, Positions& gradient, int threads,
                                   const Execution& execution) {
    parallel_for(static_cast<Index>(unknowns_.rows.size()), threads, execution, [&](Index begin, Index end) {
        for (Index row = begin; row < end; ++row)
            evaluate_row(row, positions, rigidity);
    });
    parallel_for(static_cast<Index>(unknowns_.free.size()), threads, execution, [&](Index begin, Index end) {
        for (Index slot = begin; slot < end; ++slot) {
            Vector3 sum = Vector3::Zero();
            if (own_row_[slot] >= 0) sum = by_centre_[own_row_[slot]];
            for (std::int64_t k = use_start_[slot]; k < use_start_[slot + 1]; ++k)
                sum += by_ring_[uses_[k]];
            gradient.row(slot) = sum;
        }
    });
    double sum = 0.0;
    for (const double share : row_energy_)
        sum += share;
    return sum;
}

void DeformationEnergy::evaluate_row(std::size_t row, const PositionsView& positions, double rigidity) {
    const Index i = unknowns_.rows[row];
    const Vector3 residual = residual_with_gradient(encoding_.ring_of(i), positions, positions.row(i), bending_[row],
                                                    by_ring_.data() + row_start_[row]);
    by_centre_[row] = bending_[row] * residual;
    row_energy_[row] = 0.5 * bending_[row] * residual.squaredNorm();
    if (rigidity > 0.0) add_rigidity(row, positions, rigidity * stretching_);
}

void DeformationEnergy::add_rigidity(std::size_t row, const PositionsView& positions, double weight) {
    const EncodedRing ring = encoding_.ring_of(unknowns_.rows[row]);
    const Spoke* const spokes = spokes_.data() + row_start_[row];
    Vector3* const by_ring = by_ring_.data() + row_start_[row];
    const Vector3 centre = positions.row(unknowns_.rows[row]);
    // Calls visit(k, next of k, v_i - v_k, v_i - v_next) for each triangle.
    const auto for_each_triangle = [&](const auto& visit) {
        Vector3 here = centre - Vector3(positions.row(ring.ring[0]));
        for (Index k = 0; k < ring.valence; ++k) {
            const Index next = next_of(k, ring.valence);
            const Vector3 there = centre - Vector3(positions.row(ring.ring[next]));
            visit(k, next, here, there);
            here = there;
        }
    };
    Matrix3 covariance = Matrix3::Zero();
    for_each_triangle([&](Index k, Index next, const Vector3& here, const Vector3& there) {
        covariance += here * (spokes[k].spoke * spokes[k].rest).transpose() +
                      (here - there) * (spokes[k].rim * (spokes[k].rest - spokes[next].rest)).transpose();
    });
    const Matrix3 rotation = closest_rotation(covariance);
    // The rotation is at its best, so that its own change adds nothing to the gradient.
    double squares = 0.0;
    for_each_triangle([&](Index k, Index next, const Vector3& here, const Vector3& there) {
        const Vector3 turned = rotation * spokes[k].rest;
        const Vector3 spoke_strain = here - turned;
        const Vector3 rim_strain = here - there - turned + rotation * spokes[next].rest;
        squares += spokes[k].spoke * spoke_strain.squaredNorm() + spokes[k].rim * rim_strain.squaredNorm();
        const Vector3 by_spoke = (weight * spokes[k].spoke) * spoke_strain;
        const Vector3 by_rim = (weight * spokes[k].rim) * rim_strain;
        by_centre_[row] += by_spoke;
        by_ring[k] -= by_spoke + by_rim;
        by_ring[next] += by_rim;
    });
    row_energy_[row] += 0.5 * weight * squares;
}

SparseMatrix DeformationEnergy::constant_hessian(double rigidity, const Execution& execution) const {
    const auto size = static_cast<Index>(unknowns_.free.size());
    const double weight = rigidity * stretching_;
    SparseMatrix hessian(size, size);
    std::vector<double> sums(size, 0.0);
    std::vector<Index> seen_by(size, -1);
    std::vector<Index> found;
    std::vector<std::int64_t> rows;
    std::vector<double> values;
    const auto free_slot = [&](Index vertex) { return unknowns_.slot[vertex]; };
    for (Index column = 0; column < size; ++column) {
        execution.check_every(column);
        hessian.outerIndexPtr()[column] = static_cast<std::int64_t>(rows.size());
        found.clear();
        const auto add = [&](Index slot, double value) {
            if (slot < column) return;  // fixed, or above the diagonal
            if (seen_by[slot] != column) {
                seen_by[slot] = column;
                sums[slot] = 0.0;
                found.push_back(slot);
            }
            sums[slot] += value;
        };
        // One row of (I - W), in which this column has the coefficient `own`.
        const auto add_bending = [&](std::size_t row, const EncodedRing& ring, double own) {
            add(free_slot(unknowns_.rows[row]), bending_[row] * own);
            for (Index k = 0; k < ring.valence; ++k)
                add(free_slot(ring.ring[k]), -bending_[row] * own * ring.weights[k]);
        };
        const auto add_edge = [&](Index other, double edge_weight) {
            add(column, edge_weight);
            add(free_slot(other), -edge_weight);
        };
        add(column, 0.0);
        if (own_row_[column] >= 0) {
            const std::size_t row = own_row_[column];
            const EncodedRing ring = encoding_.ring_of(unknowns_.rows[row]);
            add_bending(row, ring, 1.0);
            for (Index k = 0; k < ring.valence; ++k)
                add_edge(ring.ring[k], weight * spokes_[row_start_[row] + k].spoke);
        }
        for (std::int64_t use = use_start_[column]; use < use_start_[column + 1]; ++use) {
            const std::size_t row =
                std::upper_bound(row_start_.begin(), row_start_.end(), uses_[use]) - row_start_.begin() - 1;
            const EncodedRing ring = encoding_.ring_of(unknowns_.rows[row]);
            const auto k = static_cast<Index>(uses_[use] - row_start_[row]);
            const Index previous = k == 0 ? ring.valence - 1 : k - 1;
            const Spoke* const spokes = spokes_.data() + row_start_[row];
            add_bending(row, ring, -ring.weights[k]);
            add_edge(unknowns_.rows[row], weight * spokes[k].spoke);
            add_edge(ring.ring[next_of(k, ring.valence)], weight * spokes[k].rim);
            add_edge(ring.ring[previous], weight * spokes[previous].rim);
        }
        std::sort(found.begin(), found.end());
        for (const Index slot : found) {
            rows.push_back(slot);
            values.push_back(sums[slot]);
        }
    }
    hessian.outerIndexPtr()[size] = static_cast<std::int64_t>(rows.size());
    hessian.resizeNonZeros(static_cast<Eigen::Index>(rows.size()));
    std::copy(rows.begin(), rows.end(), hessian.innerIndexPtr());
    std::copy(values.begin(), values.end(), hessian.valuePtr());
    return hessian;
}

std::size_t DeformationEnergy::bytes() const {
    return spokes_.capacity() * sizeof(Spoke) + (by_ring_.capacity() + by_centre_.capacity()) * sizeof(Vector3) +
           (bending_.capacity() + row_energy_.capacity()) * sizeof(double) +
           (row_start_.capacity() + use_start_.capacity() + uses_.capacity()) * sizeof(std::int64_t) +
           own_row_.capacity() * sizeof(Index);
}

}  // namespace meanvalue
