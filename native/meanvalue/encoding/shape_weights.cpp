#include "meanvalue/encoding/shape_weights.h"

#include <cmath>
#include <string>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

// Weights that nearly cancel each other would be blown up by dividing by their sum.
constexpr double kLeastSum = 1e-3;

/// Divides `count` weights by their sum. @param whose for the message.
void normalise(double* weights, Index count, const std::string& whose) {
    double sum = 0.0;
    double size = 0.0;
    for (Index k = 0; k < count; ++k) {
        sum += weights[k];
        size += std::abs(weights[k]);
    }
    if (size == 0.0)
        throw InvalidInput(message("all ", count, " weights", whose, " are 0; give one of them a value"));
    if (!(std::abs(sum) > kLeastSum * size)) {
        throw InvalidInput(message("the ", count, " weights", whose, " sum to ", sum,
                                   ", and cancel each other; give ", "such that sum to about 1"));
    }
    for (Index k = 0; k < count; ++k)
        weights[k] /= sum;
}

}  // namespace

ShapeWeights::ShapeWeights(const std::vector<double>& values, Index shape_count, Index vertex_count)
    : shape_count_(shape_count), is_uniform_(values.size() == static_cast<std::size_t>(shape_count)) {
    const std::size_t all = static_cast<std::size_t>(shape_count) * vertex_count;
    if (!is_uniform_ && values.size() != all) {
        throw InvalidInput(message("weights has ", values.size(), " numbers, but there are ", shape_count,
                                   " shapes of ", vertex_count, " vertices; give one for each shape, or ", all));
    }
    for (std::size_t k = 0; k < values.size(); ++k) {
        if (std::isfinite(values[k])) continue;
        const std::size_t shape = is_uniform_ ? k : k / vertex_count;
        throw InvalidInput(message("the weight of shape ", shape,
                                   is_uniform_ ? std::string() : message(" at vertex ", k % vertex_count), " is ",
                                   values[k], "; give a number"));
    }
    values_.resize(values.size());
    mean_.assign(shape_count, 0.0);
    const Index rows = is_uniform_ ? 1 : vertex_count;
    for (Index v = 0; v < rows; ++v) {
        double* const row = values_.data() + static_cast<std::size_t>(v) * shape_count;
        for (Index k = 0; k < shape_count; ++k)
            row[k] = values[static_cast<std::size_t>(k) * rows + v];
        normalise(row, shape_count, is_uniform_ ? "" : message(" at vertex ", v));
        for (Index k = 0; k < shape_count; ++k)
            mean_[k] += row[k] / rows;
    }
}

double geometric_mean(const std::vector<double>& values, const std::vector<double>& weights) {
    double result = 1.0;
    for (std::size_t k = 0; k < values.size(); ++k)
        result *= power(values[k], weights[k]);
    return result;
}

}  // namespace meanvalue
