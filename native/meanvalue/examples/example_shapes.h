// The examples of a region: what all levels of the mesh share of them.
#pragma once

#include <vector>

#include "meanvalue/common/shared_arrays.h"
#include "meanvalue/examples/example_space.h"
#include "meanvalue/examples/surface_functions.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue {

struct ExampleShapes {
    /// @param encoding, region of the rest shape. @param examples of the whole mesh. @pre encoding outlives it.
    /// @throws Cancelled.
    ExampleShapes(const Encoding& encoding, const Region& region, const std::vector<SharedPositions>& examples,
                  int threads, const Execution& execution)
        : shapes(of_region(region, examples, execution)),
          functions(encoding, region.positions, execution),
          whole(encoding, functions, region.positions, shapes, threads, execution) {}

    std::vector<Positions> shapes;  ///< of the region's vertices
    SurfaceFunctions functions;
    ExampleSpace whole;  ///< on the whole mesh

  private:
    static std::vector<Positions> of_region(const Region& region, const std::vector<SharedPositions>& examples,
                                            const Execution& execution) {
        std::vector<Positions> shapes;
        for (const SharedPositions& example : examples) {
            execution.check();
            shapes.push_back((*example)(region.vertices, Eigen::all));
        }
        return shapes;
    }
};

}  // namespace meanvalue
