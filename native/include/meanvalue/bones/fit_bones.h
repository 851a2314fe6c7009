// Bones and weights for a clip of any mesh, as game engines play them.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/shared_arrays.h"

namespace meanvalue {

/// Not aligned, as Rows.
using Transform = Eigen::Matrix<double, 4, 4, static_cast<int>(Eigen::RowMajor) | static_cast<int>(Eigen::DontAlign)>;

/// Bones in the space of the mesh.
struct Armature {
    Positions heads;                    ///< b x 3: where a bone is joined to its parent
    Positions tails;                    ///< b x 3
    std::vector<Index> parents;         ///< b: an earlier bone, -1 for a root
    std::vector<Transform> transforms;  ///< f x b, frame after frame: from rest to there, of columns (x, y, z, 1)
};

/// A mesh at rest and the frames that it is to play.
struct BoneClip {
    /// @param rest n x 3. @param faces to smooth weights along; none: they are not. @throws InvalidInput.
    BoneClip(SharedPositions rest, Index frame_count, Triangles faces = Triangles());
    /// @param positions n x 3; kept in single precision. @throws InvalidInput that names the frame.
    void set_frame(Index frame, const PositionsView& positions);

    SharedPositions rest;
    Triangles faces;
    Vector3 center;          ///< of rest
    double size = 0.0;       ///< root mean square distance from there
    Positions centers;       ///< of the frames
    Eigen::MatrixXf frames;  ///< 3f x n, in sizes, about their centers
};

struct BoneOptions {
    Index count = 20;      ///< bones; fewer where the clip has no more motion
    double error = 0.0;    ///< above 0: root mean square distance, in units, to reach with as few bones as it takes
    Index influences = 4;  ///< most weights of a vertex
    bool joints = true;    ///< bones are held together at joints; else each moves by itself, closer to the clip
    Armature armature;  ///< bones to take; none: they are found. With transforms, turns and moves, weights alone are
    int threads = 0;    ///< 0: every core
};

/// Vertex i of frame t is near the sum over bones j of weights(i, j) * transforms[t * b + j] * rest(i).
struct BoneFit {
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> weights;  ///< n x b, from 0, of sum 1
    Armature armature;
    Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> errors;  ///< f x n: distances, in units
};

/// Smooth skinning with rigid bones (Le and Deng 2012, 2014). Bones turn and move: parts that grow, or more flying
/// pieces than bones, are left in `errors`. Bones whose vertices share no weights are roots of their own.
/// The same bits for any number of threads.
/// @throws InvalidInput that names what is wrong, Cancelled. Cost: linear in vertices times frames times bones.
BoneFit fit_bones(const BoneClip& clip, const BoneOptions& options, Execution& execution);

}  // namespace meanvalue
