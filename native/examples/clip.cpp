// SPDX-License-Identifier: MPL-2.0
// A clip
//
// Where the anchors go is known for every frame. Frames are solved in runs, side by side on all cores, and where two
// runs came to different shapes one fades into the other. The same frames have the same bits on any number of
// threads, so that machines can share a clip: `SequenceOptions::frames` names those that are wanted.
#include <meanvalue/meanvalue.h>

#include <cstdio>

#include "bar.h"

int main() {
    Eigen::MatrixXd V;
    Eigen::MatrixXi F;
    make_bar(V, F);
    const std::vector<int> anchors = both_ends();
    const meanvalue::Deformer deformer(meanvalue::Binding(V, F, anchors));

    // The last ring swings up and down again.
    meanvalue::Trajectories clip{60, static_cast<int>(anchors.size()), {}, {}};
    for (int frame = 0; frame < clip.frame_count; ++frame) {
        for (std::size_t k = 0; k < anchors.size(); ++k) {
            const double share = k < kCorners ? 0.0 : frame * (clip.frame_count - 1 - frame) / 870.0;
            const Eigen::RowVector3d at = V.row(anchors[k]) + share * Eigen::RowVector3d(-1.0, 0.0, 2.0);
            clip.targets.insert(clip.targets.end(), at.data(), at.data() + 3);
        }
    }
    const meanvalue::Sequence frames = meanvalue::solve_sequence(deformer, clip);

    std::printf("%d frames, %zu failed; the middle of frame 30 is %.6f higher\n", frames.frame_count,
                frames.failures.size(), frames.vertices[3 * (30 * V.rows() + V.rows() / 2) + 2] - V(V.rows() / 2, 2));
}
