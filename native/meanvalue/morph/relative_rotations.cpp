#include "meanvalue/morph/relative_rotations.h"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/morph/cell_assembly.h"

namespace meanvalue {
namespace {

// Of Gauss and Newton: each squares what is left, so that more change nothing that can be seen.
constexpr int kSteps = 3;

/// The axis of a rotation by a small angle, as long as the sine of that.
Vector3 small_rotation(const Quaternion& q) {
    return 2.0 * q.w() * q.vec();
}

/// Takes the mean of all cells' rotations in each shape out of them. @param rotations n x k.
void take_out_shape_rotations(std::vector<Quaternion>& rotations, std::vector<Quaternion>& shape_rotations,
                              const Execution& execution) {
    const std::size_t count = shape_rotations.size();
    for (std::size_t k = 0; k < count; ++k) {
        execution.check();
        const Quaternion mean = nearest_to_all(rotations, k, count);
        shape_rotations[k] = shape_rotations[k] * mean;
        for (std::size_t v = k; v < rotations.size(); v += count)
            rotations[v] = mean.conjugate() * rotations[v];
    }
}

}  // namespace

RelativeRotations::RelativeRotations(const OneRings& rings, std::vector<Quaternion>& rotations,
                                     std::vector<Quaternion>& shape_rotations, int threads,
                                     const Execution& execution)
    : rings_(rings), count_(shape_rotations.size()), patches_(rings, execution), patch_count_(patches_.count()) {
    take_out_shape_rotations(rotations, shape_rotations, execution);
    find_pairs(execution);
    average_patches(rotations, execution);
    connect(execution);
    centre(rotations);
    take_out_shape_rotations(rotations, shape_rotations, execution);
    average_patches(rotations, execution);
    for (std::size_t k = 0; k < means_.size(); ++k)
        patch_vectors_[k] = rotation_vector(means_[k], patch_vectors_[k]);
    rotate_against_patches(rotations, threads, execution);
    if (patch_count_ == 0) return;
    std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries;
    entries.reserve(pairs_.size());
    for (const auto& [a, b, weight] : pairs_)
        entries.emplace_back(b, a, -weight);
    factor_laplacian(patch_count_, std::move(entries), 1, execution, factor_);
}

void RelativeRotations::find_pairs(const Execution& execution) {
    std::map<std::pair<Index, Index>, double> edges;
    for (Index v = 0; v < rings_.vertex_count(); ++v) {
        execution.check_every(v);
        for (const Index* neighbour = rings_.begin(v); neighbour != rings_.end(v); ++neighbour) {
            const Index other = patches_.of[*neighbour];
            if (other >= 0 && other != patches_.of[v]) edges[std::minmax(patches_.of[v], other)] += 0.5;
        }
    }
    for (const auto& [ends, weight] : edges)
        pairs_.push_back({ends.first, ends.second, weight});
}

/// Finds the mean rotation of each patch in each shape, and the rotations between neighboring patches.
void RelativeRotations::average_patches(const std::vector<Quaternion>& rotations, const Execution& execution) {
    std::vector<Matrix3> sums(patch_count_ * count_, Matrix3::Zero());
    for (Index v = 0; v < rings_.vertex_count(); ++v) {
        execution.check_every(v);
        if (patches_.of[v] < 0) continue;
        for (std::size_t k = 0; k < count_; ++k)
            sums[patches_.of[v] * count_ + k] += rotations[v * count_ + k].toRotationMatrix();
    }
    means_.clear();
    for (const Matrix3& sum : sums)
        means_.emplace_back(closest_rotation(sum));
    relative_.clear();
    for (const Pair& pair : pairs_) {
        for (std::size_t k = 0; k < count_; ++k)
            relative_.push_back(
                rotation_vector(means_[pair.a * count_ + k].conjugate() * means_[pair.b * count_ + k]));
    }
}

/// Takes the average over all shapes out of the rotations of each cell, on the branch of its patch: half of a
/// rotation is not ambiguous where the whole is.
void RelativeRotations::centre(std::vector<Quaternion>& rotations) {
    for (std::size_t v = 0; v < patches_.of.size(); ++v) {
        if (patches_.of[v] < 0) continue;
        Vector3 mean = Vector3::Zero();
        for (std::size_t k = 0; k < count_; ++k)
            mean += rotation_vector(rotations[v * count_ + k], patch_vectors_[patches_.of[v] * count_ + k]) / count_;
        const Quaternion from_centre = quaternion_by(-mean);
        for (std::size_t k = 0; k < count_; ++k)
            rotations[v * count_ + k] *= from_centre;
    }
    for (Index patch = 0; patch < patch_count_; ++patch) {
        Vector3* const vectors = patch_vectors_.data() + patch * count_;
        const Vector3 mean = std::accumulate(vectors, vectors + count_, Vector3(Vector3::Zero())) / count_;
        for (std::size_t k = 0; k < count_; ++k)
            vectors[k] -= mean;
    }
}

/// Finds how each cell is rotated against the patches around it.
void RelativeRotations::rotate_against_patches(const std::vector<Quaternion>& rotations, int threads,
                                               const Execution& execution) {
    own_vectors_.resize(rotations.size());
    parallel_for(rings_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            for (std::size_t k = 0; k < count_; ++k) {
                const Quaternion mean = patches_.mean_rotation(v, means_.data() + k, count_);
                own_vectors_[v * count_ + k] = rotation_vector(mean.conjugate() * rotations[v * count_ + k]);
            }
        }
    });
}

/// Makes a spanning tree of each part, over the neighbors that are rotated the most alike, from its least rotated
/// patch, and follows the rotations along it beyond 180 degrees.
void RelativeRotations::connect(const Execution& execution) {
    const auto largest = [this](const Vector3* vectors) {
        double result = 0.0;
        for (std::size_t k = 0; k < count_; ++k)
            result = std::max(result, vectors[k].norm());
        return result;
    };
    for (const Quaternion& mean : means_)
        patch_vectors_.push_back(rotation_vector(mean));
    std::vector<std::vector<std::pair<double, std::size_t>>> next_to(patch_count_);
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
        const double angle = largest(relative_.data() + pair * count_);
        next_to[pairs_[pair].a].emplace_back(angle, pair);
        next_to[pairs_[pair].b].emplace_back(angle, pair);
    }
    std::vector<std::pair<double, Index>> least(patch_count_);
    for (Index patch = 0; patch < patch_count_; ++patch)
        least[patch] = {largest(patch_vectors_.data() + patch * count_), patch};
    std::sort(least.begin(), least.end());
    starts_.assign(patch_count_, -1);
    using Edge = std::tuple<double, Index, Index, std::size_t>;  // angle, to, from, pair
    std::priority_queue<Edge, std::vector<Edge>, std::greater<>> queue;
    for (const auto& [angle, start] : least) {
        if (starts_[start] < 0) queue.emplace(0.0, start, start, 0);
        while (!queue.empty()) {
            execution.check_every(tree_.size());
            const auto [cost, to, from, way] = queue.top();
            queue.pop();
            if (starts_[to] >= 0) continue;
            starts_[to] = start;
            tree_.push_back({to, from, way});
            for (std::size_t k = 0; k < count_; ++k)
                patch_vectors_[to * count_ + k] =
                    rotation_vector(means_[to * count_ + k], patch_vectors_[from * count_ + k]);
            for (const auto& [further, pair] : next_to[to]) {
                const Index next = pairs_[pair].a == to ? pairs_[pair].b : pairs_[pair].a;
                if (starts_[next] < 0) queue.emplace(further, next, to, pair);
            }
        }
    }
}

/// One Gauss-Newton step, which leaves one patch of each part of the mesh as it is.
void RelativeRotations::step(const std::vector<Quaternion>& between, std::vector<Quaternion>& rotations,
                             const Execution& execution) const {
    Positions sums = Positions::Zero(patch_count_, 3);
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
        const auto& [a, b, weight] = pairs_[pair];
        // By what b has to be rotated in space to agree with a.
        const Vector3 missing = weight * small_rotation(rotations[a] * between[pair] * rotations[b].conjugate());
        sums.row(b) += missing.transpose();
        sums.row(a) -= missing.transpose();
    }
    SupernodalFactor::Workspace workspace;
    factor_.solve(sums, sums, 1, execution, workspace);
    for (Index patch = 0; patch < patch_count_; ++patch)
        rotations[patch] = (quaternion_by(sums.row(patch)) * rotations[patch]).normalized();
}

/// The rotations of the patches in between. @param shares patches x shapes: the weights of each patch.
std::vector<Quaternion> RelativeRotations::find_patches_between(const std::vector<double>& shares,
                                                                const std::vector<Quaternion>& frames,
                                                                const Execution& execution) const {
    if (patch_count_ == 0) return {};  // no vertex has a ring
    std::vector<Quaternion> in_space(patch_count_);
    for (Index patch = 0; patch < patch_count_; ++patch) {
        const std::size_t first = patch * count_;
        in_space[patch] = average_rotation(patch_vectors_.data() + first, frames, shares.data() + first, count_);
    }
    std::vector<Quaternion> between(pairs_.size());
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
        Vector3 sum = Vector3::Zero();
        for (std::size_t k = 0; k < count_; ++k) {
            const double share = 0.5 * (shares[pairs_[pair].a * count_ + k] + shares[pairs_[pair].b * count_ + k]);
            sum += share * relative_[pair * count_ + k];
        }
        between[pair] = quaternion_by(sum);
    }
    // Steps start with exactly the given rotations between neighbors of the tree: the best is near, however far limbs
    // are bent.
    std::vector<Quaternion> found = in_space;
    for (const auto& [patch, from, pair] : tree_)
        if (patch != from)
            found[patch] = found[from] * (pairs_[pair].a == from ? between[pair] : between[pair].conjugate());
    for (int round = 0; round < kSteps; ++round)
        step(between, found, execution);
    // Only differences counted: each part of the mesh is turned as a whole to fit best in space.
    std::vector<Matrix3> wholes(patch_count_, Matrix3::Zero());
    for (Index patch = 0; patch < patch_count_; ++patch)
        wholes[starts_[patch]] +=
            patches_.sizes[patch] * (in_space[patch] * found[patch].conjugate()).toRotationMatrix();
    closest_rotations(wholes.data(), patch_count_);
    for (Index patch = 0; patch < patch_count_; ++patch)
        found[patch] = (Quaternion(wholes[starts_[patch]]) * found[patch]).normalized();
    return found;
}

/// The further rotation of a vertex whose weights differ from those of its patches.
/// @param mean the rotation of these patches in between.
Quaternion RelativeRotations::own_weights(Index vertex, const double* weights, const std::vector<double>& shares,
                                          const std::vector<Quaternion>& frames, const Quaternion& mean) const {
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < count_; ++k) {
        double more = weights[k];
        for (const auto& [patch, share] : patches_.shares.of(vertex))
            more -= share * shares[patch * count_ + k];
        if (more == 0.0) continue;
        const Quaternion own = patches_.mean_rotation(vertex, means_.data() + k, count_);
        sum += more * rotation_vector(mean.conjugate() * (frames.empty() ? own : frames[k] * own));
    }
    return quaternion_by(sum);
}

void RelativeRotations::fill(const ShapeWeights& weights, const std::vector<Quaternion>& frames,
                             const Quaternion& rotation, int threads, const Execution& execution,
                             std::vector<Quaternion>& rotations) const {
    const std::vector<double> shares = patches_.mean_weights(weights);
    const std::vector<Quaternion> patches = find_patches_between(shares, frames, execution);
    rotations.resize(rings_.vertex_count());
    parallel_for(rings_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const double* const of = weights.of(v);
            rotations[v] = patches_.mean_rotation(v, patches.data(), 1);
            if (!weights.is_uniform()) rotations[v] *= own_weights(v, of, shares, frames, rotations[v]);
            rotations[v] =
                rotation * rotations[v] * average_rotation(own_vectors_.data() + v * count_, {}, of, count_);
        }
    });
}

}  // namespace meanvalue
