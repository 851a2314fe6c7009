#include "meanvalue/decode/fast/row_energy.h"

#include <algorithm>

#include "meanvalue/encoding/predictor.h"
#include "meanvalue/linalg/closest_rotation.h"

namespace meanvalue {
namespace {

// Cotangents are clamped: positive, so that no edge may gain by stretching; finite, where a triangle has no area.
constexpr double kLeastCotangent = 0.05;
constexpr double kMostCotangent = 10.0;
// Each triangle's half cotangent, scaled to make an edge between equilateral triangles 1.
constexpr double kCotangentScale = 0.86602540378443865;

Index next_of(Index k, Index valence) {
    return k + 1 == valence ? 0 : k + 1;
}

/// @param sine, cosine of an angle, both times the product of the lengths of its sides.
double cotangent_weight(double sine, double cosine) {
    const double cotangent = sine * kMostCotangent > cosine ? cosine / sine : kMostCotangent;
    return kCotangentScale * std::max(cotangent, kLeastCotangent);
}

void add_rigidity(const EncodedRing& ring, const Vector3& centre, const PositionsView& positions, const Spoke* spokes,
                  double stretching, RowEnergy& row, Vector3* by_ring) {
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
        const Vector3 by_spoke = (stretching * spokes[k].spoke) * spoke_strain;
        const Vector3 by_rim = (stretching * spokes[k].rim) * rim_strain;
        row.by_centre += by_spoke;
        by_ring[k] -= by_spoke + by_rim;
        by_ring[next] += by_rim;
    });
    row.energy += 0.5 * stretching * squares;
}

}  // namespace

double measure_spokes(const Vector3* edges, Index valence, Spoke* spokes) {
    double length = 0.0;
    for (Index k = 0; k < valence; ++k) {
        spokes[k] = {edges[k], 0.0, 0.0};
        length += edges[k].norm();
    }
    for (Index k = 0; k < valence; ++k) {
        // The triangle of i and the ring's k and next; where an open ring is closed by its chord, that too.
        Spoke& here = spokes[k];
        Spoke& next = spokes[next_of(k, valence)];
        const double area = here.rest.cross(next.rest).norm();  // twice: the same at all three corners
        const Vector3 rim = next.rest - here.rest;
        here.rim = cotangent_weight(area, here.rest.dot(next.rest));
        here.spoke += cotangent_weight(area, next.rest.dot(rim));
        next.spoke += cotangent_weight(area, -here.rest.dot(rim));
    }
    return length / valence;
}

RowEnergy evaluate_row(const EncodedRing& ring, Index centre, const PositionsView& positions, const Spoke* spokes,
                       double bending, double stretching, Vector3* by_ring) {
    const Vector3 position = positions.row(centre);
    const Vector3 residual = residual_with_gradient(ring, positions, position, bending, by_ring);
    RowEnergy row{0.5 * bending * residual.squaredNorm(), bending * residual};
    if (stretching > 0.0) add_rigidity(ring, position, positions, spokes, stretching, row, by_ring);
    return row;
}

}  // namespace meanvalue
