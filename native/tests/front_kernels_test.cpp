#include "meanvalue/linalg/front_kernels.h"

#include <cmath>
#include <limits>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// A front with all its numbers, and what the kernels make of it.
struct Front {
    FrontShape shape;
    Eigen::MatrixXd whole;  // symmetric positive definite
    std::vector<double> panel;
    std::vector<double> rest;
    std::vector<double> reciprocals;

    explicit Front(const FrontShape& of) : shape(of) {
        const Index size = shape.width + shape.below;
        const Eigen::MatrixXd random = Eigen::MatrixXd::Random(size, size);
        whole = random * random.transpose() + Eigen::MatrixXd::Identity(size, size);
        panel.assign(shape.panel_size(), 0.0);
        rest.assign(shape.rest_stride() * shape.rest_stride(), 0.0);
        reciprocals.resize(shape.width);
        for (Index c = 0; c < size; ++c) {
            for (Index r = c; r < size; ++r)
                at(r, c) = whole(r, c);
        }
    }

    double& at(Index row, Index column) {
        if (column < shape.width) return panel[shape.place(row) + std::int64_t{column} * kBlockRows];
        return rest[(column - shape.width) * shape.rest_stride() + row - shape.width];
    }

    bool eliminate(const FrontKernels& kernels, Index piece) {
        if (!kernels.factor_top(shape, panel.data(), reciprocals.data())) return false;
        for (Index k = 0; k < shape.below_blocks(); k += piece)
            kernels.solve_below(shape, panel.data(), reciprocals.data(), k,
                                std::min(k + piece, shape.below_blocks()));
        for (Index k = 0; k < shape.below_blocks(); k += piece)
            kernels.update_rest(shape, panel.data(), rest.data(), k, std::min(k + piece, shape.below_blocks()));
        return true;
    }
};

std::vector<FrontShape> shapes() {
    std::vector<FrontShape> all;
    for (const Index width : {1, 2, 3, 4, 5, 11, 12, 13, 16, 23, 24, 50, 192}) {
        for (const Index below : {0, 1, 3, 11, 12, 13, 40, 77})
            all.push_back({width, below});
    }
    return all;
}

class KernelsOf : public testing::TestWithParam<InstructionSet> {};

TEST_P(KernelsOf, EliminateAFront) {
    for (const FrontShape& shape : shapes()) {
        Front front(shape);
        ASSERT_TRUE(front.eliminate(front_kernels(GetParam()), 2));
        const Index size = shape.width + shape.below;
        Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(size, shape.width);
        Eigen::MatrixXd left = Eigen::MatrixXd::Zero(size, size);
        for (Index c = 0; c < size; ++c) {
            for (Index r = c; r < size; ++r)
                (c < shape.width ? factor(r, c) : left(r, c)) = front.at(r, c);
        }
        const Eigen::MatrixXd error =
            (factor * factor.transpose() + left - front.whole).triangularView<Eigen::Lower>();
        EXPECT_LT(error.norm(), 1e-13 * front.whole.norm()) << shape.width << " columns, " << shape.below << " below";
    }
}

TEST_P(KernelsOf, GiveTheSameBitsInPiecesOfAnySize) {
    Front front({50, 100});
    Front in_pieces = front;
    ASSERT_TRUE(front.eliminate(front_kernels(GetParam()), 100));
    ASSERT_TRUE(in_pieces.eliminate(front_kernels(GetParam()), 1));
    for (Index c = 0; c < 150; ++c) {
        for (Index r = c; r < 150; ++r)
            ASSERT_EQ(front.at(r, c), in_pieces.at(r, c));
    }
}

TEST_P(KernelsOf, FindPivotsThatAreNone) {
    for (const double pivot : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
        for (const Index column : {0, 3, 17, 18}) {
            Front front({19, 20});
            front.at(column, column) = pivot;
            EXPECT_FALSE(front.eliminate(front_kernels(GetParam()), 2)) << pivot << " in column " << column;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Forms, KernelsOf, testing::Values(InstructionSet::kPortable, InstructionSet::kFastest));

}  // namespace
}  // namespace meanvalue::tests
