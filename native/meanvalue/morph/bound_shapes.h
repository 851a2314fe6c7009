// What a Morpher keeps: everything that does not depend on the weights.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "meanvalue/decode/fast/deformation_energy.h"
#include "meanvalue/encoding/encoding_blend.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/morph/cell_assembly.h"
#include "meanvalue/morph/following_parts.h"
#include "meanvalue/morph/morpher.h"
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

    /// How shapes are put over each other for some weights: those that the whole is a mix of about their centres and
    /// at their common size, those that enter in part by what fits best where they do.
    struct Overlay {
        std::vector<Similarity> places;  ///< of each shape
        std::vector<double> sizes;       ///< see TurnedCells::fill()
        std::vector<Quaternion> frames;  ///< see TurnedCells::fill()
        Quaternion turn;                 ///< of the whole
        std::vector<double> counts;      ///< n: what each vertex counts when the result is placed
    };
    /// @param parts as MorphOptions::parts. @throws InvalidInput where these are no shapes, or all of them.
    Overlay overlay(const ShapeWeights& weights, const std::optional<std::vector<Index>>& parts,
                    const Execution& execution) const;
    /// The average shape by positions alone. @return n x 3.
    Positions linear_blend(const ShapeWeights& weights, const Overlay& overlay, int threads,
                           const Execution& execution) const;
    /// Moves each part of a shape onto another one by the rotation and translation that fit best; anchored parts by
    /// their anchors where these determine it. What is left open stays as it is turned. Parts that follow stay.
    /// @param counts n, or empty.
    void place(const Positions& onto, const std::vector<double>& counts, bool skip_anchored,
               Positions& positions) const;
    /// Moves parts that follow where the others take them, by rotation and translation.
    void take_along(const ShapeWeights& weights, int threads, const Execution& execution, Positions& positions) const;
    std::size_t bytes() const;

    std::vector<Positions> shapes;
    std::vector<Index> anchors;
    std::vector<char> is_fixed;  // n
    double rigidity = 0.0;
    double hold = 0.0;
    int threads = 1;
    InstructionSet instructions;
    Timings timings;
    std::vector<double> diagonals;  // mean_diagonal() of each shape
    std::unique_ptr<EncodingBlend> encodings;
    std::unique_ptr<TurnedCells> cells;
    RingParts parts;
    FollowingParts following;
    std::vector<double> stays;  // n: how much of each vertex stays where it is from shape to shape, above 0 to 1
    std::unique_ptr<CellAssembly> assembly;
    // What is solved for: all but the anchors, on springs.
    Unknowns unknowns;
    std::vector<SoftAnchor> springs;
    SupernodalFactor factor;

    DeformationEnergy energy_of(const Encoding& encoding, const RestCells& of_cells, double size,
                                const Execution& execution) const;

  private:
    Overlay stack(const std::vector<double>& weights) const;
    std::vector<char> flag_parts(const ShapeWeights& weights, const std::optional<std::vector<Index>>& parts) const;
    std::vector<double> whole_of(const ShapeWeights& weights, const std::vector<char>& is_part,
                                 const Execution& execution) const;
    Similarity place_of_part(std::size_t part, const ShapeWeights& weights, const std::vector<double>& whole,
                             const Overlay& overlay, const Execution& execution) const;
    Matrix3 turn_from(std::size_t shape, const std::vector<Quaternion>& turns, const std::vector<Index>& vertices,
                      const std::vector<double>& counts, const Execution& execution) const;
    void encode_shapes(const MorphBinding& binding, Execution& execution);
    void find_parts(const Execution& execution);
    void find_what_stays(const Execution& execution);
    void factorise(Execution& execution);
    void factorise(const DeformationEnergy& energy, Execution& execution);
};

/// What a draft goes on from: from one frame of a drag to the next, what the cells lack changes little.
struct LastSolve {
    Positions correction;         ///< n x 3: from where the cells put the vertices to where they ended
    std::vector<double> weights;  ///< of the shapes; empty: none yet, or each vertex had its own

    bool is_near(const ShapeWeights& others) const;
};

/// Of one solve at a time.
struct Morpher::Workspace {
    Workspace(const Bound& bound, const Execution& execution);
    std::size_t bytes() const;

    Encoding encoding;
    RestCells cells;
    std::vector<Quaternion> rotations;
    CellAssembly::Workspace assembly;
    std::unique_ptr<DeformationEnergy> energy;  // of `encoding` and `cells`
    DeformationEnergy::Workspace energy_room;
    Lbfgs minimiser;
    LastSolve last;
    Positions gradient;  // where one is not looked at
};

}  // namespace meanvalue
