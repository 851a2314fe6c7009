#include "meanvalue/decode/fast/energy_blocks.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/encoding/projection_plane.h"

namespace meanvalue {
namespace {

// How many times the row of an isolated anchor counts, a fixed vertex whose ring is free: the surface passes through
// it with the curvature that it had, instead of hanging from it like a tent. Its neighbors' rows must not count more:
// limbs rotate about their anchors. docs/decisions/0007-rigidity.md has what was measured.
constexpr double kIsolatedAnchorWeight = 70.0;

// Rings with a smaller sum of norms, see hessian_springs(), have no springs; what is above counts by the share,
// since the bound is generous: signs differ. docs/decisions/0011-constant-matrix.md.
constexpr double kLeastStiffness = 0.4;
constexpr double kShareOfBound = 0.3;
// A sum counts as no more than this: the factor in single precision must still resolve what such springs leave free.
constexpr double kMostStiffness = 100.0;

/// A weight to the power of the share of all weights that counts.
double share_of(double weight, double by_length) {
    return by_length == 1.0 ? weight : power(weight, by_length);
}

/// What a cell has at rest into one lane of a batch.
void fill_cell(const EncodedRing& ring, const Vector3* edges, int lane, RowBatch& batch, EnergyBlocks& blocks) {
    batch.softening.value[lane] = ring.softening;
    for (Index k = 0; k < ring.valence; ++k) {
        const std::size_t place = batch.first + k;
        blocks.bending_lanes[place].weight.value[lane] = ring.weights[k];
        blocks.bending_lanes[place].height.value[lane] = ring.heights[k];
        EdgeLanes& edge = blocks.edge_lanes[place];
        edge.x.value[lane] = edges[k].x();
        edge.y.value[lane] = edges[k].y();
        edge.z.value[lane] = edges[k].z();
        if (ring.normal_weights != nullptr) {
            blocks.steep_lanes[batch.first_steep + k].value[lane] =
                kSteepScale * (ring.normal_weights[k] - ring.weights[k]);
        }
    }
}

class BlockBuilder {
  public:
    BlockBuilder(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells, double size,
                 double by_length, const std::vector<double>& stiffness, EnergyBlocks& result)
        : encoding_(encoding),
          unknowns_(unknowns),
          cells_(cells),
          size_(size),
          by_length_(by_length),
          stiffness_(stiffness),
          result_(result),
          point_of_(unknowns.number.size(), -1) {
        result_.bending.resize(unknowns_.rows.size());
    }

    void build(const Execution& execution) {
        const std::size_t count = unknowns_.rows.size();
        for (std::size_t begin = 0; begin < count; begin += std::size_t{kPiece}) {
            execution.check();
            add_batches(begin, std::min(begin + std::size_t{kPiece}, count));
        }
        result_.blocks.push_back({0, static_cast<std::int64_t>(result_.batches.size())});
        result_.batches.shrink_to_fit();
        // So that nothing is copied as it grows.
        result_.bending_lanes.reserve(place_count_);
        result_.stretching_lanes.reserve(place_count_);
        result_.edge_lanes.reserve(place_count_);
        result_.vertex_lanes.reserve(place_count_);
        result_.points.reserve(count + count / 4);
        for (std::size_t block = 0; block < result_.block_count(); ++block) {
            execution.check();
            fill_block(block);
        }
        result_.blocks.back().first_point = static_cast<std::int64_t>(result_.points.size());
        result_.points.shrink_to_fit();
    }

  private:
    EncodedRing ring_of(std::size_t row) const { return encoding_.ring_of(unknowns_.rows[row]); }

    /// Rows [begin, end) as one block: batches in ascending valence, steep ones last, each with rows in ascending
    /// order.
    void add_batches(std::size_t begin, std::size_t end) {
        result_.blocks.push_back({0, static_cast<std::int64_t>(result_.batches.size())});
        const auto kind = [&](std::size_t row) {
            const EncodedRing ring = ring_of(row);
            return std::make_pair(ring.normal_weights != nullptr, ring.valence);
        };
        std::vector<std::size_t> rows(end - begin);
        std::iota(rows.begin(), rows.end(), begin);
        std::stable_sort(rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) { return kind(a) < kind(b); });
        for (std::size_t k = 0; k < rows.size();) {
            const auto of_batch = kind(rows[k]);
            const auto [is_steep, valence] = of_batch;
            RowBatch batch{};
            batch.valence = valence;
            batch.first = place_count_;
            batch.first_steep = is_steep ? steep_count_ : -1;
            place_count_ += valence;
            if (is_steep) steep_count_ += valence;
            int lane = 0;
            for (; lane < kRowLanes && k < rows.size() && kind(rows[k]) == of_batch; ++lane)
                batch.row[lane] = static_cast<Index>(rows[k++]);
            std::fill(batch.row + lane, batch.row + kRowLanes, -1);
            result_.batches.push_back(batch);
            result_.longest_ring = std::max(result_.longest_ring, valence);
        }
    }

    void fill_block(std::size_t block) {
        const std::size_t first_point = result_.points.size();
        result_.blocks[block].first_point = static_cast<std::int64_t>(first_point);
        const std::size_t begin = block * std::size_t{kPiece};
        number_points(first_point, begin, std::min(begin + std::size_t{kPiece}, unknowns_.rows.size()));
        for (auto batch = result_.blocks[block].first_batch; batch < result_.blocks[block + 1].first_batch; ++batch)
            fill_batch(result_.batches[batch]);
        for (std::size_t k = first_point; k < result_.points.size(); ++k)
            point_of_[result_.points[k]] = -1;
    }

    /// The points of rows [begin, end) in the order of the vertices, so that copies run forwards through memory.
    void number_points(std::size_t first_point, std::size_t begin, std::size_t end) {
        const auto note = [&](Index vertex) {
            if (point_of_[vertex] >= 0) return;
            point_of_[vertex] = 0;
            result_.points.push_back(vertex);
        };
        for (std::size_t row = begin; row < end; ++row) {
            const EncodedRing ring = ring_of(row);
            note(unknowns_.rows[row]);
            std::for_each(ring.ring, ring.ring + ring.valence, note);
        }
        const auto first = result_.points.begin() + static_cast<std::ptrdiff_t>(first_point);
        std::sort(first, result_.points.end());
        for (auto vertex = first; vertex != result_.points.end(); ++vertex)
            point_of_[*vertex] = static_cast<Index>(vertex - first);
        result_.largest_block = std::max(result_.largest_block, static_cast<Index>(result_.points.end() - first));
    }

    void fill_batch(RowBatch& batch) {
        const std::size_t places = batch.first + batch.valence;
        result_.bending_lanes.resize(places);
        result_.stretching_lanes.resize(places);
        result_.edge_lanes.resize(places);
        result_.vertex_lanes.resize(places);
        if (batch.first_steep >= 0) result_.steep_lanes.resize(batch.first_steep + batch.valence);
        for (int lane = 0; lane < kRowLanes; ++lane) {
            const bool is_left_over = batch.row[lane] < 0;
            fill_lane(batch, lane, batch.row[is_left_over ? 0 : lane], is_left_over ? 0.0 : 1.0);
        }
    }

    /// @param count 0 for a lane that is left over, else 1.
    void fill_lane(RowBatch& batch, int lane, std::size_t row, double count) {
        const EncodedRing ring = ring_of(row);
        spokes_.resize(ring.valence);
        measure(row, ring);
        batch.centre[lane] = point_of_[unknowns_.rows[row]];
        for (Index k = 0; k < ring.valence; ++k) {
            const std::size_t place = batch.first + k;
            result_.vertex_lanes[place].vertex[lane] = point_of_[ring.ring[k]];
            result_.stretching_lanes[place].spoke.value[lane] = count * spokes_[k].spoke;
            result_.stretching_lanes[place].rim.value[lane] = count * spokes_[k].rim;
        }
        fill_cell(ring, cells_.edges.data() + encoding_.ring_offsets[unknowns_.rows[row]], lane, batch, result_);
    }

    /// The spokes of a row, by its rigidity and stiffness, and 1 / h_i^2 into its bending.
    void measure(std::size_t row, const EncodedRing& ring) {
        const Vector3* const edges = cells_.edges.data() + encoding_.ring_offsets[unknowns_.rows[row]];
        // Not zero: weights stay finite where vertices coincide.
        const double length = std::max(measure_spokes(edges, ring.valence, spokes_.data()), kNegligible * size_);
        result_.bending[row] = 1.0 / (length * length);
        double rigidity = stiffness_.empty() ? 1.0 : stiffness_[unknowns_.rows[row]];
        if (by_length_ > 0.0) rigidity *= share_of(rigidity_of_cell(edges, ring.valence, size_), by_length_);
        for (Spoke& spoke : spokes_) {
            spoke.spoke *= rigidity;
            spoke.rim *= rigidity;
        }
    }

    const Encoding& encoding_;
    const Unknowns& unknowns_;
    const RestCells& cells_;
    double size_;
    double by_length_;
    const std::vector<double>& stiffness_;  // n, or empty
    EnergyBlocks& result_;
    std::int64_t place_count_ = 0;
    std::int64_t steep_count_ = 0;
    std::vector<Spoke> spokes_;    // of one row
    std::vector<Index> point_of_;  // n: in the current block, or -1
};

/// How much a row is that of an anchor without neighbors that are anchors: 0 or 1 where all are hard, and 0 in the
/// middle of a handle of even strength, whatever that is.
double isolation(const Encoding& encoding, const Unknowns& unknowns, const std::vector<double>& hardness,
                 Index vertex) {
    const auto hardness_of = [&](Index v) {
        if (unknowns.number[v] < 0) return 1.0;
        return hardness.empty() ? 0.0 : hardness[v];
    };
    double excess = hardness_of(vertex);
    const EncodedRing ring = encoding.ring_of(vertex);
    for (Index k = 0; k < ring.valence && excess > 0.0; ++k)
        excess -= hardness_of(ring.ring[k]);
    return std::max(0.0, excess);
}

/// From 1 / h_i^2 to a_i, once all are known.
void scale_weights(const Encoding& encoding, const Unknowns& unknowns, double size, double by_length,
                   const std::vector<double>& hardness, EnergyBlocks& rows) {
    if (rows.bending.empty()) return;
    const double inverse_squares = std::accumulate(rows.bending.begin(), rows.bending.end(), 0.0);
    const double square = static_cast<double>(rows.bending.size()) / inverse_squares;
    for (std::size_t row = 0; row < rows.bending.size(); ++row) {
        const double isolated = isolation(encoding, unknowns, hardness, unknowns.rows[row]);
        const double full = rows.bending[row] * square * (1.0 + (kIsolatedAnchorWeight - 1.0) * isolated);
        rows.bending[row] = share_of(full, by_length);
    }
    rows.stretching = square / (size * size);
    for (RowBatch& batch : rows.batches) {
        for (int lane = 0; lane < kRowLanes; ++lane)
            batch.bending.value[lane] = batch.row[lane] < 0 ? 0.0 : rows.bending[batch.row[lane]];
    }
}

/// Next to sharp tips and in slivers the ring's normal rotates, or lengths change, with every small move. The initial
/// Hessian knows the weights alone, (I - W), and some dozen such rows in a model would shorten every step of the
/// whole. With N_k = dF_i/dv_k - w_k I, which sum to zero, |sum_k N_k (u_k - u_i)|^2 <= (sum_k |N_k|) sum_k |N_k|
/// |u_k - u_i|^2: as many springs along the spokes. Rows with a small sum have none: they would only resist rotation.
std::vector<HessianSpring> hessian_springs(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells,
                                           const std::vector<double>& bending, int threads,
                                           const Execution& execution) {
    const auto count = static_cast<Index>(unknowns.rows.size());
    std::vector<std::vector<HessianSpring>> of_pieces(piece_count(count));
    parallel_pieces(count, threads, execution, [&](Index piece, Index begin, Index end) {
        std::vector<Matrix3> blocks;
        std::vector<Index> numbers;
        for (Index row = begin; row < end; ++row) {
            EncodedRing ring = encoding.ring_of(unknowns.rows[row]);
            const Vector3* const edges = cells.edges.data() + encoding.ring_offsets[unknowns.rows[row]];
            Positions around(ring.valence, 3);  // the vertex: its ring
            for (Index k = 0; k < ring.valence; ++k)
                around.row(k) = -edges[k];
            numbers.resize(ring.valence);
            std::iota(numbers.begin(), numbers.end(), 0);
            ring.ring = numbers.data();
            blocks.resize(ring.valence);
            predict_with_jacobian(ring, around, blocks.data());
            double sum = 0.0;
            for (Index k = 0; k < ring.valence; ++k) {
                blocks[k] -= ring.weights[k] * Matrix3::Identity();
                sum += blocks[k].norm();
            }
            if (!(sum > kLeastStiffness) || !std::isfinite(sum)) continue;
            const double counted = std::min(sum, kMostStiffness);
            const double excess = (counted - kLeastStiffness * kLeastStiffness / counted) * counted / sum;
            for (Index k = 0; k < ring.valence; ++k)
                of_pieces[piece].push_back({row, k, kShareOfBound * bending[row] * excess * blocks[k].norm()});
        }
    });
    std::vector<HessianSpring> springs;
    for (const std::vector<HessianSpring>& of_piece : of_pieces)
        springs.insert(springs.end(), of_piece.begin(), of_piece.end());
    return springs;
}

}  // namespace

EnergyBlocks build_energy_blocks(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells,
                                 double size, double by_length, const std::vector<double>& hardness,
                                 const std::vector<double>& stiffness, int threads, const Execution& execution) {
    EnergyBlocks result;
    BlockBuilder(encoding, unknowns, cells, size, by_length, stiffness, result).build(execution);
    scale_weights(encoding, unknowns, size, by_length, hardness, result);
    result.hessian_springs = hessian_springs(encoding, unknowns, cells, result.bending, threads, execution);
    return result;
}

void refill_energy_blocks(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells, int threads,
                          const Execution& execution, EnergyBlocks& blocks) {
    parallel_items(blocks.block_count(), threads, execution, [&](int, std::size_t block) {
        const auto end = blocks.blocks[block + 1].first_batch;
        for (auto number = blocks.blocks[block].first_batch; number < end; ++number) {
            RowBatch& batch = blocks.batches[number];
            for (int lane = 0; lane < kRowLanes; ++lane) {
                const Index row = batch.row[batch.row[lane] < 0 ? 0 : lane];
                const EncodedRing ring = encoding.ring_of(unknowns.rows[row]);
                const Vector3* const edges = cells.edges.data() + encoding.ring_offsets[unknowns.rows[row]];
                fill_cell(ring, edges, lane, batch, blocks);
            }
        }
    });
}

}  // namespace meanvalue
