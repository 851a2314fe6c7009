// What free vertices answer to handles that move, by the initial Hessian: asked when one begins to move, then used
// frame after frame.
#pragma once

#include <functional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// The drivers of a shape (see SecantPredictor), by handle.
struct DrivingHandles {
    /// @param rest d x 3, the drivers at rest; @param piece_of d, the handle of each, numbered from 0.
    DrivingHandles(const Positions& rest, const std::vector<Index>& piece_of);

    std::vector<std::vector<Index>> pieces;  ///< the drivers of each handle
    Positions places;                        ///< d x 3, at rest from the middle of its handle, whose spread is 1
    std::vector<char> has_extent;            ///< of each handle: whether it is more than a point
};

/// The answer to a handle's move is linear in it, and an affine move of a handle has twelve numbers. So four fields
/// over the free vertices, each a solve of one column, answer every rigid move of a handle, in any pose of it.
class HandleResponses {
  public:
    /// |V'| rows: the answers to the three axes of `places`, and to a translation.
    using Fields = Eigen::Matrix<float, Eigen::Dynamic, 4, Eigen::RowMajor>;
    /// The Hessian's answer, |V'| x 3, to moves of the drivers, d x 3.
    using Hessian = std::function<Positions(const Positions& moves)>;

    HandleResponses() = default;
    explicit HandleResponses(const DrivingHandles& handles) : handles_(&handles) {}

    /// Numbers of the handles of which some driver moves by more than `least`; none where they are too many to be
    /// kept.
    /// @param moves d x 3.
    std::vector<Index> moving(const Positions& moves, double least) const;
    /// Those of `handles` that have not been asked for.
    std::vector<Index> unknown(const std::vector<Index>& handles) const;
    /// The fields of handles, to be kept(): two solves for one, a single one for up to three that are points.
    std::vector<Fields> ask(const std::vector<Index>& handles, const Hessian& hessian) const;
    /// Keeps fields of handles that are all moving(). Others go where they would be too many.
    void keep(const std::vector<Index>& handles, std::vector<Fields> fields, const std::vector<Index>& moving);
    void forget() { known_.clear(); }

    /// Moves the free vertices in `positions` (n x 3) as far as handles are known and their moves affine.
    /// @param moves d x 3; receives what is not answered.
    void answer(Positions& moves, const Unknowns& unknowns, Positions& positions, int threads,
                const Execution& execution) const;

  private:
    struct Known {
        Index handle;
        Fields fields;
    };

    const DrivingHandles* handles_ = nullptr;
    std::vector<Known> known_;
};

}  // namespace meanvalue
