#include "meanvalue/mesh/same_places.h"

#include <algorithm>
#include <limits>

#include "meanvalue/common/errors.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

std::vector<Index> firsts(const std::vector<double>& along, double distance) {
    Positions points = Positions::Zero(static_cast<Index>(along.size()), 3);
    for (std::size_t k = 0; k < along.size(); ++k)
        points(static_cast<Index>(k), 0) = along[k];
    return first_of_place(points, distance, Execution());
}

TEST(SamePlaces, StepsLeadFromPointToPoint) {
    EXPECT_EQ(firsts({0.0, 5.0, 1.9, 1.0, 8.0}, 1.0), (std::vector<Index>{0, 1, 0, 0, 4}));
    EXPECT_EQ(firsts({3.0, 1.0, 3.0, 1.0, 2.0}, 0.0), (std::vector<Index>{0, 1, 0, 1, 4}));
    EXPECT_TRUE(firsts({}, 1.0).empty());
}

TEST(SamePlaces, WhatIsNoPlaceIsAlone) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(firsts({none, 1.0, none, 1.0}, 1.0), (std::vector<Index>{0, 1, 2, 1}));
    EXPECT_THROW(firsts({1.0}, -1.0), InvalidInput);
    EXPECT_THROW(firsts({1.0}, none), InvalidInput);
}

TEST(SamePlaces, ACrowdCostsNoMoreThanSortingIt) {
    std::vector<double> along(200000);
    for (std::size_t k = 0; k < along.size(); ++k)
        along[k] = (k % 2 == 0 ? 0.0 : 1.0) + 1e-7 * static_cast<double>(k);
    const std::vector<Index> apart = firsts(along, 0.5), together = firsts(along, 1.0);
    EXPECT_EQ(std::count(apart.begin(), apart.end(), 0), 100000);
    EXPECT_EQ(std::count(together.begin(), together.end(), 0), 200000);
}

}  // namespace
}  // namespace meanvalue::tests
