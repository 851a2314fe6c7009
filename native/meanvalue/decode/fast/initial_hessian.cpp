// DeformationEnergy::initial_hessian(), column by column.
#include <algorithm>
#include <numeric>
#include <optional>

#include "meanvalue/common/parallel.h"
#include "meanvalue/decode/fast/deformation_energy.h"

namespace meanvalue {
namespace {

/// What one place in a ring gives to the matrix: of its spoke, and of the rim to the next.
struct EdgeWeights {
    double spoke;
    double rim;
};

/// Entries of some consecutive columns, one column after another.
struct Columns {
    std::vector<Index> rows;
    std::vector<double> values;
};

/// The columns of the initial Hessian, those of fixed vertices among them, in the rows of the free ones.
class HessianColumns {
  public:
    HessianColumns(const Encoding& encoding, const Unknowns& unknowns, const EnergyBlocks& energy, double weight,
                   const Execution& execution)
        : encoding_(encoding), unknowns_(unknowns), energy_(energy), weight_(weight), execution_(execution) {
        row_start_.reserve(unknowns_.rows.size() + 1);
        row_start_.push_back(0);
        for (const Index row : unknowns_.rows)
            row_start_.push_back(row_start_.back() + encoding_.ring_of(row).valence);
        numbers_.reserve(row_start_.back());
        for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
            const EncodedRing ring = encoding_.ring_of(unknowns_.rows[row]);
            for (Index k = 0; k < ring.valence; ++k)
                numbers_.push_back(unknowns_.number[ring.ring[k]]);
        }
        execution_.check();
        edges_.assign(row_start_.back(), {0.0, 0.0});
        if (weight_ > 0.0) collect_edges();
        for (const HessianSpring& spring : energy_.hessian_springs)
            edges_[row_start_[spring.row] + spring.place].spoke += spring.stiffness;
        execution_.check();
        uses_ = uses_of(encoding_, unknowns_, execution_);
        own_row_.assign(unknowns_.number.size(), -1);
        for (std::size_t row = 0; row < unknowns_.rows.size(); ++row)
            own_row_[unknowns_.rows[row]] = static_cast<Index>(row);
    }

    /// The fixed vertices that rows depend on, ascending.
    std::vector<Index> fixed_vertices() const {
        std::vector<Index> result;
        for (Index v = 0; v < static_cast<Index>(unknowns_.number.size()); ++v) {
            const bool is_used = own_row_[v] >= 0 || !uses_.of(v).empty();
            if (is_used && unknowns_.number[v] < 0) result.push_back(v);
        }
        return result;
    }

    /// What one thread writes.
    struct Scratch {
        explicit Scratch(std::size_t size) : sums(size + 1), seen_by(size + 1, -1), found(size + 1) {}
        std::vector<double> sums;    // |V'| + 1, from number -1 on: what is fixed goes there
        std::vector<Index> seen_by;  // the same: the vertex whose column a sum is of
        std::vector<Index> found;    // room for all of a column, and one
    };

    /// The columns of `vertices` [begin, end): of a free one the entries from the diagonal down, of a fixed one all.
    /// @param sizes receives the number of entries of each.
    Columns columns(const std::vector<Index>& vertices, Index begin, Index end, std::int64_t* sizes,
                    Scratch& scratch) const {
        Columns result;
        constexpr std::size_t kUsualColumn = 24;
        result.rows.reserve(kUsualColumn * (end - begin));
        result.values.reserve(kUsualColumn * (end - begin));
        double* const sums = scratch.sums.data() + 1;
        Index* const seen_by = scratch.seen_by.data() + 1;
        Index* const found = scratch.found.data();
        for (Index column = begin; column < end; ++column) {
            const Index vertex = vertices[column];
            const Index own = unknowns_.number[vertex];
            const Index first = std::max<Index>(own, 0);
            std::ptrdiff_t count = 0;
            // Without a branch, none of which could be foreseen. What is fixed, or above the diagonal, is not found.
            const auto add = [&](Index number, double value) {
                const bool is_new = seen_by[number] != vertex;
                seen_by[number] = vertex;
                sums[number] = (is_new ? 0.0 : sums[number]) + value;
                found[count] = number;
                count += static_cast<int>(is_new) & static_cast<int>(number >= first);
            };
            add(own, 0.0);
            add_uses(vertex, add);
            std::sort(found, found + count);
            for (std::ptrdiff_t k = 0; k < count; ++k) {
                result.rows.push_back(found[k]);
                result.values.push_back(sums[found[k]]);
            }
            sizes[column - begin] = count;
        }
        return result;
    }

  private:
    /// Calls add(number or -1, value) for all that the rows with this vertex give to its column.
    template <typename Add>
    void add_uses(Index vertex, const Add& add) const {
        const auto numbers_of = [&](Index row) { return numbers_.data() + row_start_[row]; };
        // One row of (I - W), in which this column has the coefficient `own`.
        const auto add_bending = [&](Index row, const EncodedRing& ring, double own) {
            const double scaled = energy_.bending[row] * own;
            const Index* const numbers = numbers_of(row);
            add(unknowns_.number[unknowns_.rows[row]], scaled);
            for (Index k = 0; k < ring.valence; ++k)
                add(numbers[k], -scaled * ring.weights[k]);
        };
        const auto add_edge = [&](Index other_number, double edge_weight) {
            if (edge_weight == 0.0) return;
            add(unknowns_.number[vertex], edge_weight);
            add(other_number, -edge_weight);
        };
        if (own_row_[vertex] >= 0) {
            const Index row = own_row_[vertex];
            const EncodedRing ring = encoding_.ring_of(vertex);
            add_bending(row, ring, 1.0);
            for (Index k = 0; k < ring.valence; ++k)
                add_edge(numbers_of(row)[k], edges_[row_start_[row] + k].spoke);
        }
        for (const auto [row, place] : uses_.of(vertex)) {
            const EncodedRing ring = encoding_.ring_of(unknowns_.rows[row]);
            add_bending(row, ring, -ring.weights[place]);
            const EdgeWeights* const edges = edges_.data() + row_start_[row];
            const Index* const numbers = numbers_of(row);
            const Index next = place + 1 == ring.valence ? 0 : place + 1;
            const Index previous = place == 0 ? ring.valence - 1 : place - 1;
            add_edge(unknowns_.number[unknowns_.rows[row]], edges[place].spoke);
            add_edge(numbers[next], edges[place].rim);
            add_edge(numbers[previous], edges[previous].rim);
        }
    }

    /// From the order of the batches into that of the rows.
    void collect_edges() {
        for (const RowBatch& batch : energy_.batches) {
            for (int lane = 0; lane < kRowLanes; ++lane) {
                if (batch.row[lane] < 0) continue;
                for (Index k = 0; k < batch.valence; ++k) {
                    const StretchingLanes& from = energy_.stretching_lanes[batch.first + k];
                    edges_[row_start_[batch.row[lane]] + k] = {weight_ * from.spoke.value[lane],
                                                               weight_ * from.rim.value[lane]};
                }
            }
        }
    }

    const Encoding& encoding_;
    const Unknowns& unknowns_;
    const EnergyBlocks& energy_;
    double weight_;
    const Execution& execution_;
    std::vector<std::int64_t> row_start_;  // |rows| + 1: the first place of each row's ring
    std::vector<Index> numbers_;           // of the vertex at each place, or -1
    std::vector<EdgeWeights> edges_;       // of each place
    Grouped<Use> uses_;                    // n: the places that each vertex is at
    std::vector<Index> own_row_;           // n: or -1
};

/// The columns of `vertices` as a matrix with |V'| rows.
SparseMatrix matrix_of(const HessianColumns& columns, const std::vector<Index>& vertices, std::size_t row_count,
                       int threads, const Execution& execution) {
    // Found and copied in parts, none of which is so large that it is slow to grow or to free.
    const auto size = static_cast<Index>(vertices.size());
    SparseMatrix matrix(static_cast<Eigen::Index>(row_count), size);
    std::int64_t* const starts = matrix.outerIndexPtr();
    std::vector<Columns> parts(piece_count(size));
    std::vector<std::optional<HessianColumns::Scratch>> scratch(std::max(1, threads));
    parallel_items(parts.size(), threads, execution, [&](int worker, std::size_t part) {
        if (!scratch[worker]) scratch[worker].emplace(row_count);
        const auto begin = static_cast<Index>(part) * kPiece;
        parts[part] =
            columns.columns(vertices, begin, std::min(size, begin + kPiece), starts + begin + 1, *scratch[worker]);
    });
    starts[0] = 0;
    std::partial_sum(starts, starts + size + 1, starts);
    matrix.resizeNonZeros(starts[size]);
    parallel_pieces(size, threads, execution, [&](Index part, Index begin, Index) {
        const Columns found = std::move(parts[part]);
        std::copy(found.rows.begin(), found.rows.end(), matrix.innerIndexPtr() + starts[begin]);
        std::copy(found.values.begin(), found.values.end(), matrix.valuePtr() + starts[begin]);
    });
    return matrix;
}

}  // namespace

InitialHessian DeformationEnergy::initial_hessian(double rigidity, int threads, const Execution& execution) const {
    const HessianColumns columns(encoding_, unknowns_, rows_, rigidity * rows_.stretching, execution);
    InitialHessian hessian;
    hessian.matrix = matrix_of(columns, unknowns_.free, unknowns_.free.size(), threads, execution);
    soft_constraints_.add_hessian(hessian.matrix);
    hessian.coupling.vertices = columns.fixed_vertices();
    hessian.coupling.matrix =
        matrix_of(columns, hessian.coupling.vertices, unknowns_.free.size(), threads, execution);
    return hessian;
}

}  // namespace meanvalue
