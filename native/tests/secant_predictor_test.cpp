#include "meanvalue/decode/fast/secant_predictor.h"

#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// Begins at `here`. @return whether it goes on from there.
bool begins(SecantPredictor& predictor, const Positions& here, const Positions& drivers) {
    const bool goes_on = predictor.has_answer();
    if (!goes_on) predictor.begin(here, drivers);
    return goes_on;
}

/// A shape of some vertices that answers to two drivers: straight, but for `curvature` times the squares.
struct Shape {
    double curvature = 0.0;

    static Positions drivers(double a, double b) {
        Positions result = Positions::Zero(2, 3);
        result(0, 0) = a;
        result(1, 2) = b;
        return result;
    }
    Positions at(double a, double b) const {
        Positions result(5000, 3);
        for (Index v = 0; v < result.rows(); ++v) {
            result.row(v) << std::sin(v) * a + curvature * a * a, std::cos(v) * b, a - b + curvature * a * b;
        }
        return result;
    }
};

/// What is predicted at (a, b) from the last of `way`, or nothing.
std::optional<Positions> predicted(const Shape& shape, const std::vector<std::pair<double, double>>& way, double a,
                                   double b, int threads = 1) {
    SecantPredictor predictor;
    Positions here = shape.at(way[0].first, way[0].second);
    for (std::size_t k = 1; k < way.size(); ++k) {
        EXPECT_EQ(begins(predictor, here, Shape::drivers(way[k - 1].first, way[k - 1].second)), k > 1);
        here = shape.at(way[k].first, way[k].second);
        predictor.note(here, Shape::drivers(way[k].first, way[k].second));
    }
    EXPECT_EQ(begins(predictor, here, Shape::drivers(way.back().first, way.back().second)), way.size() > 1);
    const Positions from = predictor.drivers();
    const Positions gone = predictor.predict(Shape::drivers(a, b), here, threads, Execution());
    if (gone == from) return {};
    return here;
}

// Changes are kept in single precision.
constexpr double kRounding = 1e-6;

TEST(SecantPredictor, WhatAnswersStraightIsPredictedExactly) {
    const Shape shape;
    const auto found = predicted(shape, {{0, 0}, {1, 0}, {1.5, 0.5}}, 2.0, 1.0);
    ASSERT_TRUE(found);
    EXPECT_LT(largest_distance(*found, shape.at(2.0, 1.0)), kRounding);
}

TEST(SecantPredictor, ADragThatComesBackIsPredictedToo) {
    const Shape shape{0.3};
    const auto found = predicted(shape, {{0, 0}, {0.2, 0}}, 0.0, 0.0);
    ASSERT_TRUE(found);
    EXPECT_LT(largest_distance(*found, shape.at(0.0, 0.0)), kRounding);
}

TEST(SecantPredictor, TheErrorFallsWithTheSquareOfTheMove) {
    const Shape shape{0.5};
    const auto error = [&](double step) {
        return largest_distance(predicted(shape, {{1.0 - step, 0}, {1.0, 0}}, 1.0 + step, 0.0).value(),
                                shape.at(1.0 + step, 0.0));
    };
    EXPECT_NEAR(error(0.2) / error(0.1), 4.0, 0.01);
}

TEST(SecantPredictor, MovesThatWereNeverSeenAreNotPredicted) {
    EXPECT_FALSE(predicted(Shape{}, {{0, 0}, {1, 0}}, 1.0, 1.0)) << "across";
    EXPECT_FALSE(predicted(Shape{}, {{0, 0}, {1, 0}}, 109.0, 0.0)) << "far";
    EXPECT_FALSE(predicted(Shape{}, {{0, 0}, {1e-4, 0}}, 1e-3, 0.0)) << "as far as a noise would go";
    EXPECT_FALSE(predicted(Shape{}, {{0, 0}}, 1.0, 0.0)) << "the first";
    EXPECT_FALSE(predicted(Shape{}, {{0, 0}, {1, 0}}, 1.0, 0.0)) << "none";
    EXPECT_FALSE(predicted(Shape{}, {{0, 0}, {1, 0}}, std::numeric_limits<double>::quiet_NaN(), 0.0));
    EXPECT_FALSE(predicted(Shape{}, {{0, 0}, {1, 0}}, std::numeric_limits<double>::infinity(), 0.0));
}

TEST(SecantPredictor, ChangesThatAreNearlyAlikeDoNotBlowUpTheirDifference) {
    // Two changes a hair apart: their difference tells of b, with the rounding of both.
    const Shape shape{0.5};
    EXPECT_FALSE(predicted(shape, {{0, 0}, {1, 0}, {2, 1e-3}}, 2.0, 1.0));
}

TEST(SecantPredictor, WhatIsForgottenOrWasBrokenOffPredictsNothing) {
    const Shape shape;
    SecantPredictor predictor;
    Positions here = shape.at(0, 0);
    EXPECT_FALSE(begins(predictor, here, Shape::drivers(0, 0)));
    EXPECT_FALSE(begins(predictor, here, Shape::drivers(0, 0))) << "there was no note()";
    here = shape.at(1, 0);
    predictor.note(here, Shape::drivers(1, 0));
    EXPECT_TRUE(begins(predictor, here, Shape::drivers(1, 0)));
    EXPECT_TRUE(begins(predictor, here, Shape::drivers(1, 0))) << "broken off, but it began at an answer";
    predictor.forget();
    EXPECT_FALSE(begins(predictor, here, Shape::drivers(1, 0)));
    const Positions before = here;
    predictor.predict(Shape::drivers(2, 0), here, 1, Execution());
    EXPECT_EQ(here, before);
}

TEST(SecantPredictor, TellsHowFarTheDriversAreExplained) {
    const Shape shape;
    SecantPredictor predictor;
    Positions here = shape.at(0, 0);
    begins(predictor, here, Shape::drivers(0, 0));
    here = shape.at(1, 0);
    predictor.note(here, Shape::drivers(1, 0));
    const Positions gone = predictor.predict(Shape::drivers(2, 0.5), here, 1, Execution());
    EXPECT_LT(largest_distance(gone, Shape::drivers(2, 0)), kRounding);
    EXPECT_LT(largest_distance(here, shape.at(2, 0)), kRounding);
}

TEST(SecantPredictor, AnswersFartherFromWhereASolveBeganThanFromTheLastOneAreBadUntilOneIsNear) {
    const Shape shape;
    SecantPredictor predictor;
    begins(predictor, shape.at(0, 0), Shape::drivers(0, 0));
    EXPECT_TRUE(predictor.is_good());
    predictor.expect(shape.at(-1.1, 0));
    predictor.note(shape.at(1, 0), Shape::drivers(1, 0));
    EXPECT_FALSE(predictor.is_good());
    predictor.expect(shape.at(2.9, 0));
    predictor.note(shape.at(2, 0), Shape::drivers(2, 0));
    EXPECT_TRUE(predictor.is_good());
    predictor.expect(shape.at(9, 0));
    predictor.note(shape.at(3, 0), Shape::drivers(3, 0));
    EXPECT_FALSE(predictor.is_good());
    predictor.forget();
    begins(predictor, shape.at(0, 0), Shape::drivers(0, 0));
    EXPECT_TRUE(predictor.is_good());
}

TEST(SecantPredictor, AHandThatHasJustBegunIsPredictedFar) {
    const Shape shape;
    const auto found = predicted(shape, {{0, 0}, {0.01, 0}}, 0.5, 0.0);
    ASSERT_TRUE(found);
    EXPECT_LT(largest_distance(*found, shape.at(0.5, 0.0)), 100 * kRounding);
}

TEST(SecantPredictor, AChangeThatWasNotForeseenDoesNotLeadFar) {
    // As where the hand moves on in another direction and the shape comes to rest meanwhile.
    const Shape shape;
    for (const bool is_foreseen : {true, false}) {
        SecantPredictor predictor;
        begins(predictor, shape.at(0, 0), Shape::drivers(0, 0));
        predictor.expect(shape.at(is_foreseen ? 0.008 : 0.002, 0));
        Positions here = shape.at(0.01, 0);
        predictor.note(here, Shape::drivers(0.01, 0));
        const Positions gone = predictor.predict(Shape::drivers(0.5, 0), here, 1, Execution());
        EXPECT_EQ(gone == predictor.drivers(), !is_foreseen);
    }
    for (const bool is_sound : {true, false}) {
        SecantPredictor predictor;
        Positions here = shape.at(0, 0);
        begins(predictor, here, Shape::drivers(0, 0));
        predictor.suppose(shape.at(0.01, 0), Shape::drivers(0.01, 0), is_sound);
        const Positions gone = predictor.predict(Shape::drivers(0.5, 0), here, 1, Execution());
        EXPECT_EQ(gone == predictor.drivers(), !is_sound);
    }
}

TEST(SecantPredictor, ASoundChangeDoesNotLeadAnUnsoundOneFar) {
    const Shape shape;
    SecantPredictor predictor;
    begins(predictor, shape.at(0, 0), Shape::drivers(0, 0));
    predictor.note(shape.at(0.0095, 0.0031), Shape::drivers(0.0095, 0.0031));
    predictor.expect(shape.at(0.0095, 0.0031));
    Positions here = shape.at(0.0195, 0.0031);
    here.col(1).array() += 0.01;  // it came to rest meanwhile
    predictor.note(here, Shape::drivers(0.0195, 0.0031));
    Positions expected = here;
    predictor.predict(Shape::drivers(0.0195, 0.3), here, 1, Execution());
    EXPECT_LT(largest_distance(here, expected), 0.1);
}

TEST(SecantPredictor, AnOlderChangeThatGoesFarEnoughLeadsBeforeASmallOne) {
    // The small one is bent as if the end of a solve had gone on.
    const Shape shape;
    SecantPredictor predictor;
    begins(predictor, shape.at(0, 0), Shape::drivers(0, 0));
    predictor.note(shape.at(1, 0), Shape::drivers(1, 0));
    Positions here = shape.at(1.01, 0);
    here.col(1).array() += 0.001;
    predictor.note(here, Shape::drivers(1.01, 0));
    Positions expected = shape.at(2, 0);
    expected.col(1).array() += 0.001;
    predictor.predict(Shape::drivers(2, 0), here, 1, Execution());
    EXPECT_LT(largest_distance(here, expected), 1e-5);
}

TEST(SecantPredictor, ChangesAreKeptWhereADragBeginsAgainNearItsLastAnswer) {
    const Shape shape;
    for (const double off : {0.005, 0.5}) {
        SecantPredictor predictor;
        begins(predictor, shape.at(0, 0), Shape::drivers(0, 0));
        predictor.note(shape.at(1, 0), Shape::drivers(1, 0));
        predictor.end();
        Positions settled = shape.at(1, 0);
        settled.col(1).array() += off;
        EXPECT_FALSE(begins(predictor, settled, Shape::drivers(1, 0)));
        Positions expected = off < 0.01 ? shape.at(1.5, 0) : shape.at(1, 0);
        expected.col(1).array() += off;
        predictor.predict(Shape::drivers(1.5, 0), settled, 1, Execution());
        EXPECT_LT(largest_distance(settled, expected), kRounding) << off;
    }
}

TEST(SecantPredictor, WhatIsSupposedCountsUntilTheNextAnswer) {
    const Shape shape;
    SecantPredictor predictor;
    Positions here = shape.at(0, 0);
    begins(predictor, here, Shape::drivers(0, 0));
    EXPECT_FALSE(predictor.has_changes());
    predictor.suppose(1.1 * shape.at(1, 0), Shape::drivers(1, 0), true);
    EXPECT_TRUE(predictor.has_changes());
    predictor.predict(Shape::drivers(2, 0), here, 1, Execution());
    EXPECT_LT(largest_distance(here, 1.1 * shape.at(2, 0)), kRounding);
    here = shape.at(1, 0);
    predictor.note(here, Shape::drivers(1, 0));
    predictor.predict(Shape::drivers(2, 0), here, 1, Execution());
    EXPECT_LT(largest_distance(here, shape.at(2, 0)), kRounding);
}

TEST(SecantPredictor, WhatWasSupposedIsForgottenWhereTheSolveWasBrokenOff) {
    const Shape shape;
    SecantPredictor predictor;
    begins(predictor, shape.at(0, 0), Shape::drivers(0, 0));
    predictor.suppose(shape.at(1, 0), Shape::drivers(1, 0), true);
    begins(predictor, shape.at(0, 0), Shape::drivers(0, 0));
    EXPECT_FALSE(predictor.has_changes());
}

TEST(SecantPredictor, AnySizeIsPredicted) {
    const Shape shape;
    for (const double size : {1e-50, 1e50}) {
        SecantPredictor predictor(size);
        Positions here = size * shape.at(0, 0);
        begins(predictor, here, size * Shape::drivers(0, 0));
        here = size * shape.at(1, 0);
        predictor.note(here, size * Shape::drivers(1, 0));
        predictor.predict(size * Shape::drivers(2, 0), here, 1, Execution());
        EXPECT_LT(largest_distance(here, size * shape.at(2, 0)), kRounding * size);
    }
}

TEST(SecantPredictor, GivesTheSameBitsForAnyNumberOfThreads) {
    const Shape shape{0.2};
    const auto one = predicted(shape, {{0, 0}, {1, 0}, {1.5, 0.5}}, 2.0, 1.0, 1);
    EXPECT_EQ(one, predicted(shape, {{0, 0}, {1, 0}, {1.5, 0.5}}, 2.0, 1.0, 3));
}

}  // namespace
}  // namespace meanvalue::tests
