#include <algorithm>

#include "meanvalue/common/parallel.h"
#include "meanvalue/decode/fast/deformation_energy.h"

namespace meanvalue {
namespace {

/// Where a free vertex is in a ring: its row, and its place.
struct RingUse {
    Index row;
    Index place;
};

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

class HessianAssembly {
  public:
    HessianAssembly(const Encoding& encoding, const Unknowns& unknowns, const EnergyBlockes& energy, double weight,
                    const Execution& execution)
        : encoding_(encoding), unknowns_(unknowns), energy_(energy), weight_(weight), execution_(execution) {
        row_start_.reserve(unknowns_.rows.size() + 1);
        row_start_.push_back(0);
        for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
            row_start_.push_back(row_start_.back() + encoding_.ring_of(unknowns_.rows[row]).valence);
        }
        slots_.reserve(row_start_.back());
        for (const Index row : unknowns_.rows) {
            const EncodedRing ring = encoding_.ring_of(row);
            for (Index k = 0; k < ring.valence; ++k)
                slots_.push_back(unknowns_.slot[ring.ring[k]]);
        }
        edges_.assign(row_start_.back(), {0.0, 0.0});
        if (weight_ > 0.0) collect_edges();
        for (const HessianSpring& spoke : energy_.hessian_springs)
            edges_[row_start_[spoke.row] + spoke.place].spoke += spoke.stiffness;
    }

    /// Before the first columns().
    void index_uses() {
        use_start_.assign(unknowns_.free.size() + 1, 0);
        own_row_.assign(unknowns_.free.size(), -1);
        const auto for_each_use = [&](const auto& visit) {
            for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
                execution_.check_every(row);
                for (std::int64_t k = row_start_[row]; k < row_start_[row + 1]; ++k) {
                    if (slots_[k] >= 0)
                        visit(slots_[k], RingUse{static_cast<Index>(row), static_cast<Index>(k - row_start_[row])});
                }
            }
        };
        for_each_use([&](Index slot, const RingUse&) { ++use_start_[slot + 1]; });
        for (std::size_t slot = 0; slot < unknowns_.free.size(); ++slot) {
            use_start_[slot + 1] += use_start_[slot];
        }
        uses_.resize(use_start_.back());
        execution_.check();
        std::vector<std::int64_t> next(use_start_.begin(), use_start_.end() - 1);
        for_each_use([&](Index slot, const RingUse& use) { uses_[next[slot]++] = use; });
        execution_.check();
        for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
            const Index slot = unknowns_.slot[unknowns_.rows[row]];
            if (slot >= 0) own_row_[slot] = static_cast<Index>(row);
        }
    }

    /// Of one thread.
    struct Scratch {
        explicit Scratch(std::size_t size) : sums(size + 1), seen_by(size + 1, -1), found(size + 1) {}
        std::vector<double> sums;    // |V'| + 1, from slot -1 on: what is fixed goes there
        std::vector<Index> seen_by;  // the same: the column that a sum is of
        std::vector<Index> found;    // room for all of a column, and one
    };

    /// Columns [begin, end), lower triangle with the diagonal. @param sizes receives the number of entries of each.
    Columns columns(Index begin, Index end, std::int64_t* sizes, Scratch& scratch) const {
        Columns result;
        constexpr std::size_t kUsualColumn = 24;
        result.rows.reserve(kUsualColumn * (end - begin));
        result.values.reserve(kUsualColumn * (end - begin));
        double* const sums = scratch.sums.data() + 1;
        Index* const seen_by = scratch.seen_by.data() + 1;
        Index* const found = scratch.found.data();
        for (Index column = begin; column < end; ++column) {
            execution_.check_every(column - begin);
            std::ptrdiff_t count = 0;
            // Without a branch, none of which could be foreseen. What is fixed, or above the diagonal, is not found.
            const auto add = [&](Index slot, double value) {
                const bool is_new = seen_by[slot] != column;
                seen_by[slot] = column;
                sums[slot] = (is_new ? 0.0 : sums[slot]) + value;
                found[count] = slot;
                count += static_cast<int>(is_new) & static_cast<int>(slot >= column);
            };
            add(column, 0.0);
            add_uses(column, add);
            std::sort(found, found + count);
            for (std::ptrdiff_t k = 0; k < count; ++k) {
                result.rows.push_back(found[k]);
                result.values.push_back(sums[found[k]]);
            }
            sizes[column - begin] = count;
        }
        return result;
    }

    /// Calls add(free slot, fixed vertex, value) for all that rows with both give to their pairs.
    template <typename Add>
    void couple_fixed(const Add& add) const {
        const auto add_pair = [&](Index a, Index b, double value) {
            const Index slot_a = unknowns_.slot[a];
            const Index slot_b = unknowns_.slot[b];
            if (slot_a >= 0 && slot_b < 0) add(slot_a, b, value);
            if (slot_b >= 0 && slot_a < 0) add(slot_b, a, value);
        };
        struct Member {
            Index vertex;
            double coefficient;  // in (I - W)
        };
        std::vector<Member> free;
        std::vector<Member> fixed;
        for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
            execution_.check_every(row);
            const Index centre = unknowns_.rows[row];
            const Index* const slots = slots_.data() + row_start_[row];
            const EncodedRing ring = encoding_.ring_of(centre);
            const auto is_fixed = [](Index slot) { return slot < 0; };
            if (unknowns_.slot[centre] >= 0 && std::none_of(slots, slots + ring.valence, is_fixed)) continue;
            free.clear();
            fixed.clear();
            const auto note = [&](Index vertex, double coefficient) {
                (unknowns_.slot[vertex] < 0 ? fixed : free).push_back({vertex, coefficient});
            };
            note(centre, 1.0);
            for (Index k = 0; k < ring.valence; ++k)
                note(ring.ring[k], -ring.weights[k]);
            for (const Member& a : free) {
                execution_.check();
                for (const Member& b : fixed)
                    add_pair(a.vertex, b.vertex, energy_.bending[row] * a.coefficient * b.coefficient);
            }
            for (Index k = 0; k < ring.valence; ++k) {
                const EdgeWeights& edge = edges_[row_start_[row] + k];
                add_pair(centre, ring.ring[k], -edge.spoke);
                add_pair(ring.ring[k], ring.ring[k + 1 == ring.valence ? 0 : k + 1], -edge.rim);
            }
        }
    }

  private:
    /// Calls add(slot or -1, value) for all that the rows with this free vertex give to its column.
    template <typename Add>
    void add_uses(Index column, const Add& add) const {
        const auto slots_of = [&](Index row) { return slots_.data() + row_start_[row]; };
        // One row of (I - W), in which this column has the coefficient `own`.
        const auto add_bending = [&](Index row, const EncodedRing& ring, double own) {
            const double scaled = energy_.bending[row] * own;
            const Index* const slots = slots_of(row);
            add(unknowns_.slot[unknowns_.rows[row]], scaled);
            for (Index k = 0; k < ring.valence; ++k)
                add(slots[k], -scaled * ring.weights[k]);
        };
        const auto add_edge = [&](Index other_slot, double edge_weight) {
            if (edge_weight == 0.0) return;
            add(column, edge_weight);
            add(other_slot, -edge_weight);
        };
        if (own_row_[column] >= 0) {
            const Index row = own_row_[column];
            const EncodedRing ring = encoding_.ring_of(unknowns_.rows[row]);
            add_bending(row, ring, 1.0);
            for (Index k = 0; k < ring.valence; ++k)
                add_edge(slots_of(row)[k], edges_[row_start_[row] + k].spoke);
        }
        for (std::int64_t use = use_start_[column]; use < use_start_[column + 1]; ++use) {
            const Index row = uses_[use].row;
            const Index place = uses_[use].place;
            const EncodedRing ring = encoding_.ring_of(unknowns_.rows[row]);
            add_bending(row, ring, -ring.weights[place]);
            const EdgeWeights* const edges = edges_.data() + row_start_[row];
            const Index* const slots = slots_of(row);
            const Index next = place + 1 == ring.valence ? 0 : place + 1;
            const Index previous = place == 0 ? ring.valence - 1 : place - 1;
            add_edge(unknowns_.slot[unknowns_.rows[row]], edges[place].spoke);
            add_edge(slots[next], edges[place].rim);
            add_edge(slots[previous], edges[previous].rim);
        }
    }

    /// From the order of the batches into that of the rows.
    void collect_edges() {
        execution_.check();
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
    const EnergyBlockes& energy_;
    double weight_;
    const Execution& execution_;
    std::vector<std::int64_t> row_start_;  // |rows| + 1: where a row's edges begin
    std::vector<Index> slots_;             // of the vertices in rings, or -1; as edges_
    std::vector<EdgeWeights> edges_;
    std::vector<std::int64_t> use_start_;  // |V'| + 1
    std::vector<RingUse> uses_;
    std::vector<Index> own_row_;  // |V'|: or -1
};

}  // namespace

SparseMatrix DeformationEnergy::initial_hessian(double rigidity, int threads, const Execution& execution) const {
    // Found and copied in parts: looks come between them, and none is so large that it is slow to grow or to free.
    constexpr Index kColumnsOfPart = 2048;
    const auto size = static_cast<Index>(unknowns_.free.size());
    HessianAssembly assembly(encoding_, unknowns_, rows_, rigidity * rows_.stretching, execution);
    assembly.index_uses();
    const Index part_count = (size + kColumnsOfPart - 1) / kColumnsOfPart;
    const int workers = std::max(1, std::min<int>(threads, part_count));
    const auto for_each_part = [&](int worker, const auto& visit) {
        const auto first_of = [&](int k) { return static_cast<Index>(std::int64_t{part_count} * k / workers); };
        for (Index part = first_of(worker); part < first_of(worker + 1); ++part) {
            execution.check();
            visit(part, part * kColumnsOfPart, std::min(size, (part + 1) * kColumnsOfPart));
        }
    };
    SparseMatrix hessian(size, size);
    std::int64_t* const starts = hessian.outerIndexPtr();
    std::vector<Columns> parts(part_count);
    run_workers(workers, [&](int worker) {
        HessianAssembly::Scratch scratch(unknowns_.free.size());
        for_each_part(worker, [&](Index part, Index begin, Index end) {
            parts[part] = assembly.columns(begin, end, starts + begin + 1, scratch);
        });
    });
    starts[0] = 0;
    for (Index column = 0; column < size; ++column) {
        starts[column + 1] += starts[column];
    }
    hessian.resizeNonZeros(starts[size]);
    run_workers(workers, [&](int worker) {
        for_each_part(worker, [&](Index part, Index begin, Index) {
            const Columns columns = std::move(parts[part]);
            std::copy(columns.rows.begin(), columns.rows.end(), hessian.innerIndexPtr() + starts[begin]);
            std::copy(columns.values.begin(), columns.values.end(), hessian.valuePtr() + starts[begin]);
        });
    });
    soft_constraints_.add_hessian(hessian);
    return hessian;
}

FixedCoupling DeformationEnergy::fixed_coupling(double rigidity, const Execution& execution) const {
    const HessianAssembly assembly(encoding_, unknowns_, rows_, rigidity * rows_.stretching, execution);
    FixedCoupling coupling;
    std::vector<Index> column_of(unknowns_.slot.size(), -1);
    assembly.couple_fixed([&](Index, Index vertex, double) { column_of[vertex] = 0; });
    for (std::size_t v = 0; v < column_of.size(); ++v) {
        if (column_of[v] < 0) continue;
        column_of[v] = static_cast<Index>(coupling.vertices.size());
        coupling.vertices.push_back(static_cast<Index>(v));
    }
    std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries;
    assembly.couple_fixed(
        [&](Index slot, Index vertex, double value) { entries.emplace_back(slot, column_of[vertex], value); });
    coupling.matrix.resize(static_cast<Eigen::Index>(unknowns_.free.size()),
                           static_cast<Eigen::Index>(coupling.vertices.size()));
    coupling.matrix.setFromTriplets(entries.begin(), entries.end());
    return coupling;
}

}  // namespace meanvalue
