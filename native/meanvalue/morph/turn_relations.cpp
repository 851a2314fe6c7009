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
#include "meanvalue/morph/rotation_vectors.h"

namespace meanvalue {
namespace {

constexpr int kMostSteps = 4;
constexpr double kStepTolerance = 1e-2;  // radians; the next step is far below

/// The vector of a rotation by a small angle, times the sine of that over itself.
Vector3 small_turn(const Matrix3& r) {
    return 0.5 * Vector3(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
}

template <typename T>
std::size_t bytes_of(const std::vector<T>& items) {
    return items.capacity() * sizeof(T);
}

}  // namespace

TurnRelations::TurnRelations(const Encoding& layout, const std::vector<Vector3>& turns, Index shape_count,
                             const Execution& execution)
    : layout_(layout), shape_count_(shape_count), patches_(layout, execution), patch_count_(patches_.count()) {
    relate(turns, execution);
    factorise(execution);
    connect(execution);
}

/// The mean turns of patches, and those between neighbours.
void TurnRelations::relate(const std::vector<Vector3>& turns, const Execution& execution) {
    const auto count = static_cast<std::size_t>(shape_count_);
    std::vector<Matrix3> sums(patch_count_ * count, Matrix3::Zero());
    turns_.assign(patch_count_ * count, Vector3::Zero());
    std::map<std::pair<Index, Index>, double> edges;
    for (Index v = 0; v < layout_.vertex_count(); ++v) {
        execution.check_every(v);
        if (patches_.of[v] < 0) continue;
        for (std::size_t k = 0; k < count; ++k) {
            sums[patches_.of[v] * count + k] += rotation_by(turns[v * count + k]);
            turns_[patches_.of[v] * count + k] += turns[v * count + k] / patches_.sizes[patches_.of[v]];
        }
        for (Index place = layout_.ring_offsets[v]; place < layout_.ring_offsets[v + 1]; ++place) {
            const Index other = patches_.of[layout_.ring[place]];
            if (other >= 0 && other != patches_.of[v]) edges[std::minmax(patches_.of[v], other)] += 0.5;
        }
    }
    std::vector<Matrix3> means(sums.size());
    for (std::size_t k = 0; k < sums.size(); ++k) {
        means[k] = closest_rotation(sums[k]);
        turns_[k] = rotation_vector(means[k], turns_[k]);
    }
    for (const auto& [ends, weight] : edges) {
        pairs_.push_back({ends.first, ends.second, weight});
        for (std::size_t k = 0; k < count; ++k)
            relative_.push_back(
                rotation_vector(means[ends.first * count + k].transpose() * means[ends.second * count + k]));
    }
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
std::vector<Matrix3> TurnRelations::follow(const std::vector<Matrix3>& between,
                                           const std::vector<Matrix3>& in_space) const {
    std::vector<Matrix3> found = in_space;
    for (std::size_t begin = 0; begin < tree_.size();) {
        std::size_t end = begin;
        Matrix3 sum = Matrix3::Zero();
        do {
            const auto& [patch, from, pair] = tree_[end];
            if (patch != from)
                found[patch] = found[from] * (pairs_[pair].a == from ? between[pair] : between[pair].transpose());
            sum += patches_.sizes[patch] * in_space[patch] * found[patch].transpose();
            ++end;
        } while (end < tree_.size() && tree_[end].patch != tree_[end].from);
        const Matrix3 whole = closest_rotation(sum);
        for (; begin < end; ++begin)
            found[tree_[begin].patch] = whole * found[tree_[begin].patch];
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
    for (Index v = 0; v < layout_.vertex_count(); ++v) {
        if (patches_.of[v] < 0) continue;
        for (std::size_t k = 0; k < count; ++k)
            result[patches_.of[v] * count + k] += weights.of(v)[k] / patches_.sizes[patches_.of[v]];
    }
    return result;
}

/// One Gauss-Newton step. @return the largest turn.
double TurnRelations::step(const std::vector<Matrix3>& between, std::vector<Matrix3>& rotations,
                           const Execution& execution) const {
    Positions sums = Positions::Zero(patch_count_, 3);
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
        const auto& [a, b, weight] = pairs_[pair];
        // What b has to be turned by in space to agree with a.
        const Vector3 missing = weight * small_turn(rotations[a] * between[pair] * rotations[b].transpose());
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
        rotations[patch] = rotation_by(turn) * rotations[patch];
    }
    return largest;
}

void TurnRelations::correct(const ShapeWeights& weights, const std::vector<Matrix3>& frames, int threads,
                            const Execution& execution, std::vector<Matrix3>& rotations) const {
    if (patch_count_ == 0) return;
    const auto count = static_cast<std::size_t>(shape_count_);
    const std::vector<double> shares = weights_of_patches(weights);
    std::vector<Matrix3> in_space(patch_count_);
    for (Index patch = 0; patch < patch_count_; ++patch) {
        const std::size_t first = patch * count;
        in_space[patch] = average_turn(turns_.data() + first, frames, shares.data() + first, shape_count_);
    }
    std::vector<Matrix3> between(pairs_.size());
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
        Vector3 sum = Vector3::Zero();
        for (std::size_t k = 0; k < count; ++k) {
            const double share = 0.5 * (shares[pairs_[pair].a * count + k] + shares[pairs_[pair].b * count + k]);
            sum += share * relative_[pair * count + k];
        }
        between[pair] = rotation_by(sum);
    }
    std::vector<Matrix3> found = follow(between, in_space);
    for (int round = 0; round < kMostSteps && step(between, found, execution) > kStepTolerance; ++round) {
    }
    // Each on the branch that is nearest to its neighbour's: beyond half a turn they would cancel in between.
    std::vector<Vector3> corrections(patch_count_, Vector3::Zero());
    for (const Step& each : tree_)
        corrections[each.patch] =
            rotation_vector(found[each.patch] * in_space[each.patch].transpose(), corrections[each.from]);
    parallel_for(layout_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            Vector3 sum = Vector3::Zero();
            for (Index k = patches_.share_start[v]; k < patches_.share_start[v + 1]; ++k)
                sum += patches_.shares[k].share * corrections[patches_.shares[k].patch];
            rotations[v] = rotation_by(sum) * rotations[v];
        }
    });
}

std::size_t TurnRelations::bytes() const {
    return patches_.bytes() + bytes_of(turns_) + bytes_of(pairs_) + bytes_of(relative_) + bytes_of(tree_) +
           factor_.bytes();
}

}  // namespace meanvalue
