#include "meanvalue/optimise/gauss_seidel.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/predictor.h"

namespace meanvalue {
namespace {

// An eigenvalue below this share of the trace is rounding: the rows say nothing of that direction.
constexpr double kLeastShare = 1e-9;

/// Whether a vertex without a row of its own can move in some direction in which no other row changes.
bool is_singular(const Matrix3& diagonal) {
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(diagonal, Eigen::EigenvaluesOnly);
    return !(solver.eigenvalues()(0) > kLeastShare * diagonal.trace());
}

}  // namespace

GaussSeidel::GaussSeidel(const Encoding& encoding, const Unknowns& unknowns, const Execution& execution)
    : encoding_(encoding), unknowns_(unknowns), use_offsets_(unknowns.free.size() + 1, 0) {
    WorkMeter work(execution);
    const auto for_each_use = [&](const auto& visit) {
        for (const Index row : unknowns_.rows) {
            work.add(1 + encoding_.ring_offsets[row + 1] - encoding_.ring_offsets[row]);
            for (Index k = encoding_.ring_offsets[row]; k < encoding_.ring_offsets[row + 1]; ++k) {
                const Index number = unknowns_.number[encoding_.ring[k]];
                if (number >= 0) visit(number, Use{row, k - encoding_.ring_offsets[row]});
            }
        }
    };
    for_each_use([&](Index number, const Use&) { ++use_offsets_[number + 1]; });
    std::partial_sum(use_offsets_.begin(), use_offsets_.end(), use_offsets_.begin());
    uses_.resize(use_offsets_.back());
    std::vector<std::int64_t> next(use_offsets_.begin(), use_offsets_.end() - 1);
    for_each_use([&](Index number, const Use& use) { uses_[next[number]++] = use; });
    find_colours(execution);
}

void GaussSeidel::find_colours(const Execution& execution) {
    // Greedy in the order of the numbers: the lowest colour that no vertex with a common row has.
    std::vector<Index> colour(unknowns_.free.size(), -1);
    std::vector<Index> taken_by;  // per colour: the last number that found it taken
    WorkMeter work(execution);
    for (std::size_t number = 0; number < colour.size(); ++number) {
        const auto mark = [&](Index vertex) {
            const Index other = unknowns_.number[vertex];
            if (other >= 0 && colour[other] >= 0) taken_by[colour[other]] = static_cast<Index>(number);
        };
        const auto mark_row = [&](Index row) {
            work.add(1 + encoding_.ring_offsets[row + 1] - encoding_.ring_offsets[row]);
            mark(row);
            for (Index k = encoding_.ring_offsets[row]; k < encoding_.ring_offsets[row + 1]; ++k) {
                mark(encoding_.ring[k]);
            }
        };
        mark_row(unknowns_.free[number]);
        for (std::int64_t k = use_offsets_[number]; k < use_offsets_[number + 1]; ++k)
            mark_row(uses_[k].row);
        work.add(colours_.size());
        std::size_t chosen = 0;
        while (chosen < colours_.size() && taken_by[chosen] == static_cast<Index>(number))
            ++chosen;
        if (chosen == colours_.size()) {
            colours_.emplace_back();
            taken_by.push_back(-1);
        }
        colour[number] = static_cast<Index>(chosen);
        colours_[chosen].push_back(static_cast<Index>(number));
    }
}

void GaussSeidel::sweep(Positions& positions, int threads, const Execution& execution) const {
    for (const std::vector<Index>& colour : colours_) {
        parallel_for(static_cast<Index>(colour.size()), threads, execution, [&](Index begin, Index end) {
            for (Index k = begin; k < end; ++k)
                relax(colour[k], positions);
        });
    }
}

void GaussSeidel::relax(Index number, Positions& positions) const {
    const Index vertex = unknowns_.free[number];
    Vector3 gradient = Vector3::Zero();
    Matrix3 diagonal = Matrix3::Zero();
    if (encoding_.predictable(vertex)) {
        gradient = Vector3(positions.row(vertex)) - predict(encoding_.ring_of(vertex), positions);
        diagonal.setIdentity();
    }
    for (std::int64_t k = use_offsets_[number]; k < use_offsets_[number + 1]; ++k) {
        const Use& use = uses_[k];
        Matrix3 block;
        const Vector3 predicted = predict_with_jacobian_of(encoding_.ring_of(use.row), positions, use.place, block);
        gradient -= block.transpose() * (Vector3(positions.row(use.row)) - predicted);
        diagonal += block.transpose() * block;
    }
    if (!encoding_.predictable(vertex) && is_singular(diagonal)) return;
    const Vector3 move = diagonal.inverse() * gradient;
    if (move.allFinite()) positions.row(vertex) -= move;
}

}  // namespace meanvalue
