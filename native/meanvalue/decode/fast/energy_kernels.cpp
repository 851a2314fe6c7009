#include "meanvalue/decode/fast/energy_kernels.h"

#include "meanvalue/linalg/simd_closest_rotation.h"
#include "meanvalue/linalg/simd_lanes.h"

namespace meanvalue {
namespace {

static_assert(kRowLanes == kLaneCount, "a row of the energy is a lane");

MEANVALUE_INLINE Lane lanes(const RowLanes& of) {
    return *reinterpret_cast<const Lane*>(of.value);
}

/// Memory as vectors of lanes.
MEANVALUE_INLINE LaneVector* lane_vectors(RowLanes* memory) {
    return reinterpret_cast<LaneVector*>(memory);
}

/// One point into each lane.
MEANVALUE_INLINE LaneVector load(const PaddedPoint* points, const Index* which) {
    const auto point = [&](int lane) { return *reinterpret_cast<const Lane*>(points[which[lane]].value); };
    const Lane a = point(0), b = point(1), c = point(2), d = point(3);
    const Lane xz_low = __builtin_shufflevector(a, b, 0, 4, 2, 6);
    const Lane y_low = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Lane xz_high = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const Lane y_high = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    return {__builtin_shufflevector(xz_low, xz_high, 0, 1, 4, 5), __builtin_shufflevector(y_low, y_high, 0, 1, 4, 5),
            __builtin_shufflevector(xz_low, xz_high, 2, 3, 6, 7)};
}

/// Adds each lane to its point, one after another: two may be the same.
MEANVALUE_INLINE void add_to(PaddedPoint* points, const Index* which, const LaneVector& of) {
    const Lane zero{};
    const auto point = [&](int lane) { return reinterpret_cast<Lane*>(points[which[lane]].value); };
    const Lane xy_even = __builtin_shufflevector(of.x, of.y, 0, 4, 2, 6);
    const Lane xy_odd = __builtin_shufflevector(of.x, of.y, 1, 5, 3, 7);
    const Lane z_even = __builtin_shufflevector(of.z, zero, 0, 4, 2, 6);
    const Lane z_odd = __builtin_shufflevector(of.z, zero, 1, 5, 3, 7);
    *point(0) += __builtin_shufflevector(xy_even, z_even, 0, 1, 4, 5);
    *point(1) += __builtin_shufflevector(xy_odd, z_odd, 0, 1, 4, 5);
    *point(2) += __builtin_shufflevector(xy_even, z_even, 2, 3, 6, 7);
    *point(3) += __builtin_shufflevector(xy_odd, z_odd, 2, 3, 6, 7);
}

/// What pull_back() needs of a row, besides the terms of each ring vertex.
struct PullBack {
    LaneVector by_weight;  // of w_k
    Lane by_height;        // of h_k and the direction in which its length grows
    LaneVector by_area;
    Lane by_spread;
    LaneVector mean;
    LaneVector normal;
};

/// Residuals of the rows in the lanes, by the formulas of RingLinearisation. Positions are relative to the first
/// vertex of each ring: far from the origin no digits are lost.
/// @param steep RingLanes::steep, or nullptr. @param ring v_k - v_0; @param own v_i - v_0;
/// @param directions receives dl_k / dD_k.
MEANVALUE_INLINE LaneVector find_residual(const RowBatch& batch, const BendingLanes* coefficients,
                                          const RowLanes* steep, const LaneVector* ring, const LaneVector& own,
                                          LaneVector* directions, PullBack& back) {
    const Index valence = batch.valence;
    LaneVector area{}, sum{}, centre{};
    Lane squares{};
    for (Index k = 1; k < valence; ++k) {
        area += cross(ring[k - 1], ring[k]);
        sum += ring[k];
        squares += dot(ring[k], ring[k]);
        centre += lanes(coefficients[k].weight) * ring[k];
    }
    const Lane share = all_lanes(1.0 / valence);
    const Lane spread = squares - share * dot(sum, sum);
    const Lane softening = lanes(batch.softening);
    const Lane floor = softening * spread;
    const Lane inverse_length = inverse_or_zero(square_root(dot(area, area) + floor * floor));
    const LaneVector normal = inverse_length * area;

    Lane offset{};
    LaneVector pull{}, tilt{};
    for (Index k = 0; k < valence; ++k) {
        const Lane height = lanes(coefficients[k].height);
        const LaneVector difference = centre - ring[k];
        const Lane along = dot(normal, difference);
        const LaneVector tangential = difference - along * normal;
        const Lane length = square_root(dot(tangential, tangential));
        const LaneVector direction = inverse_or_zero(length) * tangential;
        const Lane lean = dot(direction, normal);
        directions[k] = direction - lean * normal;
        offset += height * length;
        pull += height * directions[k];
        tilt += (height * along) * direction + (height * lean) * difference;
    }
    if (steep != nullptr) {
        LaneVector own_centre{};
        for (Index k = 1; k < valence; ++k)
            own_centre += lanes(steep[k]) * ring[k];
        offset += dot(normal, own_centre);
        tilt = tilt - own_centre;
    }
    const LaneVector residual = own - centre - offset * normal;
    const LaneVector covector = -lanes(batch.bending) * residual;
    const Lane along = dot(normal, covector);
    const LaneVector by_normal = offset * covector - along * tilt;
    const Lane length_change = dot(normal, by_normal);
    const Lane softened = softening * inverse_length;
    back.by_weight = covector + along * pull;
    back.by_height = along;
    back.by_area = inverse_length * (by_normal - length_change * normal);
    back.by_spread = -2.0 * length_change * softened * softened * spread;
    back.mean = share * sum;
    back.normal = normal;
    return residual;
}

MEANVALUE_INLINE LaneVector pull_back(const PullBack& back, const BendingLanes& coefficients,
                                      const LaneVector& direction, const LaneVector& previous, const LaneVector& here,
                                      const LaneVector& next) {
    return lanes(coefficients.weight) * back.by_weight - (back.by_height * lanes(coefficients.height)) * direction +
           cross(back.by_area, previous - next) + back.by_spread * (here - back.mean);
}

/// @param spokes v_i - v_k. @param rest p_i - p_k; receives the spokes less the rest spokes, best rotated.
MEANVALUE_INLINE void find_strains(Index valence, const StretchingLanes* coefficients, const LaneVector* spokes,
                                   LaneVector* rest) {
    LaneMatrix covariance{};
    for (Index k = 0; k < valence; ++k) {
        const Index next = k + 1 == valence ? 0 : k + 1;
        covariance.add_product(spokes[k], lanes(coefficients[k].spoke) * rest[k]);
        covariance.add_product(spokes[k] - spokes[next], lanes(coefficients[k].rim) * (rest[k] - rest[next]));
    }
    const LaneMatrix rotation = closest_rotations(covariance);
    for (Index k = 0; k < valence; ++k)
        rest[k] = spokes[k] - rotation * rest[k];
}

MEANVALUE_INLINE Lane evaluate_batch(const RowBatch& batch, const RingLanes& rings, const PaddedPoint* positions,
                                     double stretching, KernelScratch& scratch, PaddedPoint* gradient) {
    const Index valence = batch.valence;
    const VertexLanes* vertices = rings.vertices + batch.first;
    const BendingLanes* bending = rings.bending + batch.first;
    const RowLanes* steep = batch.first_steep < 0 ? nullptr : rings.steep + batch.first_steep;
    LaneVector* const ring = lane_vectors(scratch.array(0, valence));
    LaneVector* const directions = lane_vectors(scratch.array(1, valence));
    const LaneVector first = load(positions, vertices[0].vertex);
    const LaneVector own = load(positions, batch.centre) - first;
    ring[0] = LaneVector{};
    for (Index k = 1; k < valence; ++k)
        ring[k] = load(positions, vertices[k].vertex) - first;
    PullBack back;
    const LaneVector residual = find_residual(batch, bending, steep, ring, own, directions, back);
    LaneVector by_centre = lanes(batch.bending) * residual;
    Lane energy = lanes(batch.bending) * dot(residual, residual);
    LaneVector previous = ring[valence - 1];
    const StretchingLanes* coefficients = rings.stretching + batch.first;
    LaneVector* const strains = lane_vectors(scratch.array(3, valence));
    const bool is_stretched = stretching > 0.0;
    const Lane factor = all_lanes(stretching);
    LaneVector rim_before{};
    if (is_stretched) {
        LaneVector* const spokes = lane_vectors(scratch.array(2, valence));
        const EdgeLanes* edges = rings.edges + batch.first;
        for (Index k = 0; k < valence; ++k) {
            spokes[k] = own - ring[k];
            strains[k] = {lanes(edges[k].x), lanes(edges[k].y), lanes(edges[k].z)};
        }
        find_strains(valence, coefficients, spokes, strains);
        rim_before = (factor * lanes(coefficients[valence - 1].rim)) * (strains[valence - 1] - strains[0]);
    }
    for (Index k = 0; k < valence; ++k) {
        const Index after = k + 1 == valence ? 0 : k + 1;
        LaneVector pulled = pull_back(back, bending[k], directions[k], previous, ring[k], ring[after]);
        if (is_stretched) {
            const LaneVector rim_strain = strains[k] - strains[after];
            const LaneVector by_spoke = (factor * lanes(coefficients[k].spoke)) * strains[k];
            const LaneVector by_rim = (factor * lanes(coefficients[k].rim)) * rim_strain;
            energy += dot(by_spoke, strains[k]) + dot(by_rim, rim_strain);
            by_centre += by_spoke;
            pulled = pulled - by_spoke - by_rim + rim_before;
            rim_before = by_rim;
        }
        add_to(gradient, vertices[k].vertex, pulled);
        previous = ring[k];
    }
    if (steep != nullptr) {
        for (Index k = 0; k < valence; ++k)
            add_to(gradient, vertices[k].vertex, (back.by_height * lanes(steep[k])) * back.normal);
    }
    add_to(gradient, batch.centre, by_centre);
    return 0.5 * energy;
}

MEANVALUE_INLINE double evaluate(const RowBatch* batches, Index count, const RingLanes& rings,
                                 const PaddedPoint* positions, double stretching, KernelScratch& scratch,
                                 PaddedPoint* gradient) {
    Lane sum{};
    for (Index b = 0; b < count; ++b)
        sum += evaluate_batch(batches[b], rings, positions, stretching, scratch, gradient);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

}  // namespace

EnergyKernel energy_kernel(InstructionSet instructions) {
    return use_avx2_and_fma(instructions) ? WithAvx2<evaluate>::call : evaluate;
}

}  // namespace meanvalue
