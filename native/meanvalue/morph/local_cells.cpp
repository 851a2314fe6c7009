#include "meanvalue/morph/local_cells.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/rest_cells.h"
#include "meanvalue/linalg/closest_rotation.h"
#include "meanvalue/morph/rotation_vectors.h"
#include "meanvalue/morph/unwrap_rotations.h"

namespace meanvalue {
namespace {

// Rounds of rotating all shapes of a cell onto their mean: the second changes what the first left of unlike cells.
constexpr int kAlignRounds = 3;
// Rounds for the rotations of shapes and the mean rotations of cells, each in terms of the other, and on how many
// cells, evenly drawn: it converges, and is a tenth of bind.
constexpr int kMeanRounds = 6;
constexpr Index kSample = 2000;

/// Rotates the edges of one cell in all shapes onto their mean. They count as in the energy: with cotangent
/// weights the rotation of a cell is that of the surface, however its edges lie.
/// @param edges `valence` x `count`, which are rotated.
void align_edges(Index valence, Vector3* edges, Index count) {
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
        closest_rotations(covariances.data(), count);
        for (Index place = 0; place < valence; ++place) {
            for (Index k = 0; k < count; ++k)
                edges[place * count + k] = covariances[k] * edges[place * count + k];
        }
    }
}

/// The cell to whose rotation an edge goes half-way: its own where the neighbour has no ring, and so no rotation.
Index bend_partner(const Encoding& layout, Index vertex, Index neighbour) {
    return layout.predictable(neighbour) ? neighbour : vertex;
}

}  // namespace

/// The rotations of all cells while they are sought.
struct LocalCells::Search {
    LocalCells& cells;
    const Encoding& layout;
    std::size_t count;  // of shapes
    int threads;
    const Execution& execution;
    Index stride;                   // between the vertices of the sample
    std::vector<Matrix3> of_cells;  // n x k: from the aligned edges to those of shape k
    std::vector<Matrix3> means;     // n: from the aligned edges of a cell to their mean over all shapes
    std::vector<Vector3> vectors;   // n x k: relative_rotation(), as rotation vectors

    Search(LocalCells& cells_, int threads_, const Execution& execution_)
        : cells(cells_),
          layout(cells_.layout_),
          count(cells_.shape_count_),
          threads(threads_),
          execution(execution_),
          stride(std::max<Index>(1, layout.vertex_count() / kSample)) {}

    /// Aligns the edges of each cell in all shapes, at size 1.
    void align_cells(const std::vector<PositionsView>& shapes) {
        std::vector<Vector3>& edges = cells.edges_;
        edges.resize(layout.ring.size() * count);
        for (std::size_t k = 0; k < count; ++k) {
            const RestCells rest = rest_cells(layout, shapes[k], threads, execution);
            double squares = 0.0;
            for (const Vector3& edge : rest.edges)
                squares += edge.squaredNorm();
            const double size = squares > 0.0 ? std::sqrt(squares / static_cast<double>(rest.edges.size())) : 1.0;
            cells.sizes_.push_back(size);
            for (std::size_t edge = 0; edge < rest.edges.size(); ++edge)
                edges[edge * count + k] = rest.edges[edge] / size;
        }
        of_cells.resize(layout.vertex_count() * count);
        parallel_for(layout.vertex_count(), threads, execution, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                const std::size_t first = layout.ring_offsets[v];
                const std::size_t last = layout.ring_offsets[v + 1];
                align_edges(static_cast<Index>(last - first), edges.data() + first * count,
                            static_cast<Index>(count));
                Matrix3* const of = of_cells.data() + v * count;
                std::fill_n(of, count, Matrix3::Zero());
                for (std::size_t place = first; place < last; ++place) {
                    for (std::size_t k = 0; k < count; ++k) {
                        const Vector3 edge = (shapes[k].row(v) - shapes[k].row(layout.ring[place])).transpose();
                        of[k] += edge * edges[place * count + k].transpose();
                    }
                }
                closest_rotations(of, static_cast<Index>(count));
            }
        });
    }

    /// Calls visit(v, its rotations in all shapes) for each cell of the sample.
    template <typename Visit>
    void for_each_sampled(const Visit& visit) const {
        execution.check();
        for (Index v = 0; v < layout.vertex_count(); v += stride) {
            if (layout.predictable(v)) visit(v, of_cells.data() + v * count);
        }
    }

    /// The shape that agrees best with all others, each rotated onto it as a whole: whatever the order of shapes is.
    std::size_t central_shape() const {
        std::vector<Matrix3> sums(count * count, Matrix3::Zero());
        for_each_sampled([&](Index, const Matrix3* of) {
            for (std::size_t a = 0; a < count; ++a) {
                for (std::size_t b = 0; b < count; ++b)
                    sums[a * count + b] += of[b] * of[a].transpose();
            }
        });
        std::vector<double> agreement(count, 0.0);
        for (std::size_t pair = 0; pair < sums.size(); ++pair)
            agreement[pair / count] += closest_rotation(sums[pair]).cwiseProduct(sums[pair]).sum();
        return std::max_element(agreement.begin(), agreement.end()) - agreement.begin();
    }

    void find_shape_rotations() {
        std::vector<Matrix3> sums(count, Matrix3::Zero());
        for_each_sampled([&](Index v, const Matrix3* of) {
            for (std::size_t k = 0; k < count; ++k)
                sums[k] += of[k] * means[v].transpose();
        });
        for (std::size_t k = 0; k < count; ++k)
            cells.shape_rotations_[k] = quaternion_of(closest_rotation(sums[k]));
    }

    /// From the mean of a cell to shape k, without the rotation of the whole shape.
    Matrix3 relative_rotation(Index vertex, std::size_t shape) const {
        return cells.shape_rotations_[shape].toRotationMatrix().transpose() * of_cells[vertex * count + shape] *
               means[vertex].transpose();
    }

    /// Has the rotation vectors of every `step`th cell sum to zero, by its mean.
    void centre_cells(Index step) {
        parallel_for((layout.vertex_count() + step - 1) / step, threads, execution, [&](Index begin, Index end) {
            std::vector<Matrix3> rotations(count);
            for (Index v = begin * step; v < std::min(end * step, layout.vertex_count()); v += step) {
                Vector3* const of_cell = vectors.data() + v * count;
                for (std::size_t k = 0; k < count; ++k) {
                    rotations[k] = relative_rotation(v, k);
                    of_cell[k] = rotation_vector(rotations[k], of_cell[k]);
                }
                means[v] = centre_rotations(rotations.data(), of_cell, static_cast<Index>(count)) * means[v];
            }
        });
    }

    /// The rotations of whole shapes and the means of cells, each in terms of the other, on a sample; then the means
    /// of all cells. It begins from the rotations of one shape, since a start has to be smooth over the mesh for
    /// branches to be followed.
    void find_rotations() {
        const Index vertices = layout.vertex_count();
        const std::size_t middle = central_shape();
        means.resize(vertices);
        for (Index v = 0; v < vertices; ++v)
            means[v] = of_cells[v * count + middle];
        cells.shape_rotations_.assign(count, Quaternion::Identity());
        find_shape_rotations();
        {
            std::vector<Matrix3> rotations(of_cells.size());
            parallel_for(vertices, threads, execution, [&](Index begin, Index end) {
                for (Index v = begin; v < end; ++v) {
                    for (std::size_t k = 0; k < count; ++k)
                        rotations[v * count + k] = relative_rotation(v, k);
                }
            });
            vectors = unwrap_rotations(layout, rotations, static_cast<Index>(count), execution);
        }
        for (int round = 1; round < kMeanRounds; ++round) {
            centre_cells(stride);
            find_shape_rotations();
        }
        centre_cells(1);
    }

    /// Takes the rotation of each edge's middle against its cell out of the edges.
    void take_out_bends() {
        std::vector<Quaternion> rotations(vectors.size());
        for (std::size_t k = 0; k < rotations.size(); ++k)
            rotations[k] = quaternion_by(vectors[k]);
        parallel_for(layout.vertex_count(), threads, execution, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                for (std::size_t place = layout.ring_offsets[v]; place < std::size_t(layout.ring_offsets[v + 1]);
                     ++place) {
                    const Index to = bend_partner(layout, v, layout.ring[place]);
                    for (std::size_t k = 0; k < count; ++k) {
                        const Quaternion bend = half_way(rotations[v * count + k], rotations[to * count + k]);
                        Vector3& edge = cells.edges_[place * count + k];
                        edge = bend.conjugate() * (means[v] * edge);
                    }
                }
            }
        });
    }
};

LocalCells::LocalCells(const Encoding& layout, const std::vector<PositionsView>& shapes, int threads,
                       const Execution& execution)
    : shape_count_(static_cast<Index>(shapes.size())), layout_(layout) {
    Search search(*this, threads, execution);
    search.align_cells(shapes);
    search.find_rotations();
    relative_.emplace(layout_, search.vectors, shape_count_, threads, execution);
    search.take_out_bends();
}

void LocalCells::fill(const ShapeWeights& weights, const std::vector<double>& sizes,
                      const std::vector<Quaternion>& frames, const Quaternion& rotation, int threads,
                      const Execution& execution, std::vector<Quaternion>& rotations, RestCells& cells) const {
    relative_->fill(weights, frames, rotation, threads, execution, rotations);
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
                cells.edges[place] =
                    half_way(rotations[v], rotations[bend_partner(layout_, v, layout_.ring[place])]) * sum;
            }
        }
    });
}

std::vector<double> LocalCells::common_sizes(const std::vector<double>& weights) const {
    const double common = geometric_mean(sizes_, weights);
    std::vector<double> result;
    for (const double size : sizes_)
        result.push_back(common / size);
    return result;
}

Quaternion LocalCells::mean_rotation(const std::vector<double>& weights) const {
    std::vector<Matrix3> rotations;
    std::vector<Vector3> vectors;
    // About the one that the others are rotated least against: another might lead to another branch.
    Matrix3 sum_of_all = Matrix3::Zero();
    for (const Quaternion& whole : shape_rotations_)
        sum_of_all += whole.toRotationMatrix();
    const auto agreement = [&](const Quaternion& whole) {
        return whole.toRotationMatrix().cwiseProduct(sum_of_all).sum();
    };
    const Matrix3 first =
        std::max_element(shape_rotations_.begin(), shape_rotations_.end(), [&](const auto& a, const auto& b) {
            return agreement(a) < agreement(b);
        })->toRotationMatrix();
    for (const Quaternion& whole : shape_rotations_) {
        rotations.emplace_back(whole.toRotationMatrix() * first.transpose());
        vectors.push_back(rotation_vector(rotations.back()));
    }
    const Matrix3 mean = centre_rotations(rotations.data(), vectors.data(), shape_count_) * first;
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < vectors.size(); ++k)
        sum += weights[k] * vectors[k];
    return quaternion_by(sum) * quaternion_of(mean);
}

std::vector<Quaternion> LocalCells::rotations(const std::vector<double>& weights, const std::vector<Index>& vertices,
                                              const Execution& execution) const {
    std::vector<Quaternion> result = relative_->find(weights, vertices, execution);
    const Quaternion whole = mean_rotation(weights);
    for (Quaternion& rotation : result)
        rotation = whole * rotation;
    return result;
}

}  // namespace meanvalue
