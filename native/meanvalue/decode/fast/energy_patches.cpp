#include "meanvalue/decode/fast/energy_patches.h"

#include <algorithm>
#include <array>

#include "meanvalue/common/parallel.h"
#include "meanvalue/decode/fast/row_filler.h"

namespace meanvalue {
namespace {

// How many times the row of a lone anchor counts, a fixed vertex whose ring is free: the surface passes through it
// with the curvature that it had, instead of hanging from it like a tent. Its neighbours' rows must not count more:
// limbs turn about their anchors. docs/decisions/0007-rigidity.md has what was measured.
constexpr double kLoneAnchorWeight = 70.0;

// Rows of a patch: the more, the fewer points are in several patches, and the fewer lanes are left over.
constexpr std::size_t kPatchRows = 2048;

class PatchBuilder {
  public:
    PatchBuilder(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells, double size,
                 double by_length, EnergyPatches& result)
        : encoding_(encoding),
          unknowns_(unknowns),
          result_(result),
          filler_(encoding, unknowns, cells, size, by_length, result),
          point_of_(unknowns.slot.size(), -1) {
        result_.bending.resize(unknowns_.rows.size());
    }

    /// Room for all that add() is going to make, so that nothing is copied as it grows.
    void reserve(bool in_batches, const Execution& execution) {
        std::size_t batches = 0;
        std::size_t lanes = 0;
        std::size_t singles = 0;
        std::size_t spokes = 0;
        for (std::size_t begin = 0; begin < unknowns_.rows.size(); begin += kPatchRows) {
            execution.check();
            std::array<std::size_t, kLongestLaneRing + 1> rows_of{};  // by valence
            for (std::size_t row = begin; row < std::min(begin + kPatchRows, unknowns_.rows.size()); ++row) {
                const EncodedRing ring = ring_of(row);
                if (in_batches && fits_lanes(ring)) {
                    ++rows_of[ring.valence];
                } else {
                    ++singles;
                    spokes += ring.valence;
                }
            }
            for (std::size_t valence = 0; valence < rows_of.size(); ++valence) {
                const std::size_t count = (rows_of[valence] + kRowLanes - 1) / kRowLanes;
                batches += count;
                lanes += count * valence;
            }
        }
        result_.batches.reserve(batches);
        result_.bending_lanes.reserve(lanes);
        result_.stretching_lanes.reserve(lanes);
        result_.edge_lanes.reserve(lanes);
        result_.vertex_lanes.reserve(lanes);
        result_.singles.reserve(singles);
        result_.single_spokes.reserve(spokes);
        result_.single_points.reserve(spokes);
        // Rarely more; the rest is given back.
        result_.points.reserve(unknowns_.rows.size() + unknowns_.rows.size() / 4);
    }

    /// Rows [begin, end): their batches in ascending valence, each with rows in ascending order.
    void add(std::size_t begin, std::size_t end, bool in_batches) {
        begin_patch();
        number_points(begin, end);
        std::vector<std::size_t> taken;
        std::vector<std::size_t> single;
        for (std::size_t row = begin; row < end; ++row) {
            const EncodedRing ring = ring_of(row);
            (in_batches && fits_lanes(ring) ? taken : single).push_back(row);
        }
        std::stable_sort(taken.begin(), taken.end(),
                         [&](std::size_t a, std::size_t b) { return ring_of(a).valence < ring_of(b).valence; });
        for (std::size_t k = 0; k < taken.size();) {
            const Index valence = ring_of(taken[k]).valence;
            int count = 1;
            while (count < kRowLanes && k + count < taken.size() && ring_of(taken[k + count]).valence == valence)
                ++count;
            add_batch(taken.data() + k, count, valence);
            k += count;
        }
        for (const std::size_t row : single)
            add_single(row);
        forget_points();
    }

    void begin_patch() {
        first_point_ = result_.points.size();
        result_.patches.push_back({static_cast<std::int64_t>(result_.points.size()),
                                   static_cast<std::int64_t>(result_.batches.size()),
                                   static_cast<std::int64_t>(result_.singles.size())});
    }

  private:
    EncodedRing ring_of(std::size_t row) const { return encoding_.ring_of(unknowns_.rows[row]); }
    static bool fits_lanes(const EncodedRing& ring) {
        return ring.normal_weights == nullptr && ring.valence <= kLongestLaneRing;
    }

    /// The points of rows [begin, end) in the order of the vertices, so that copies run forwards through memory.
    void number_points(std::size_t begin, std::size_t end) {
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
        const auto first = result_.points.begin() + static_cast<std::ptrdiff_t>(first_point_);
        std::sort(first, result_.points.end());
        for (auto vertex = first; vertex != result_.points.end(); ++vertex)
            point_of_[*vertex] = static_cast<Index>(vertex - first);
        result_.largest_patch = std::max(result_.largest_patch, static_cast<Index>(result_.points.end() - first));
    }

    void forget_points() {
        for (std::size_t k = first_point_; k < result_.points.size(); ++k)
            point_of_[result_.points[k]] = -1;
    }

    void add_batch(const std::size_t* rows, int count, Index valence) {
        RowBatch batch{};
        batch.valence = valence;
        batch.first = static_cast<std::int64_t>(result_.vertex_lanes.size());
        result_.vertex_lanes.resize(batch.first + valence);
        result_.bending_lanes.resize(batch.first + valence);
        result_.stretching_lanes.resize(batch.first + valence);
        result_.edge_lanes.resize(batch.first + valence);
        for (int lane = 0; lane < kRowLanes; ++lane) {
            const bool left_over = lane >= count;
            const std::size_t row = rows[left_over ? 0 : lane];
            const EncodedRing ring = ring_of(row);
            batch.row[lane] = left_over ? -1 : static_cast<Index>(row);
            batch.centre[lane] = point_of_[unknowns_.rows[row]];
            for (Index k = 0; k < valence; ++k)
                result_.vertex_lanes[batch.first + k].vertex[lane] = point_of_[ring.ring[k]];
        }
        filler_.fill(batch);
        result_.batches.push_back(batch);
    }

    void add_single(std::size_t row) {
        const EncodedRing ring = ring_of(row);
        const std::size_t first = result_.single_spokes.size();
        result_.single_spokes.resize(first + ring.valence);
        result_.singles.push_back(
            {static_cast<Index>(row), point_of_[unknowns_.rows[row]], static_cast<std::int64_t>(first)});
        filler_.fill(result_.singles.back());
        for (Index k = 0; k < ring.valence; ++k)
            result_.single_points.push_back(point_of_[ring.ring[k]]);
        result_.longest_single = std::max(result_.longest_single, ring.valence);
    }

    const Encoding& encoding_;
    const Unknowns& unknowns_;
    EnergyPatches& result_;
    RowFiller filler_;
    std::size_t first_point_ = 0;
    std::vector<Index> point_of_;  // n: in the current patch, or -1
};

/// How much a row is that of an anchor without neighbours that are anchors: 0 or 1 where all are hard, and 0 in the
/// middle of a handle of even strength, whatever that is.
double isolation(const Encoding& encoding, const Unknowns& unknowns, const std::vector<double>& hardness,
                 Index vertex) {
    const auto hardness_of = [&](Index v) {
        if (unknowns.slot[v] < 0) return 1.0;
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
                   const std::vector<double>& hardness, const Execution& execution, EnergyPatches& rows) {
    if (rows.bending.empty()) return;
    double inverse_squares = 0.0;
    for (const double value : rows.bending)
        inverse_squares += value;
    const double square = static_cast<double>(rows.bending.size()) / inverse_squares;
    for (std::size_t row = 0; row < rows.bending.size(); ++row) {
        execution.check_every(row);
        const double isolated = isolation(encoding, unknowns, hardness, unknowns.rows[row]);
        const double full = rows.bending[row] * square * (1.0 + (kLoneAnchorWeight - 1.0) * isolated);
        rows.bending[row] = share_of(full, by_length);
    }
    rows.stretching = square / (size * size);
    for (std::size_t k = 0; k < rows.batches.size(); ++k) {
        RowBatch& batch = rows.batches[k];
        for (int lane = 0; lane < kRowLanes; ++lane)
            batch.bending.value[lane] = batch.row[lane] < 0 ? 0.0 : rows.bending[batch.row[lane]];
    }
}

template <typename T>
std::size_t bytes_of(const std::vector<T>& items) {
    return items.capacity() * sizeof(T);
}

}  // namespace

EnergyPatches build_energy_patches(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells,
                                   double size, double by_length, bool in_batches,
                                   const std::vector<double>& hardness, const StiffRings* stiff,
                                   const Execution& execution) {
    EnergyPatches result;
    PatchBuilder builder(encoding, unknowns, cells, size, by_length, result);
    builder.reserve(in_batches, execution);
    for (std::size_t begin = 0; begin < unknowns.rows.size(); begin += kPatchRows) {
        execution.check();
        builder.add(begin, std::min(begin + kPatchRows, unknowns.rows.size()), in_batches);
    }
    builder.begin_patch();
    scale_weights(encoding, unknowns, size, by_length, hardness, execution, result);
    const StiffRings own =
        stiff != nullptr ? StiffRings() : find_stiff_rings(encoding, unknowns.rows, cells, execution);
    result.stiff_spokes = stiff_spokes(stiff != nullptr ? *stiff : own, encoding, unknowns, result.bending);
    execution.check();
    result.points.shrink_to_fit();
    return result;
}

void refill_energy_patches(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells, double size,
                           double by_length, const std::vector<double>& hardness, int threads,
                           const Execution& execution, EnergyPatches& patches) {
    std::vector<RowFiller> fillers(std::max(1, threads),
                                   RowFiller(encoding, unknowns, cells, size, by_length, patches));
    parallel_items(patches.patch_count(), threads, execution, [&](int worker, std::size_t patch) {
        const EnergyPatch& begin = patches.patches[patch];
        const EnergyPatch& end = patches.patches[patch + 1];
        for (std::int64_t batch = begin.first_batch; batch < end.first_batch; ++batch)
            fillers[worker].fill(patches.batches[batch]);
        for (std::int64_t single = begin.first_single; single < end.first_single; ++single)
            fillers[worker].fill(patches.singles[single]);
    });
    scale_weights(encoding, unknowns, size, by_length, hardness, execution, patches);
}

std::size_t EnergyPatches::bytes() const {
    return bytes_of(bending) + bytes_of(stiff_spokes) + bytes_of(patches) + bytes_of(batches) +
           bytes_of(bending_lanes) + bytes_of(stretching_lanes) + bytes_of(vertex_lanes) + bytes_of(singles) +
           bytes_of(single_spokes) + bytes_of(single_points) + bytes_of(points) + bytes_of(edge_lanes);
}

}  // namespace meanvalue
