// Shapes that a mesh is known to take: how they bend each cell, and which blend of them a given shape is most like.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/shared_arrays.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/rest_cells.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue {

/// Smooth functions over a surface that sum to one: what weights that vary slowly over a mesh are made of. Bells of
/// the distance along edges from vertices far from each other, divided by their sum.
struct SurfaceFunctions {
    struct Value {
        Index function;
        double value;
    };

    /// @param layout the rings, n. @param positions n x 3. @throws Cancelled. Cost: that of sorting, for each
    /// function.
    SurfaceFunctions(const Encoding& layout, const PositionsView& positions, const Execution& execution);

    Index count = 0;
    Grouped<Value> values;  ///< of each vertex, those that are not 0
};

/// What each example counts by each function of SurfaceFunctions, functions x e. The rest shape counts what is
/// missing to one.
using ExampleWeights = Eigen::MatrixXd;

/// Examples are blended cell by cell: of each half-edge the edge in the frame of its cell, and its coefficients of
/// the encoding. Weights are fitted to the edges alone (Froehlich and Botsch 2011, with one rotation a cell; Wampler
/// 2016 for weights that vary over the surface). docs/algorithm.md, "Examples".
class ExampleSpace {
  public:
    /// @param rest the encoding of the rest shape on a level of the mesh. @param functions over the mesh.
    /// @param positions n x 3, the rest shape; @param shapes e examples. @pre rest and functions outlive it.
    /// @throws Cancelled. Cost: e^2 times linear, and the cube of e: 200 examples take seconds.
    ExampleSpace(const Encoding& rest, const SurfaceFunctions& functions, const PositionsView& positions,
                 const std::vector<Positions>& shapes, int threads, const Execution& execution);

    Index count() const { return count_; }  ///< e

    /// The weights by which the blend is most like `shape`, n x 3. Small ones are preferred, and ones that vary
    /// little. The same bits for any `threads`. @throws Cancelled.
    ExampleWeights fit(const PositionsView& shape, int threads, const Execution& execution) const;

    /// @param encoding, cells of the layout; receive the blend. The same bits for any `threads`. @throws Cancelled.
    void blend(const ExampleWeights& weights, int threads, const Execution& execution, Encoding& encoding,
               RestCells& cells) const;

    /// What the rest shape and each example count at a vertex, e + 1 numbers that sum to one.
    void weights_at(Index vertex, const ExampleWeights& weights, double* shares) const;

  private:
    /// What an example has in place of what the rest shape has, of a half-edge.
    struct Difference {
        float edge[3];
        float weight;
        float height;
    };

    const Difference* differences_of(std::size_t half_edge) const { return differences_.data() + half_edge * count_; }
    void measure(std::size_t example, const PositionsView& shape, int threads, const Execution& execution);
    void factorise(const Execution& execution);
    void find_shares(Index vertex, const ExampleWeights& weights, Eigen::VectorXd& shares) const;

    const Encoding& rest_;
    Index count_;
    const SurfaceFunctions& functions_;
    RestCells cells_;                      // of the rest shape
    std::vector<double> cell_weights_;     // |ring|: what each edge counts
    std::vector<Difference> differences_;  // |ring| x e
    std::vector<float> softening_;         // n x e: differences
    std::vector<Index> sample_;            // the vertices that weights are fitted to
    // Of the normal matrix of all weights, (functions x e)^2. By LLT its bits would be the processor's.
    Eigen::LDLT<Eigen::MatrixXd> factor_;
};

/// The examples of a region: what all levels of the mesh share of them.
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
