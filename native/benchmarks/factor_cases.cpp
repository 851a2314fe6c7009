#include "benchmarks/factor_cases.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <numeric>
#include <random>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace meanvalue::benchmarks {
namespace {

using Triplets = std::vector<Eigen::Triplet<double, std::int64_t>>;

void add_fan(const std::vector<Index>& corners, Surface& surface) {
    for (std::size_t k = 2; k < corners.size(); ++k)
        surface.triangles.push_back({corners[0], corners[k - 1], corners[k]});
}

Surface read_off(std::istream& file) {
    std::string header;
    Index faces = 0;
    Index edges = 0;
    Surface surface;
    file >> header >> surface.vertex_count >> faces >> edges;
    std::string line;
    std::getline(file, line);
    for (Index v = 0; v < surface.vertex_count; ++v)
        std::getline(file, line);
    for (Index face = 0; face < faces; ++face) {
        std::size_t corner_count = 0;
        file >> corner_count;
        std::vector<Index> corners(corner_count);
        for (Index& corner : corners)
            file >> corner;
        std::getline(file, line);
        add_fan(corners, surface);
    }
    return surface;
}

Surface read_obj(std::istream& file) {
    Surface surface;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string kind;
        words >> kind;
        if (kind == "v") ++surface.vertex_count;
        if (kind != "f") continue;
        std::vector<Index> corners;
        for (std::string word; words >> word;)
            corners.push_back(static_cast<Index>(std::stol(word)) - 1);
        add_fan(corners, surface);
    }
    return surface;
}

/// One vertex in twenty -1, the others numbers from 0, at random. @return how many.
Index free_numbers(Index vertex_count, std::vector<Index>& number) {
    std::vector<Index> order(vertex_count);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), std::mt19937(1));
    number.assign(vertex_count, -1);
    const Index count = vertex_count - vertex_count / 20;
    for (Index k = 0; k < count; ++k)
        number[order[k]] = k;
    return count;
}

}  // namespace

Surface grid(Index side) {
    Surface surface;
    surface.vertex_count = side * side;
    for (Index y = 0; y + 1 < side; ++y) {
        for (Index x = 0; x + 1 < side; ++x) {
            const Index v = y * side + x;
            surface.triangles.push_back({v, v + 1, v + side + 1});
            surface.triangles.push_back({v, v + side + 1, v + side});
        }
    }
    return surface;
}

Surface read_surface(const std::string& path) {
    std::ifstream file(path);
    Surface surface = path.substr(path.size() - 4) == ".off" ? read_off(file) : read_obj(file);
    if (surface.triangles.empty()) throw std::runtime_error("no faces could be read from " + path);
    return surface;
}

SparseMatrix squared_differences(const Surface& surface, Index block) {
    std::vector<std::vector<Index>> rings(surface.vertex_count);
    for (const auto& triangle : surface.triangles) {
        for (int k = 0; k < 3; ++k) {
            rings[triangle[k]].push_back(triangle[(k + 1) % 3]);
            rings[triangle[k]].push_back(triangle[(k + 2) % 3]);
        }
    }
    std::vector<Index> number;
    const Index count = free_numbers(surface.vertex_count, number);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> weight(0.5, 1.5);
    Triplets differences;
    for (Index v = 0; v < surface.vertex_count; ++v) {
        std::vector<Index>& ring = rings[v];
        std::sort(ring.begin(), ring.end());
        ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
        if (number[v] >= 0) differences.emplace_back(v, number[v], ring.empty() ? 1.0 : -1.0);
        for (const Index u : ring) {
            if (number[u] >= 0)
                differences.emplace_back(v, number[u], weight(random) / static_cast<double>(ring.size()));
        }
    }
    SparseMatrix d(surface.vertex_count, count);
    d.setFromTriplets(differences.begin(), differences.end());
    SparseMatrix lower = SparseMatrix(SparseMatrix(d.transpose()) * d).triangularView<Eigen::Lower>();
    if (block == 1) return lower;
    Triplets blocks;
    for (Index column = 0; column < count; ++column) {
        for (SparseMatrix::InnerIterator entry(lower, column); entry; ++entry) {
            for (Index r = 0; r < block; ++r) {
                for (Index c = 0; c < block; ++c) {
                    const Eigen::Index row = block * entry.row() + r;
                    const Eigen::Index of = block * column + c;
                    if (row >= of) blocks.emplace_back(row, of, entry.value() * (r == c ? 1.0 : 0.1));
                }
            }
        }
    }
    SparseMatrix whole(std::int64_t{block} * count, std::int64_t{block} * count);
    whole.setFromTriplets(blocks.begin(), blocks.end());
    return whole;
}

}  // namespace meanvalue::benchmarks
