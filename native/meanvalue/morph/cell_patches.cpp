#include <algorithm>
#include <cmath>
#include <utility>

#include "meanvalue/morph/relative_rotations.h"

namespace meanvalue {
namespace {

// Enough for every finger. Finer ones follow strains, which tilt the axes of relative rotations.
constexpr Index kPatches = 600;
constexpr double kLeastShare = 1e-2;

Index count_with_ring(const OneRings& rings) {
    return static_cast<Index>(std::count_if(rings.kinds.begin(), rings.kinds.end(),
                                            [](RingKind kind) { return kind != RingKind::kLoose; }));
}

}  // namespace

CellPatches::CellPatches(const OneRings& rings, const Execution& execution) {
    grow(rings, execution);
    spread(rings, execution);
}

/// Grows patches of equal numbers of vertices; what is left over between them joins a neighbour.
void CellPatches::grow(const OneRings& rings, const Execution& execution) {
    const Index vertices = rings.vertex_count();
    const Index most = std::max<Index>(1, (count_with_ring(rings) + kPatches - 1) / kPatches);
    of.assign(vertices, -1);
    std::vector<Index> seeds;
    std::vector<char> is_seed(vertices, 0);
    std::vector<Index> members;
    for (Index first = 0; first < vertices; ++first) {
        execution.check_every(first);
        if (of[first] >= 0 || rings.valence(first) == 0) continue;
        seeds.assign(1, first);
        for (std::size_t next = 0; next < seeds.size(); ++next) {  // a part of the mesh, patch after patch outwards
            if (of[seeds[next]] >= 0) continue;
            const Index current = count();
            members.assign(1, seeds[next]);
            of[seeds[next]] = current;
            Index neighbour = -1;
            for (std::size_t k = 0; k < members.size(); ++k) {
                for (Index place = rings.offsets[members[k]]; place < rings.offsets[members[k] + 1]; ++place) {
                    const Index v = rings.vertices[place];
                    if (of[v] >= 0) {
                        if (of[v] != current) neighbour = of[v];
                    } else if (static_cast<Index>(members.size()) < most) {
                        of[v] = current;
                        members.push_back(v);
                    } else if (!is_seed[v]) {
                        is_seed[v] = 1;
                        seeds.push_back(v);
                    }
                }
            }
            if (neighbour >= 0 && static_cast<Index>(members.size()) * 3 < most) {
                for (const Index v : members)
                    of[v] = neighbour;
                sizes[neighbour] += static_cast<Index>(members.size());
            } else {
                sizes.push_back(static_cast<Index>(members.size()));
            }
        }
    }
}

void CellPatches::spread(const OneRings& rings, const Execution& execution) {
    const Index vertices = rings.vertex_count();
    std::vector<std::vector<Share>> known(vertices);
    for (Index v = 0; v < vertices; ++v) {
        if (of[v] >= 0) known[v] = {{of[v], 1.0}};
    }
    const double across = std::sqrt(static_cast<double>(count_with_ring(rings)) / std::max<Index>(1, count()));
    // Averaged with neighbors once for each cell across a patch, shares go over into those of the next.
    const int rounds = across < 1.5 ? 0 : static_cast<int>(std::lround(across));
    std::vector<double> sums(count(), 0.0);
    std::vector<Index> seen;
    for (int round = 0; round < rounds; ++round) {
        std::vector<std::vector<Share>> next(vertices);
        for (Index v = 0; v < vertices; ++v) {
            execution.check_every(v);
            seen.clear();
            const auto add = [&](Index from, double factor) {
                for (const Share& share : known[from]) {
                    if (sums[share.patch] == 0.0) seen.push_back(share.patch);
                    sums[share.patch] += factor * share.share;
                }
            };
            if (rings.valence(v) > 0) add(v, 1.0);
            for (const Index* neighbour = rings.begin(v); neighbour != rings.end(v); ++neighbour)
                add(*neighbour, 1.0 / rings.valence(v));
            std::sort(seen.begin(), seen.end());
            double kept = 0.0;
            for (const Index patch : seen) {
                if (sums[patch] > 2.0 * kLeastShare) {
                    next[v].push_back({patch, sums[patch]});
                    kept += sums[patch];
                }
                sums[patch] = 0.0;
            }
            for (Share& share : next[v])
                share.share /= kept;
        }
        known = std::move(next);
    }
    shares = grouped<Share>(vertices, [&](const auto& add) {
        for (Index v = 0; v < vertices; ++v)
            for (const Share& share : known[v])
                add(v, share);
    });
}

Quaternion CellPatches::mean_rotation(Index vertex, const Quaternion* rotations, std::size_t stride) const {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (const auto& [patch, share] : shares.of(vertex)) {
        const Eigen::Vector4d each = rotations[patch * stride].coeffs();
        sum += (sum.dot(each) < 0.0 ? -share : share) * each;
    }
    const double length = sum.norm();
    return length > 0.0 ? Quaternion(Eigen::Vector4d(sum / length)) : Quaternion::Identity();
}

std::vector<double> CellPatches::mean_weights(const ShapeWeights& weights) const {
    const auto shape_count = static_cast<std::size_t>(weights.shape_count());
    std::vector<double> result(sizes.size() * shape_count, 0.0);
    for (std::size_t v = 0; v < of.size(); ++v) {
        if (of[v] < 0) continue;
        for (std::size_t k = 0; k < shape_count; ++k)
            result[of[v] * shape_count + k] += weights.of(static_cast<Index>(v))[k] / sizes[of[v]];
    }
    return result;
}

}  // namespace meanvalue
