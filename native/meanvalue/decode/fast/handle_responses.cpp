#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/decode/fast/fast_problem.h"

namespace meanvalue {
namespace {

// A hand moves one handle, or those that are selected; a clip may move a hundred markers, for which a solve of all
// together is the cheaper one.
constexpr std::size_t kMostHandles = 6;

constexpr Index kTranslation = 3;

/// Of a handle: a point at `place` moves by moved(move, place) and the last row.
using AffineMove = Eigen::Matrix<double, 4, 3, Eigen::RowMajor>;

/// Sums by hand: the bits of Eigen's products depend on the processor.
template <typename Place>
Eigen::RowVector3d moved(const AffineMove& move, const Place& place) {
    return static_cast<double>(place(0)) * move.row(0) + static_cast<double>(place(1)) * move.row(1) +
           static_cast<double>(place(2)) * move.row(2);
}

/// The affine move nearest to that of some drivers, the least one where they leave it open.
AffineMove affine_fit(const Positions& places, const std::vector<Index>& rows, const Positions& moves) {
    const Vector3 translation = mean_row(Positions(moves(rows, Eigen::all)));
    Matrix3 spread = kNegligible * static_cast<double>(rows.size()) * Matrix3::Identity();
    Matrix3 shared = Matrix3::Zero();
    for (const Index k : rows) {
        const Vector3 place = places.row(k);
        spread += place * place.transpose();
        shared += place * moves.row(k);
    }
    AffineMove move;
    const Eigen::LDLT<Matrix3> factor = spread.ldlt();
    for (int c = 0; c < 3; ++c)  // column by column: solves for matrices have the bits of a processor
        move.col(c).head<3>() = factor.solve(shared.col(c));
    move.row(kTranslation) = translation.transpose();
    return move;
}

}  // namespace

DrivingHandles::DrivingHandles(const Positions& rest, const std::vector<Index>& piece_of) : places(rest.rows(), 3) {
    for (std::size_t k = 0; k < piece_of.size(); ++k) {
        if (pieces.size() <= static_cast<std::size_t>(piece_of[k])) pieces.resize(piece_of[k] + 1);
        pieces[piece_of[k]].push_back(static_cast<Index>(k));
    }
    for (const std::vector<Index>& rows : pieces) {
        if (rows.empty()) {
            has_extent.push_back(0);
            continue;
        }
        const Vector3 middle = mean_row(Positions(rest(rows, Eigen::all)));
        double spread = 0.0;
        for (const Index k : rows) {
            places.row(k) = rest.row(k) - middle.transpose();
            spread += places.row(k).squaredNorm();
        }
        spread = std::sqrt(spread / static_cast<double>(rows.size()));
        has_extent.push_back(spread > 0.0 ? 1 : 0);
        for (const Index k : rows)
            if (spread > 0.0) places.row(k) /= spread;
    }
}

std::vector<Index> HandleResponses::moving(const Positions& moves, double least) const {
    std::vector<Index> found;
    for (std::size_t handle = 0; handle < handles_->pieces.size(); ++handle) {
        const std::vector<Index>& rows = handles_->pieces[handle];
        const bool moves_too = std::any_of(rows.begin(), rows.end(),
                                           [&](Index k) { return moves.row(k).cwiseAbs().maxCoeff() > least; });
        if (moves_too) found.push_back(static_cast<Index>(handle));
    }
    if (found.size() > kMostHandles) found.clear();
    return found;
}

std::vector<Index> HandleResponses::unknown(const std::vector<Index>& handles) const {
    std::vector<Index> found;
    std::copy_if(handles.begin(), handles.end(), std::back_inserter(found), [&](Index handle) {
        return std::none_of(known_.begin(), known_.end(), [&](const Known& known) { return known.handle == handle; });
    });
    return found;
}

std::vector<HandleResponses::Fields> HandleResponses::ask(const std::vector<Index>& handles,
                                                          const Hessian& hessian) const {
    struct Column {
        std::size_t number;  // in `handles`
        Index field;
    };
    std::vector<Column> columns;
    for (std::size_t number = 0; number < handles.size(); ++number) {
        for (Index field = handles_->has_extent[handles[number]] ? 0 : kTranslation; field <= kTranslation; ++field)
            columns.push_back({number, field});
    }
    std::vector<Fields> fields(handles.size());
    for (std::size_t first = 0; first < columns.size(); first += 3) {
        const std::size_t count = std::min<std::size_t>(3, columns.size() - first);
        Positions moves = Positions::Zero(handles_->places.rows(), 3);
        for (std::size_t c = 0; c < count; ++c) {
            const Column column = columns[first + c];
            for (const Index k : handles_->pieces[handles[column.number]])
                moves(k, static_cast<Index>(c)) =
                    column.field == kTranslation ? 1.0 : handles_->places(k, column.field);
        }
        const Positions answer = hessian(moves);
        for (std::size_t c = 0; c < count; ++c) {
            Fields& of_handle = fields[columns[first + c].number];
            if (of_handle.size() == 0) of_handle.setZero(answer.rows(), 4);
            of_handle.col(columns[first + c].field) = answer.col(static_cast<Index>(c)).cast<float>();
        }
    }
    return fields;
}

void HandleResponses::keep(const std::vector<Index>& handles, std::vector<Fields> fields,
                           const std::vector<Index>& moving) {
    for (auto known = known_.begin(); known != known_.end() && known_.size() + handles.size() > kMostHandles;) {
        const bool moves_too = std::find(moving.begin(), moving.end(), known->handle) != moving.end();
        known = moves_too ? std::next(known) : known_.erase(known);
    }
    for (std::size_t number = 0; number < handles.size(); ++number)
        known_.push_back({handles[number], std::move(fields[number])});
}

void HandleResponses::answer(Positions& moves, const Unknowns& unknowns, Positions& positions, int threads,
                             const Execution& execution) const {
    std::vector<AffineMove> affine;
    for (const Known& known : known_) {
        const std::vector<Index>& rows = handles_->pieces[known.handle];
        affine.push_back(affine_fit(handles_->places, rows, moves));
        const AffineMove& move = affine.back();
        for (const Index k : rows)
            moves.row(k) -= moved(move, handles_->places.row(k)) + move.row(kTranslation);
    }
    parallel_for(static_cast<Index>(unknowns.free.size()), threads, execution, [&](Index begin, Index end) {
        for (std::size_t number = 0; number < known_.size(); ++number) {
            const AffineMove& move = affine[number];
            const Fields& fields = known_[number].fields;
            for (Index k = begin; k < end; ++k)
                positions.row(unknowns.free[k]) +=
                    moved(move, fields.row(k)) +
                    static_cast<double>(fields(k, kTranslation)) * move.row(kTranslation);
        }
    });
}

}  // namespace meanvalue
