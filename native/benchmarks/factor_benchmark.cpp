// Order, symbolic analysis, numbers and solve of the factorisation, in seconds: one line of JSON.
// Usage: meanvalue_factor_benchmark MESH BLOCK THREADS; MESH is the side of a generated grid, or a file.
#include <algorithm>
#include <cctype>
#include <chrono>
#include <iostream>
#include <string>

#include "benchmarks/factor_cases.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/nested_dissection.h"
#include "meanvalue/linalg/supernodal_factor.h"

namespace {

using meanvalue::Execution;
using meanvalue::Index;

template <typename Action>
double seconds_of(const Action& action) {
    const auto start = std::chrono::steady_clock::now();
    action();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

int measure(const std::string& mesh, Index block, int threads) {
    namespace benchmarks = meanvalue::benchmarks;
    const bool generated =
        std::all_of(mesh.begin(), mesh.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
    const meanvalue::SparseMatrix lower = benchmarks::squared_differences(
        generated ? benchmarks::grid(std::stoi(mesh)) : benchmarks::read_surface(mesh), block);
    const Execution execution;
    const double order =
        seconds_of([&] { nested_dissection(meanvalue::graph_of(lower, execution), threads, execution); });
    meanvalue::SparseCholesky cholesky;
    const double analyse = seconds_of([&] { cholesky.analyse(lower, execution, threads); });
    bool done = false;
    const double factor = seconds_of([&] { done = cholesky.factorise(lower, execution, threads); });
    if (!done) return 1;
    const double again = seconds_of([&] { cholesky.factorise(lower, execution, threads); });
    const Eigen::MatrixXd right_hand_sides = Eigen::MatrixXd::Random(lower.cols(), 3);
    Eigen::MatrixXd solution;
    const double solve = seconds_of([&] { solution = cholesky.solve(right_hand_sides, execution); });
    const Eigen::MatrixXd rest = lower.selfadjointView<Eigen::Lower>() * solution - right_hand_sides;
    const meanvalue::SupernodalPattern& pattern = cholesky.pattern();
    double work = 0.0;
    double numbers = 0.0;  // of the factor, in triangles
    for (Index s = 0; s < pattern.count(); ++s) {
        work += static_cast<double>(pattern.work(s));
        numbers += static_cast<double>(pattern.panel_size(s)) - 0.5 * pattern.width(s) * (pattern.width(s) - 1.0);
    }
    std::cout << "{\"unknowns\": " << lower.cols() << ", \"order\": " << order << ", \"analyse\": " << analyse
              << ", \"factor\": " << factor << ", \"again\": " << again << ", \"solve\": " << solve
              << ", \"numbers\": " << numbers / static_cast<double>(lower.cols())
              << ", \"gflops\": " << work * 1e-9 / again
              << ", \"residual\": " << rest.norm() / right_hand_sides.norm() << "}\n";
    return 0;
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 4) {
        std::cerr << "meanvalue_factor_benchmark MESH BLOCK THREADS\n";
        return 2;
    }
    try {
        return measure(arguments[1], std::stoi(arguments[2]), std::stoi(arguments[3]));
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
