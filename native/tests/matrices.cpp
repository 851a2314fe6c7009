#include "tests/matrices.h"

#include <random>

namespace meanvalue::tests {
namespace {

using Triplets = std::vector<Eigen::Triplet<double, std::int64_t>>;

SparseMatrix from_triplets(Index size, const Triplets& triplets) {
    SparseMatrix matrix(size, size);
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    return matrix;
}

SparseMatrix lower_of(const SparseMatrix& symmetric) {
    return symmetric.triangularView<Eigen::Lower>();
}

}  // namespace

SparseMatrix bilaplacian(const Mesh& mesh, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> weight(0.5, 1.5);
    Triplets triplets;
    for (Index face = 0; face < mesh.faces.rows(); ++face) {
        for (int corner = 0; corner < 3; ++corner) {
            const Index a = mesh.faces(face, corner);
            const Index b = mesh.faces(face, (corner + 1) % 3);
            const double w = weight(random) / 6.0;
            triplets.insert(triplets.end(), {{a, b, -w}, {b, a, -w}, {a, a, w}, {b, b, w}});
        }
    }
    const SparseMatrix laplacian = from_triplets(mesh.vertex_count(), triplets);
    Triplets held;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        held.emplace_back(v, v, v % 10 == 0 ? 1.0 : 1e-4);
    return lower_of(SparseMatrix(laplacian.transpose()) * laplacian + from_triplets(mesh.vertex_count(), held));
}

SparseMatrix diagonal(Index size) {
    Triplets triplets;
    for (Index k = 0; k < size; ++k)
        triplets.emplace_back(k, k, 1.0 + k % 7);
    return from_triplets(size, triplets);
}

SparseMatrix full(Index size) {
    Triplets triplets;
    for (Index column = 0; column < size; ++column) {
        for (Index row = column; row < size; ++row)
            triplets.emplace_back(row, column, row == column ? 2.0 * size : 1.0 / (1 + row - column));
    }
    return from_triplets(size, triplets);
}

SparseMatrix arrow(Index size) {
    Triplets triplets;
    for (Index row = 0; row < size; ++row) {
        triplets.emplace_back(row, row, row == 0 ? size : 2.0);
        if (row > 0) triplets.emplace_back(row, 0, 0.5);
    }
    return from_triplets(size, triplets);
}

SparseMatrix in_parts(const std::vector<SparseMatrix>& parts) {
    Triplets triplets;
    std::int64_t first = 0;
    for (const SparseMatrix& part : parts) {
        for (Eigen::Index column = 0; column < part.cols(); ++column) {
            for (SparseMatrix::InnerIterator entry(part, column); entry; ++entry)
                triplets.emplace_back(first + entry.row(), first + column, entry.value());
        }
        first += part.cols();
    }
    return from_triplets(static_cast<Index>(first), triplets);
}

SparseMatrix in_blocks(const SparseMatrix& lower) {
    Triplets triplets;
    for (Eigen::Index column = 0; column < lower.cols(); ++column) {
        for (SparseMatrix::InnerIterator entry(lower, column); entry; ++entry) {
            for (int k = 0; k < 9; ++k) {
                // Above the diagonal is what must be ignored.
                const bool ignored = 3 * entry.row() + k % 3 < 3 * column + k / 3;
                const double factor = k % 3 == k / 3 ? 1.0 : 0.25;
                triplets.emplace_back(3 * entry.row() + k % 3, 3 * column + k / 3,
                                      ignored ? 1e9 : factor * entry.value());
            }
        }
    }
    return from_triplets(static_cast<Index>(3 * lower.cols()), triplets);
}

std::vector<Case> all_matrices() {
    std::vector<Case> all;
    for (const Index size : {1, 2, 3, 4, 5, 7, 8, 9, 13, 100})
        all.push_back({"full " + std::to_string(size), full(size)});
    all.push_back({"full 400", full(400)});  // wider than a supernode may be
    all.push_back({"diagonal", diagonal(1000)});
    all.push_back({"large diagonal", diagonal(40000)});
    all.push_back({"arrow", arrow(500)});
    for (const Mesh& mesh : all_classes())
        all.push_back({mesh.name, bilaplacian(mesh)});
    const SparseMatrix large = bilaplacian(grid(100, 90, 0.1));
    all.push_back({"large grid", large});
    all.push_back({"large sphere", bilaplacian(sphere(6))});
    all.push_back({"long grid", bilaplacian(grid(3000, 4, 0.0))});
    all.push_back({"parts", in_parts({large, full(3), diagonal(50), bilaplacian(torus(60, 40)), full(1)})});
    all.push_back({"blocks", in_blocks(bilaplacian(grid(40, 30, 0.1)))});
    all.push_back({"many parts", in_parts(std::vector<SparseMatrix>(3000, full(5)))});
    return all;
}

}  // namespace meanvalue::tests
