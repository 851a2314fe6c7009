// Clothes that a pose would put below their carrier are lifted out again, one way only.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/follow/carrier_surface.h"

namespace meanvalue {

/// A vertex of a sheet: where it hangs on its carrier.
struct SheetHold {
    SurfacePlace place;  ///< nearest to it
    Vector3 offset;      ///< from there, at rest
    Index sheet = 0;
};

/// Heights that sheets keep over their carrier, at least: each of their vertices over its place, and the places that
/// cover a vertex of the carrier over that.
class Lift {
  public:
    struct Height {
        SurfacePlace above;  ///< on a sheet
        SurfacePlace below;  ///< on the carrier
        Index sheet = 0;
        double least = 0.0;
        double weight = 0.0;
    };

    Lift() = default;
    /// @param rest n x 3 of the whole mesh; @param size of the carrier; @param own the sheets' vertices, their faces
    /// in their own numbers. @throws Cancelled.
    Lift(const PositionsView& rest, const CarrierSurface& carrier, double size, const PositionsView& own,
         const Triangles& own_faces, const std::vector<SheetHold>& holds, int threads, const Execution& execution);

    /// @param positions n x 3, of which the carrier's are read. @param growth of each sheet. @param encoding with the
    /// rings of `own`, k x 3, which is moved. The same bits for any `threads`. @throws Cancelled.
    void apply(const double* positions, const std::vector<Vector3>& normals, const std::vector<double>& growth,
               const Encoding& encoding, int threads, const Execution& execution, Positions& own) const;

    const std::vector<Height>& heights() const { return heights_; }

  private:
    struct Use {  // a height that a vertex is above
        Index height;
        double weight;
    };

    std::vector<Height> heights_;
    Grouped<Use> uses_;
};

}  // namespace meanvalue
