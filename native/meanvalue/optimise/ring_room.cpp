#include "meanvalue/optimise/ring_room.h"

#include <algorithm>
#include <utility>

#include "meanvalue/common/errors.h"
#include "meanvalue/mesh/disjoint_sets.h"

namespace meanvalue {
namespace {

constexpr std::int64_t kLongRow = 100;
constexpr double kMostLongBytes = 4e9;
constexpr double kMostShortBytes = 1e10;
constexpr double kGigabyte = 1e9;
constexpr const char* kRemedy =
    "; dissolve it and triangulate the face that is left in another way, or let fewer of its neighbours move (region "
    "of influence, anchors)";

/// A neighbour of the vertex that is looked at, and which of its triangles names it.
using Spoke = std::pair<Index, Index>;

/// Free neighbours in the fan that has most of them. @param spokes two for each triangle; sorted here.
std::int64_t free_in_largest_fan(std::vector<Spoke>& spokes, const std::vector<char>& is_fixed) {
    std::sort(spokes.begin(), spokes.end());
    const auto for_each_neighbour = [&](const auto& visit) {
        for (std::size_t begin = 0, end = 0; begin < spokes.size(); begin = end) {
            while (end < spokes.size() && spokes[end].first == spokes[begin].first)
                ++end;
            visit(begin, end);
        }
    };
    DisjointSets fans(static_cast<Index>(spokes.size() / 2));
    // A third triangle on an edge fits no manifold and is a fan of its own.
    for_each_neighbour([&](std::size_t begin, std::size_t end) {
        if (end - begin > 1) fans.join(spokes[begin].second, spokes[begin + 1].second);
    });
    std::vector<std::int64_t> counts(spokes.size() / 2, 0);
    for_each_neighbour([&](std::size_t begin, std::size_t end) {
        if (is_fixed[spokes[begin].first]) return;
        ++counts[fans.root(spokes[begin].second)];
        for (std::size_t k = begin + 2; k < end; ++k)
            ++counts[fans.root(spokes[k].second)];
    });
    return *std::max_element(counts.begin(), counts.end());
}

}  // namespace

void RingRoom::add(Index vertex, std::int64_t free_neighbours) {
    const double pairs = 0.5 * static_cast<double>(free_neighbours + 1) * static_cast<double>(free_neighbours + 2);
    if (free_neighbours < kLongRow) {
        short_bytes_ += bytes_.in_short_rows * pairs;
        return;
    }
    long_bytes_ += bytes_.in_long_rows * pairs;
    ++long_row_count_;
    if (free_neighbours > longest_) {
        longest_ = free_neighbours;
        longest_vertex_ = vertex;
    }
}

void RingRoom::require() const {
    if (longest_ > kMostNeighbours) {
        throw InvalidInput(message("vertex ", longest_vertex_, " has ", longest_,
                                   " neighbours that may move, and at most ", kMostNeighbours,
                                   " can be solved for, since each acts on all others", kRemedy));
    }
    if (long_bytes_ > kMostLongBytes) {
        throw InvalidInput(message(long_row_count_, " vertices have ", kLongRow,
                                   " neighbours or more that may move, and together they need ",
                                   long_bytes_ / kGigabyte, " GB, more than the ", kMostLongBytes / kGigabyte,
                                   " there may be; the one with most is vertex ", longest_vertex_, ", with ",
                                   longest_, kRemedy));
    }
    if (short_bytes_ > kMostShortBytes) {
        throw InvalidInput(message("the free vertices need about ", short_bytes_ / kGigabyte, " GB, more than the ",
                                   kMostShortBytes / kGigabyte,
                                   " there may be with this method; restrict the region of influence"));
    }
}

void require_room_for_rings(const Region& region, const std::vector<char>& is_fixed, const PairBytes& bytes,
                            const Execution& execution) {
    // Each neighbour but for the ends of an open fan is named by two triangles.
    std::vector<Index> named(region.vertices.size(), 0);
    const auto for_each_spoke = [&](const auto& visit) {
        execution.check();
        for (Index f = 0; f < region.faces.rows(); ++f) {
            for (int k = 0; k < 3; ++k) {
                visit(f, region.faces(f, k), region.faces(f, (k + 1) % 3));
                visit(f, region.faces(f, k), region.faces(f, (k + 2) % 3));
            }
        }
    };
    for_each_spoke([&](Index, Index vertex, Index neighbour) { named[vertex] += is_fixed[neighbour] ? 0 : 1; });
    std::vector<Index> place(region.vertices.size(), -1);
    std::vector<Index> found;
    RingRoom room(bytes);
    for (std::size_t v = 0; v < named.size(); ++v) {
        if (named[v] < kLongRow) {
            if (named[v] > 0 || !is_fixed[v]) room.add(region.vertices[v], (named[v] + 1) / 2);
            continue;
        }
        place[v] = static_cast<Index>(found.size());
        found.push_back(static_cast<Index>(v));
    }
    std::vector<std::vector<Spoke>> spokes(found.size());
    if (!found.empty()) {
        for_each_spoke([&](Index, Index vertex, Index neighbour) {
            if (place[vertex] < 0) return;
            std::vector<Spoke>& of_vertex = spokes[place[vertex]];
            of_vertex.emplace_back(neighbour, static_cast<Index>(of_vertex.size() / 2));
        });
    }
    for (std::size_t k = 0; k < found.size(); ++k) {
        execution.check();
        room.add(region.vertices[found[k]], free_in_largest_fan(spokes[k], is_fixed));
    }
    room.require();
}

}  // namespace meanvalue
