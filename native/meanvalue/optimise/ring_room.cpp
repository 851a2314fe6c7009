#include "meanvalue/optimise/ring_room.h"

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

constexpr std::int64_t kLongRow = 100;
constexpr double kMostBytes = 1e10;
constexpr double kGigabyte = 1e9;
constexpr const char* kRemedy =
    "; dissolve it and triangulate the face that is left in another way, or let fewer of its neighbours move (region "
    "of influence, anchors)";

}  // namespace

void RingRoom::add(Index vertex, std::int64_t free_neighbours) {
    const double pairs = 0.5 * static_cast<double>(free_neighbours + 1) * static_cast<double>(free_neighbours + 2);
    bytes_ += pairs * (free_neighbours < kLongRow ? pair_bytes_.in_short_rows : pair_bytes_.in_long_rows);
    if (free_neighbours <= longest_) return;
    longest_ = free_neighbours;
    longest_vertex_ = vertex;
}

void RingRoom::require() const {
    if (longest_ > kMostNeighbours) {
        throw InvalidInput(message("vertex ", longest_vertex_, " has ", longest_,
                                   " neighbours that may move, and at most ", kMostNeighbours,
                                   " can be solved for, since each acts on all others", kRemedy));
    }
    if (bytes_ > kMostBytes) {
        throw InvalidInput(message("the free vertices need about ", bytes_ / kGigabyte, " GB, more than the ",
                                   kMostBytes / kGigabyte,
                                   " there may be with this method; restrict the region of influence. The vertex "
                                   "with most neighbours is ",
                                   longest_vertex_, ", with ", longest_));
    }
}

void require_room_for_rings(const Region& region, const std::vector<char>& is_fixed, const PairBytes& bytes,
                            const Execution& execution) {
    // Each neighbor but for the ends of an open fan is named by two triangles.
    std::vector<Index> named(region.vertices.size(), 0);
    execution.check();
    for (Index f = 0; f < region.faces.rows(); ++f) {
        for (int k = 0; k < 3; ++k) {
            for (const int other : {(k + 1) % 3, (k + 2) % 3})
                named[region.faces(f, k)] += is_fixed[region.faces(f, other)] ? 0 : 1;
        }
    }
    RingRoom room(bytes);
    for (std::size_t v = 0; v < named.size(); ++v) {
        if (named[v] > 0 || !is_fixed[v]) room.add(region.vertices[v], (named[v] + 1) / 2);
    }
    room.require();
}

}  // namespace meanvalue
