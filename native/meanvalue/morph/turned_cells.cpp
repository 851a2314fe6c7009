#include "meanvalue/morph/turned_cells.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/decode/fast/row_energy.h"
#include "meanvalue/linalg/closest_rotation.h"
#include "meanvalue/morph/rotation_vectors.h"
#include "meanvalue/morph/turn_branches.h"

namespace meanvalue {
namespace {

// Rounds of turning all shapes of a cell onto their mean: the second changes what the first left of unlike cells.
constexpr int kAlignRounds = 3;
// Of the turns of the wholes and the mean turns of cells, each in terms of the other, on so many cells, evenly drawn.
constexpr int kWholeRounds = 6;
constexpr Index kSample = 2000;

/// base^exponent for any exponent of moderate size.
double any_power(double base, double exponent) {
    const double parts = std::ceil(std::max(1.0, std::abs(exponent)));
    const double part = power(base, exponent / parts);
    double result = 1.0;
    for (int k = 0; k < static_cast<int>(parts); ++k)
        result *= part;
    return result;
}

/// Turns the edges of one cell in all shapes onto their mean. They count as in the energy: with cotangent weights the
/// turn of a cell is that of the surface, however its edges lie.
/// @param edges `valence` x `count`, which are turned.
void align(Index valence, Vector3* edges, Index count) {
    std::vector<Vector3> means(valence);
    std::vector<Spoke> spokes(valence);
    std::vector<Matrix3> covariances(count);
    for (int round = 0; round < kAlignRounds && count > 1 && valence > 0; ++round) {
        for (Index place = 0; place < valence; ++place) {
            means[place].setZero();
            for (Index k = 0; k < count; ++k)
                means[place] += edges[place * count + k] / count;
        }
        measure_spokes(means.data(), valence, spokes.data());
        std::fill(covariances.begin(), covariances.end(), Matrix3::Zero());
        for (Index place = 0; place < valence; ++place) {
            const Index next = place + 1 == valence ? 0 : place + 1;
            const Vector3 spoke = spokes[place].spoke * means[place];
            const Vector3 rim = spokes[place].rim * (means[place] - means[next]);
            for (Index k = 0; k < count; ++k) {
                const Vector3& edge = edges[place * count + k];
                covariances[k] += spoke * edge.transpose() + rim * (edge - edges[next * count + k]).transpose();
            }
        }
        for (Index k = 0; k < count; ++k) {
            const Matrix3 turn = closest_rotation(covariances[k]);
            for (Index place = 0; place < valence; ++place)
                edges[place * count + k] = turn * edges[place * count + k];
        }
    }
}

/// From a cell's frame to one half-way to a neighbour's. Beyond a quarter of a turn between them it goes back to the
/// cell's own, so that it is smooth also where half-way is ambiguous.
Quaternion half_way(const Quaternion& own, const Quaternion& other) {
    Quaternion relative = own.conjugate() * other;
    const double cosine = relative.w();
    relative.vec() *= cosine;
    relative.w() = 1.0 + cosine * cosine;
    return relative.normalized();
}

}  // namespace

struct TurnedCells::Turns {
    std::vector<Matrix3> of_cells;  // n x k: from the aligned edges to those of shape k
    std::vector<Matrix3> means;     // n: what the aligned edges of a cell have to be turned by
    std::vector<Vector3> vectors;   // n x k: turn_of(), as rotation vectors
};

TurnedCells::TurnedCells(const Encoding& layout, const std::vector<PositionsView>& shapes, int threads,
                         const Execution& execution)
    : shape_count_(static_cast<Index>(shapes.size())), layout_(layout) {
    Turns turns = align_cells(shapes, threads, execution);
    find_turns(turns, threads, execution);
    relations_.emplace(layout_, turns.vectors, shape_count_, threads, execution);
    bend_back(turns, threads, execution);
}

/// Turns the edges of each cell onto each other, at size 1.
TurnedCells::Turns TurnedCells::align_cells(const std::vector<PositionsView>& shapes, int threads,
                                            const Execution& execution) {
    const auto count = static_cast<std::size_t>(shape_count_);
    edges_.resize(layout_.ring.size() * count);
    for (std::size_t k = 0; k < count; ++k) {
        const RestCells cells = rest_cells(layout_, shapes[k], threads, execution);
        double squares = 0.0;
        for (std::size_t edge = 0; edge < cells.edges.size(); ++edge) {
            execution.check_every(edge);
            squares += cells.edges[edge].squaredNorm();
        }
        const double size = squares > 0.0 ? std::sqrt(squares / static_cast<double>(cells.edges.size())) : 1.0;
        sizes_.push_back(size);
        for (std::size_t edge = 0; edge < cells.edges.size(); ++edge)
            edges_[edge * count + k] = cells.edges[edge] / size;
    }
    Turns turns;
    turns.of_cells.assign(layout_.vertex_count() * count, Matrix3::Identity());
    turns.means.assign(layout_.vertex_count(), Matrix3::Identity());
    parallel_for(layout_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const std::size_t first = layout_.ring_offsets[v];
            const std::size_t last = layout_.ring_offsets[v + 1];
            align(layout_.ring_offsets[v + 1] - layout_.ring_offsets[v], edges_.data() + first * count, shape_count_);
            for (std::size_t k = 0; k < count; ++k) {
                Matrix3 covariance = Matrix3::Zero();
                for (std::size_t place = first; place < last; ++place) {
                    const Vector3 edge = (shapes[k].row(v) - shapes[k].row(layout_.ring[place])).transpose();
                    covariance += edge * edges_[place * count + k].transpose();
                }
                turns.of_cells[v * count + k] = closest_rotation(covariance);
            }
        }
    });
    return turns;
}

/// The shape that agrees best with all others, each turned onto it as a whole: whatever the order of shapes is.
std::size_t TurnedCells::middle_of(const Turns& turns, Index stride, const Execution& execution) const {
    const auto count = static_cast<std::size_t>(shape_count_);
    std::vector<Matrix3> sums(count * count, Matrix3::Zero());
    for (Index v = 0; v < layout_.vertex_count(); v += stride) {
        execution.check_every(v);
        if (!layout_.predictable(v)) continue;
        const Matrix3* const of = turns.of_cells.data() + v * count;
        for (std::size_t a = 0; a < count; ++a) {
            for (std::size_t b = 0; b < count; ++b)
                sums[a * count + b] += of[b] * of[a].transpose();
        }
    }
    std::vector<double> agreement(count, 0.0);
    for (std::size_t pair = 0; pair < sums.size(); ++pair)
        agreement[pair / count] += closest_rotation(sums[pair]).cwiseProduct(sums[pair]).sum();
    return std::max_element(agreement.begin(), agreement.end()) - agreement.begin();
}

void TurnedCells::find_wholes(const Turns& turns, Index stride, const Execution& execution) {
    const auto count = static_cast<std::size_t>(shape_count_);
    std::vector<Matrix3> sums(count, Matrix3::Zero());
    for (Index v = 0; v < layout_.vertex_count(); v += stride) {
        execution.check_every(v);
        if (!layout_.predictable(v)) continue;
        for (std::size_t k = 0; k < count; ++k)
            sums[k] += turns.of_cells[v * count + k] * turns.means[v].transpose();
    }
    for (std::size_t k = 0; k < count; ++k)
        wholes_[k] = quaternion_of(closest_rotation(sums[k]));
}

/// What turns the mean of a cell to shape k, less the whole.
Matrix3 TurnedCells::turn_of(const Turns& turns, Index vertex, std::size_t shape) const {
    return wholes_[shape].toRotationMatrix().transpose() * turns.of_cells[vertex * wholes_.size() + shape] *
           turns.means[vertex].transpose();
}

void TurnedCells::centre_cells(Turns& turns, Index stride, int threads, const Execution& execution) const {
    const auto count = static_cast<std::size_t>(shape_count_);
    const Index cells = (layout_.vertex_count() + stride - 1) / stride;
    parallel_for(cells, threads, execution, [&](Index begin, Index end) {
        std::vector<Matrix3> rotations(count);
        for (Index cell = begin; cell < end; ++cell) {
            const Index v = cell * stride;
            Vector3* const vectors = turns.vectors.data() + v * count;
            for (std::size_t k = 0; k < count; ++k) {
                rotations[k] = turn_of(turns, v, k);
                vectors[k] = rotation_vector(rotations[k], vectors[k]);
            }
            turns.means[v] = centre_turns(rotations.data(), vectors, shape_count_) * turns.means[v];
        }
    });
}

/// The wholes and the means of cells, each in terms of the other, on a sample; then all cells by these wholes. It
/// begins from the turns of one shape, since a start has to be smooth over the mesh for branches to be followed.
void TurnedCells::find_turns(Turns& turns, int threads, const Execution& execution) {
    const auto count = static_cast<std::size_t>(shape_count_);
    const Index vertices = layout_.vertex_count();
    const Index stride = std::max<Index>(1, vertices / kSample);
    const std::size_t middle = middle_of(turns, stride, execution);
    for (Index v = 0; v < vertices; ++v)
        turns.means[v] = turns.of_cells[v * count + middle];
    wholes_.assign(count, Quaternion::Identity());
    find_wholes(turns, stride, execution);
    {
        std::vector<Matrix3> rotations(turns.of_cells.size());
        parallel_for(vertices, threads, execution, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                for (std::size_t k = 0; k < count; ++k)
                    rotations[v * count + k] = turn_of(turns, v, k);
            }
        });
        turns.vectors = follow_turns(layout_, rotations, shape_count_, execution);
    }
    for (int round = 1; round < kWholeRounds; ++round) {
        centre_cells(turns, stride, threads, execution);
        find_wholes(turns, stride, execution);
    }
    centre_cells(turns, 1, threads, execution);
}

/// Which cell an edge goes half-way to: its own where the neighbour has no ring, and so no turn.
Index TurnedCells::turned_to(Index vertex, Index neighbour) const {
    return layout_.predictable(neighbour) ? neighbour : vertex;
}

/// Takes the turn of each edge's middle against its cell out of the edges.
void TurnedCells::bend_back(const Turns& turns, int threads, const Execution& execution) {
    const auto count = static_cast<std::size_t>(shape_count_);
    std::vector<Quaternion> rotations(turns.vectors.size());
    for (std::size_t k = 0; k < rotations.size(); ++k)
        rotations[k] = quaternion_by(turns.vectors[k]);
    parallel_for(layout_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            for (std::size_t place = layout_.ring_offsets[v]; place < std::size_t(layout_.ring_offsets[v + 1]);
                 ++place) {
                const Index to = turned_to(v, layout_.ring[place]);
                for (std::size_t k = 0; k < count; ++k) {
                    const Quaternion bend = half_way(rotations[v * count + k], rotations[to * count + k]);
                    Vector3& edge = edges_[place * count + k];
                    edge = bend.conjugate() * (turns.means[v] * edge);
                }
            }
        }
    });
}

void TurnedCells::fill(const ShapeWeights& weights, const std::vector<double>& sizes,
                       const std::vector<Quaternion>& frames, const Quaternion& turn, int threads,
                       const Execution& execution, std::vector<Quaternion>& rotations, RestCells& cells) const {
    relations_->fill(weights, frames, turn, threads, execution, rotations);
    const auto count = static_cast<std::size_t>(shape_count_);
    cells.edges.resize(layout_.ring.size());
    std::vector<double> factors(count);
    for (std::size_t k = 0; k < count; ++k)
        factors[k] = sizes[k] * sizes_[k];
    parallel_for(layout_.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const double* const of = weights.of(v);
            for (std::size_t place = layout_.ring_offsets[v]; place < std::size_t(layout_.ring_offsets[v + 1]);
                 ++place) {
                Vector3 sum = Vector3::Zero();
                for (std::size_t k = 0; k < count; ++k)
                    sum += (of[k] * factors[k]) * edges_[place * count + k];
                cells.edges[place] = half_way(rotations[v], rotations[turned_to(v, layout_.ring[place])]) * sum;
            }
        }
    });
}

std::vector<double> TurnedCells::common_sizes(const std::vector<double>& weights) const {
    const double common = geometric_mean(sizes_, weights.data());
    std::vector<double> result;
    for (const double size : sizes_)
        result.push_back(common / size);
    return result;
}

Quaternion TurnedCells::whole_turn(const std::vector<double>& weights) const {
    std::vector<Matrix3> rotations;
    std::vector<Vector3> vectors;
    // About the one that the others are turned least against: another might lead to another branch.
    Matrix3 sum_of_all = Matrix3::Zero();
    for (const Quaternion& whole : wholes_)
        sum_of_all += whole.toRotationMatrix();
    const auto agreement = [&](const Quaternion& whole) {
        return whole.toRotationMatrix().cwiseProduct(sum_of_all).sum();
    };
    const Matrix3 first = std::max_element(wholes_.begin(), wholes_.end(), [&](const auto& a, const auto& b) {
                              return agreement(a) < agreement(b);
                          })->toRotationMatrix();
    for (const Quaternion& whole : wholes_) {
        rotations.emplace_back(whole.toRotationMatrix() * first.transpose());
        vectors.push_back(rotation_vector(rotations.back()));
    }
    const Matrix3 mean = centre_turns(rotations.data(), vectors.data(), shape_count_) * first;
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < vectors.size(); ++k)
        sum += weights[k] * vectors[k];
    return quaternion_by(sum) * quaternion_of(mean);
}

std::vector<Quaternion> TurnedCells::turns(const std::vector<double>& weights, const std::vector<Index>& vertices,
                                           const Execution& execution) const {
    std::vector<Quaternion> result = relations_->find(weights, vertices, execution);
    const Quaternion whole = whole_turn(weights);
    for (Quaternion& turn : result)
        turn = whole * turn;
    return result;
}

double TurnedCells::geometric_mean(const std::vector<double>& values, const double* weights) {
    double result = 1.0;
    for (std::size_t k = 0; k < values.size(); ++k)
        result *= any_power(values[k], weights[k]);
    return result;
}

std::size_t TurnedCells::bytes() const {
    return edges_.capacity() * sizeof(Vector3) + relations_->bytes();
}

}  // namespace meanvalue
