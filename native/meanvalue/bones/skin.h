// A mesh, the frames of a clip, and bones with weights that are to play it. Lengths are in sizes of the mesh.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

struct Weighted {
    Index number = -1;  ///< of a bone or a vertex
    double weight = 0.0;
};

struct Joint {
    Index parent = -1;                ///< below the bone's own number; none for a root
    Vector3 place = Vector3::Zero();  ///< at rest; of a root, the middle of its vertices
};

struct Bones {
    Eigen::MatrixXd motion;         ///< 3f x 4b: [R | T] of each bone in each frame
    std::vector<Joint> joints;      ///< b
    std::vector<Weighted> weights;  ///< n x influences
};

struct Skin : Bones {
    explicit Skin(const Eigen::MatrixXf& frames) : frames(frames) {}
    Index vertex_count() const { return static_cast<Index>(rest.cols()); }
    Index frame_count() const { return static_cast<Index>(frames.rows() / 3); }
    Index bone_count() const { return static_cast<Index>(joints.size()); }

    Eigen::Matrix4Xd rest;          ///< 4 x n, the last row 1
    const Eigen::MatrixXf& frames;  ///< 3f x n
    std::vector<Index> first;       ///< n: vertices in one place along a seam have the weights of the first
    Grouped<Index> around;          ///< the neighbors of each vertex that is first, once for each face
    Index influences = 1;
    bool moves_joints = false;  ///< places of joints are found too
    int threads = 1;
};

/// f x n: from where vertices are to where the bones carry them.
Eigen::MatrixXf distances(const Skin& skin, const Execution& execution);
/// 4b x 4b: sums of w_j w_k p p^T over vertices, p being (position at rest, 1).
Eigen::MatrixXd shares(const Skin& skin);

/// Turns all bones for the weights as they are, one after the other; joints are closed.
void fit_motion(Skin& skin, Index sweeps, const Execution& execution);
/// Minima of |sum w_j M_j p - v|^2 + smoothness |w - mean of neighbors'|^2 over w >= 0 of sum 1. One influence: the
/// bone that carries a vertex nearest.
void fit_weights(Skin& skin, const Execution& execution);

/// Vertices that move together, by a skin of one influence: split until there are `count` bones or all move as
/// theirs.
void split_bones(Skin& skin, Index count, const Execution& execution);
/// Joins bones that share weights where they move apart least, in a tree from the middle. Renumbers them.
void join_bones(Skin& skin);
/// Roots only: joints do not follow.
void drop_unused_bones(Skin& skin);

}  // namespace meanvalue
