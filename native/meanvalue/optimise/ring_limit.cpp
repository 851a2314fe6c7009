#include "meanvalue/optimise/ring_limit.h"

#include <algorithm>

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

// Shorter rings share most of their pairs with their neighbors'.
constexpr Index kLongRing = 100;
// Of pairs in all long rings together: they take some 3 GB in the matrices and factors of method fast, three times as
// much in those of full.
constexpr double kMostPairs = 3e7;

}  // namespace

void require_short_rings(const std::vector<Index>& vertices, const std::vector<Index>& neighbours) {
    double pairs = 0.0;
    for (const Index count : neighbours) {
        if (count >= kLongRing) pairs += 0.5 * static_cast<double>(count) * static_cast<double>(count);
    }
    const auto longest = std::max_element(neighbours.begin(), neighbours.end());
    if (longest == neighbours.end() || (*longest <= kMostNeighbours && pairs <= kMostPairs)) return;
    const std::string vertex =
        message("vertex ", vertices[longest - neighbours.begin()], " has ", *longest, " neighbors that may move");
    const std::string limit =
        *longest > kMostNeighbours
            ? message("at most ", kMostNeighbours, " can be solved for, since each acts on all others")
            : message("too many others have nearly as many: each acts on all others");
    throw InvalidInput(message(vertex, ", and ", limit,
                               "; dissolve it and triangulate the face that is left in another way, or let fewer of "
                               "its neighbors move (region of influence, anchors)"));
}

void require_short_rings(const Region& region, const std::vector<char>& is_fixed, const Execution& execution) {
    execution.check();
    // Two triangles count each neighbor, but only one those at the ends of an open fan.
    std::vector<Index> neighbours(region.vertices.size(), 0);
    for (Index f = 0; f < region.faces.rows(); ++f) {
        for (int k = 0; k < 3; ++k) {
            for (const int other : {(k + 1) % 3, (k + 2) % 3})
                neighbours[region.faces(f, k)] += is_fixed[region.faces(f, other)] ? 0 : 1;
        }
    }
    for (Index& count : neighbours)
        count = (count + 1) / 2;
    require_short_rings(region.vertices, neighbours);
}

}  // namespace meanvalue
