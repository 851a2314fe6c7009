// What a Morpher keeps: everything that does not depend on the weights.
#pragma once

#include <memory>
#include <vector>

#include "meanvalue/decode/fast/deformation_energy.h"
#include "meanvalue/encoding/encoding_blend.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/morph/morpher.h"
#include "meanvalue/morph/poisson_blend.h"
#include "meanvalue/morph/turned_cells.h"
#include "meanvalue/optimise/lbfgs.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// Parts of the mesh that hang together by rings.
struct RingParts {
    std::vector<std::vector<Index>> members;  ///< ascending, of each part
    std::vector<char> is_anchored;            ///< of each part
};

struct Morpher::Bound {
    Bound(const MorphBinding& binding, Execution& execution);

    /// The average shape by positions alone. @return n x 3.
    Positions linear_blend(const ShapeWeights& weights, int threads, const Execution& execution) const;
    /// Moves each part of a shape onto another one by the rotation and translation that fit best; anchored parts by
    /// their anchors where these determine it. @param turn what decides where both leave it open.
    void place(const Positions& onto, const Matrix3& turn, bool skip_anchored, Positions& positions) const;
    std::size_t bytes() const;

    std::vector<Positions> shapes;
    std::vector<Index> anchors;
    std::vector<char> is_fixed;  // n
    double rigidity = 0.0;
    int threads = 1;
    InstructionSet instructions;
    Timings timings;
    std::vector<double> diagonals;  // mean_diagonal() of each shape
    std::unique_ptr<EncodingBlend> encodings;
    std::unique_ptr<TurnedCells> cells;
    RingParts parts;
    Unknowns unknowns;
    std::unique_ptr<PoissonBlend> poisson;
    SupernodalFactor factor;  // of the energy's constant matrix for the average of all shapes

  private:
    void encode_shapes(const MorphBinding& binding, Execution& execution);
    void find_parts(const Execution& execution);
    void factorise(Execution& execution);
};

/// Of one solve at a time.
struct Morpher::Workspace {
    Encoding encoding;
    RestCells cells;
    std::vector<Matrix3> rotations;
    PoissonBlend::Workspace poisson;
    SupernodalFactor::Workspace factor;
    Lbfgs minimiser;
};

}  // namespace meanvalue
