#include "meanvalue/morph/turn_relations.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <queue>
#include <tuple>
#include <utility>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/closest_rotation.h"
#include "meanvalue/mesh/disjoint_sets.h"

namespace meanvalue {
namespace {

// Enough for every finger. Finer ones follow strains, which tilt the axes that neighbours are turned about.
constexpr Index kPatches = 600;
constexpr int kMostSteps = 4;
constexpr double kStepTolerance = 1e-3;  // radians; the next step is far below
// Shares of patches go over into each other by averaging with neighbours, so many times per cell across a patch.
constexpr double kSpreads = 1.5;
constexpr double kLeastShare = 1e-2;

/// The vector of a rotation by a small angle, times the sine of that over itself.
Vector3 small_turn(const Quaternion& q) {
    return 2.0 * q.w() * q.vec();
}

template <typename T>
std::size_t bytes_of(const std::vector<T>& items) {
    return items.capacity() * sizeof(T);
}

}  // namespace

TurnRelations::TurnRelations(const Encoding& layout, const std::vector<Vector3>& turns, Index shape_count,
                             int threads, const Execution& execution)
    : layout_(layout), shape_count_(shape_count) {
    find_patches(execution);
    spread_shares(execution);
    relate(turns, execution);
    turn_against_patches(turns, threads, execution);
    factorise(execution);
    connect(execution);
}

/// Grows patches of equal numbers of vertices; what is left over between them joins a neighbour.
void TurnRelations::find_patches(const Execution& execution) {
    const Index vertices = layout_.vertex_count();
    const Index most = std::max<Index>(1, (vertices + kPatches - 1) / kPatches);
    patch_of_.assign(vertices, -1);
    std::vector<Index> seeds;
    std::vector<char> is_seed(vertices, 0);
    std::vector<Index> members;
    for (Index first = 0; first < vertices; ++first) {
        execution.check_every(first);
        if (patch_of_[first] >= 0 || !layout_.predictable(first)) continue;
        seeds.assign(1, first);
        for (std::size_t next = 0; next < seeds.size(); ++next) {  // a part of the mesh, patch after patch outwards
            if (patch_of_[seeds[next]] >= 0) continue;
            members.assign(1, seeds[next]);
            patch_of_[seeds[next]] = patch_count_;
            Index neighbour = -1;
            for (std::size_t k = 0; k < members.size(); ++k) {
                for (Index place = layout_.ring_offsets[members[k]]; place < layout_.ring_offsets[members[k] + 1];
                     ++place) {
                    const Index v = layout_.ring[place];
                    if (!layout_.predictable(v)) continue;
                    if (patch_of_[v] >= 0) {
                        if (patch_of_[v] != patch_count_) neighbour = patch_of_[v];
                    } else if (static_cast<Index>(members.size()) < most) {
                        patch_of_[v] = patch_count_;
                        members.push_back(v);
                    } else if (!is_seed[v]) {
                        is_seed[v] = 1;
                        seeds.push_back(v);
                    }
                }
            }
            if (neighbour >= 0 && static_cast<Index>(members.size()) * 3 < most) {
                for (const Index v : members)
                    patch_of_[v] = neighbour;
                sizes_[neighbour] += static_cast<Index>(members.size());
            } else {
                sizes_.push_back(static_cast<Index>(members.size()));
                ++patch_count_;
            }
        }
    }
}

void TurnRelations::spread_shares(const Execution& execution) {
    const Index vertices = layout_.vertex_count();
    std::vector<std::vector<Share>> shares(vertices);
    for (Index v = 0; v < vertices; ++v) {
        if (patch_of_[v] >= 0) shares[v] = {{patch_of_[v], 1.0}};
    }
    const double across = std::sqrt(static_cast<double>(vertices) / std::max<Index>(1, patch_count_));
    const int rounds = across < 1.5 ? 0 : static_cast<int>(kSpreads * across + 0.5);
    std::vector<double> sums(patch_count_, 0.0);
    std::vector<Index> seen;
    for (int round = 0; round < rounds; ++round) {
        std::vector<std::vector<Share>> spread(vertices);
        for (Index v = 0; v < vertices; ++v) {
            execution.check_every(v);
            seen.clear();
            const auto add = [&](Index from, double factor) {
                for (const Share& share : shares[from]) {
                    if (sums[share.patch] == 0.0) seen.push_back(share.patch);
                    sums[share.patch] += factor * share.share;
                }
            };
            const Index begin = layout_.ring_offsets[v];
            const Index end = layout_.ring_offsets[v + 1];
            if (begin < end) add(v, 1.0);
            for (Index place = begin; place < end; ++place)
                add(layout_.ring[place], 1.0 / (end - begin));
            std::sort(seen.begin(), seen.end());
            double kept = 0.0;
            for (const Index patch : seen) {
                if (sums[patch] > 2.0 * kLeastShare) {
                    spread[v].push_back({patch, sums[patch]});
                    kept += sums[patch];
                }
                sums[patch] = 0.0;
            }
            for (Share& share : spread[v])
                share.share /= kept;
        }
        shares = std::move(spread);
    }
    share_start_.assign(1, 0);
    for (Index v = 0; v < vertices; ++v) {
        shares_.insert(shares_.end(), shares[v].begin(), shares[v].end());
        share_start_.push_back(static_cast<Index>(shares_.size()));
    }
}

/// The mean turns of patches, and those between neighbours.
void TurnRelations::relate(const std::vector<Vector3>& turns, const Execution& execution) {
    const auto count = static_cast<std::size_t>(shape_count_);
    std::vector<Matrix3> sums(patch_count_ * count, Matrix3::Zero());
    turns_.assign(patch_count_ * count, Vector3::Zero());
    std::map<std::pair<Index, Index>, double> edges;
    for (Index v = 0; v < layout_.vertex_count(); ++v) {
        execution.check_every(v);
        if (patch_of_[v] < 0) continue;
        for (std::size_t k = 0; k < count; ++k) {
            sums[patch_of_[v] * count + k] += rotation_by(turns[v * count + k]);
            turns_[patch_of_[v] * count + k] += turns[v * count + k] / sizes_[patch_of_[v]];
        }
        for (Index place = layout_.ring_offsets[v]; place < layout_.ring_offsets[v + 1]; ++place) {
            const Index other = patch_of_[layout_.ring[place]];
            if (other >= 0 && other != patch_of_[v]) edges[std::minmax(patch_of_[v], other)] += 0.5;
        }
    }
    means_.resize(sums.size());
    for (std::size_t k = 0; k < sums.size(); ++k) {
        means_[k] = quaternion_of(closest_rotation(sums[k]));
        turns_[k] = rotation_vector(means_[k], turns_[k]);
    }
    for (const auto& [ends, weight] : edges) {
        pairs_.push_back({ends.first, ends.second, weight});
        for (std::size_t k = 0; k < count; ++k)
            relative_.push_back(
                rotation_vector(means_[ends.first * count + k].conjugate() * means_[ends.second * count + k]));
    }
}

/// The rotation that the patches about a cell have in the mean, each as much as its share. @param patches one for
/// each, `stride` apart.
Quaternion TurnRelations::mean_of_patches(Index vertex, const Quaternion* patches, std::size_t stride) const {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (Index k = share_start_[vertex]; k < share_start_[vertex + 1]; ++k) {
        const Eigen::Vector4d each = patches[shares_[k].patch * stride].coeffs();
        sum += (sum.dot(each) < 0.0 ? -shares_[k].share : shares_[k].share) * each;
    }
    const double length = sum.norm();
    return length > 0.0 ? Quaternion(Eigen::Vector4d(sum / length)) : Quaternion::Identity();
}

void TurnRelations::turn_against_patches(const std::vector<Vector3>& turns, int threads, const Execution& execution) {
    const auto count = static_cast<std::size_t>(shape_count_);
    own_turns_.resize(turns.size());
    parallel_for(layout_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            for (std::size_t k = 0; k < count; ++k) {
                const Quaternion mean = mean_of_patches(v, means_.data() + k, count);
                own_turns_[v * count + k] = rotation_vector(mean.conjugate() * quaternion_by(turns[v * count + k]));
            }
        }
    });
}

/// From patch to patch over the neighbours that are turned the most alike, beginning where least is turned.
void TurnRelations::connect(const Execution& execution) {
    const auto count = static_cast<std::size_t>(shape_count_);
    const auto largest = [count](const Vector3* vectors) {
        double result = 0.0;
        for (std::size_t k = 0; k < count; ++k)
            result = std::max(result, vectors[k].norm());
        return result;
    };
    std::vector<std::vector<std::pair<double, std::size_t>>> next_to(patch_count_);
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
        const double turn = largest(relative_.data() + pair * count);
        next_to[pairs_[pair].a].emplace_back(turn, pair);
        next_to[pairs_[pair].b].emplace_back(turn, pair);
    }
    std::vector<std::pair<double, Index>> starts(patch_count_);
    for (Index patch = 0; patch < patch_count_; ++patch)
        starts[patch] = {largest(turns_.data() + patch * count), patch};
    std::sort(starts.begin(), starts.end());
    std::vector<char> is_known(patch_count_, 0);
    using Edge = std::tuple<double, Index, Index, std::size_t>;  // turn, to, from, pair
    std::priority_queue<Edge, std::vector<Edge>, std::greater<>> queue;
    for (const auto& [turn, start] : starts) {
        if (!is_known[start]) queue.emplace(0.0, start, start, 0);
        while (!queue.empty()) {
            execution.check_every(tree_.size());
            const auto [cost, to, from, way] = queue.top();
            queue.pop();
            if (is_known[to]) continue;
            is_known[to] = 1;
            tree_.push_back({to, from, way});
            for (const auto& [further, pair] : next_to[to]) {
                const Index next = pairs_[pair].a == to ? pairs_[pair].b : pairs_[pair].a;
                if (!is_known[next]) queue.emplace(further, next, to, pair);
            }
        }
    }
}

/// The rotations that have all turns between neighbours of the tree, each part of the mesh turned as a whole to what
/// its patches are in space. From there to the best is not far, however far limbs are turned.
std::vector<Quaternion> TurnRelations::follow(const std::vector<Quaternion>& between,
                                              const std::vector<Quaternion>& in_space) const {
    std::vector<Quaternion> found = in_space;
    for (std::size_t begin = 0; begin < tree_.size();) {
        std::size_t end = begin;
        Matrix3 sum = Matrix3::Zero();
        do {
            const auto& [patch, from, pair] = tree_[end];
            if (patch != from)
                found[patch] = found[from] * (pairs_[pair].a == from ? between[pair] : between[pair].conjugate());
            sum += sizes_[patch] * (in_space[patch] * found[patch].conjugate()).toRotationMatrix();
            ++end;
        } while (end < tree_.size() && tree_[end].patch != tree_[end].from);
        const Quaternion whole = quaternion_of(closest_rotation(sum));
        for (; begin < end; ++begin)
            found[tree_[begin].patch] = (whole * found[tree_[begin].patch]).normalized();
    }
    return found;
}

void TurnRelations::factorise(const Execution& execution) {
    DisjointSets sets(patch_count_);
    std::vector<double> diagonal(patch_count_, 0.0);
    std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries;
    for (const Pair& pair : pairs_) {
        sets.join(pair.a, pair.b);
        diagonal[pair.a] += pair.weight;
        diagonal[pair.b] += pair.weight;
        entries.emplace_back(pair.b, pair.a, -pair.weight);
    }
    for (Index patch = 0; patch < patch_count_; ++patch) {
        const double pinned = sets.root(patch) == patch ? 2.0 : 1.0;
        entries.emplace_back(patch, patch, diagonal[patch] > 0.0 ? pinned * diagonal[patch] : 1.0);
    }
    if (patch_count_ == 0) return;
    SparseMatrix lower(patch_count_, patch_count_);
    lower.setFromTriplets(entries.begin(), entries.end());
    factor_.analyse(lower, execution);
    if (!factor_.factorise(lower, execution))
        throw SolverFailure(message("the turns of ", patch_count_, " patches are not determined"));
}

/// patches x k.
std::vector<double> TurnRelations::weights_of_patches(const ShapeWeights& weights) const {
    const auto count = static_cast<std::size_t>(shape_count_);
    std::vector<double> result(patch_count_ * count, 0.0);
    if (weights.is_uniform()) {
        for (std::size_t k = 0; k < result.size(); ++k)
            result[k] = weights.of(0)[k % count];
        return result;
    }
    for (Index v = 0; v < layout_.vertex_count(); ++v) {
        if (patch_of_[v] < 0) continue;
        for (std::size_t k = 0; k < count; ++k)
            result[patch_of_[v] * count + k] += weights.of(v)[k] / sizes_[patch_of_[v]];
    }
    return result;
}

/// One Gauss-Newton step. @return the largest turn.
double TurnRelations::step(const std::vector<Quaternion>& between, std::vector<Quaternion>& rotations,
                           const Execution& execution) const {
    Positions sums = Positions::Zero(patch_count_, 3);
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
        const auto& [a, b, weight] = pairs_[pair];
        // What b has to be turned by in space to agree with a.
        const Vector3 missing = weight * small_turn(rotations[a] * between[pair] * rotations[b].conjugate());
        sums.row(b) += missing.transpose();
        sums.row(a) -= missing.transpose();
    }
    SupernodalFactor::Workspace workspace;
    factor_.solve(sums, sums, 1, execution, workspace);
    // Only differences count: the whole stays as it is.
    sums.rowwise() -= sums.colwise().mean();
    double largest = 0.0;
    for (Index patch = 0; patch < patch_count_; ++patch) {
        const Vector3 turn = sums.row(patch);
        largest = std::max(largest, turn.norm());
        rotations[patch] = (quaternion_by(turn) * rotations[patch]).normalized();
    }
    return largest;
}

/// @param shares patches x k: their weights.
std::vector<Quaternion> TurnRelations::find_patches_between(const std::vector<double>& shares,
                                                            const std::vector<Quaternion>& frames,
                                                            const Execution& execution) const {
    const auto count = static_cast<std::size_t>(shape_count_);
    std::vector<Quaternion> in_space(patch_count_);
    for (Index patch = 0; patch < patch_count_; ++patch) {
        const std::size_t first = patch * count;
        in_space[patch] = average_turn(turns_.data() + first, frames, shares.data() + first, shape_count_);
    }
    std::vector<Quaternion> between(pairs_.size());
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
        Vector3 sum = Vector3::Zero();
        for (std::size_t k = 0; k < count; ++k) {
            const double share = 0.5 * (shares[pairs_[pair].a * count + k] + shares[pairs_[pair].b * count + k]);
            sum += share * relative_[pair * count + k];
        }
        between[pair] = quaternion_by(sum);
    }
    std::vector<Quaternion> found = follow(between, in_space);
    for (int round = 0; round < kMostSteps && step(between, found, execution) > kStepTolerance; ++round) {
    }
    return found;
}

/// What a vertex is turned further where its weights are not those of its patches.
/// @param mean of these in between.
Quaternion TurnRelations::own_weights(Index vertex, const double* weights, const std::vector<double>& shares,
                                      const std::vector<Quaternion>& frames, const Quaternion& mean) const {
    const auto count = static_cast<std::size_t>(shape_count_);
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < count; ++k) {
        double more = weights[k];
        for (Index place = share_start_[vertex]; place < share_start_[vertex + 1]; ++place)
            more -= shares_[place].share * shares[shares_[place].patch * count + k];
        if (more == 0.0) continue;
        const Quaternion own = mean_of_patches(vertex, means_.data() + k, count);
        sum += more * rotation_vector(mean.conjugate() * (frames.empty() ? own : frames[k] * own));
    }
    return quaternion_by(sum);
}

void TurnRelations::fill(const ShapeWeights& weights, const std::vector<Quaternion>& frames, const Quaternion& turn,
                         int threads, const Execution& execution, std::vector<Quaternion>& rotations) const {
    const auto count = static_cast<std::size_t>(shape_count_);
    const std::vector<double> shares = weights_of_patches(weights);
    const std::vector<Quaternion> patches = find_patches_between(shares, frames, execution);
    rotations.resize(layout_.vertex_count());
    parallel_for(layout_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const double* const of = weights.of(v);
            rotations[v] = mean_of_patches(v, patches.data(), 1);
            if (!weights.is_uniform()) rotations[v] *= own_weights(v, of, shares, frames, rotations[v]);
            rotations[v] = turn * rotations[v] * average_turn(own_turns_.data() + v * count, {}, of, shape_count_);
        }
    });
}

std::size_t TurnRelations::bytes() const {
    return bytes_of(patch_of_) + bytes_of(sizes_) + bytes_of(turns_) + bytes_of(means_) + bytes_of(own_turns_) +
           bytes_of(pairs_) + bytes_of(relative_) + bytes_of(tree_) + bytes_of(share_start_) + bytes_of(shares_) +
           factor_.bytes();
}

}  // namespace meanvalue
