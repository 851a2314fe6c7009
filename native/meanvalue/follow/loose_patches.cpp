#include "meanvalue/follow/loose_patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>

#include "meanvalue/common/grouped.h"
#include "meanvalue/mesh/triangle_tree.h"

namespace meanvalue {
namespace {

// So many vertices stand for all of a part: more change little.
constexpr std::size_t kSample = 256;
// The rotation of a patch of fewer points is hardly determined.
constexpr std::size_t kLeastPoints = 24;
// Distances shorter than this share of a part's size are all alike: a single touching vertex does not decide alone,
// and a part whose box sticks out by less may be inside.
constexpr double kSoftDistance = 0.1;
// Only so many of the largest loose parts may contain others.
constexpr std::size_t kMostContainers = 256;

constexpr double kAnywhere = std::numeric_limits<double>::infinity();

using Box = Eigen::AlignedBox3d;

double size_of(const Box& box) {
    return box.diagonal().norm();
}

/// At most `most` of them, evenly.
std::vector<Index> some_of(const std::vector<Index>& vertices, std::size_t most) {
    if (vertices.size() <= most) return vertices;
    std::vector<Index> result;
    for (std::size_t k = 0; k < most; ++k)
        result.push_back(vertices[k * vertices.size() / most]);
    return result;
}

/// Each by itself, as a triangle of one point.
Triangles as_points(const std::vector<Index>& vertices) {
    return Eigen::Map<const Eigen::Matrix<Index, Eigen::Dynamic, 1>>(vertices.data(),
                                                                     static_cast<Eigen::Index>(vertices.size()))
        .replicate<1, 3>();
}

class Finder {
  public:
    Finder(const PositionsView& rest, const TrianglesView& faces, const Components& components,
           const Execution& execution)
        : rest_(rest),
          components_(components),
          execution_(execution),
          members_(components.parts.size()),
          boxes_(components.parts.size()),
          fixed_(rest, as_points(list_members()), components.part_of, execution) {
        list_neighbours(faces);
    }

    FoundPatches find() {
        FoundPatches found;
        found.carriers.assign(members_.size(), -1);
        found.patch_of_part.assign(members_.size(), -1);
        found.containers.assign(members_.size(), -1);
        std::vector<Index> loose;
        for (std::size_t part = 0; part < members_.size(); ++part) {
            if (is_loose(static_cast<Index>(part))) loose.push_back(static_cast<Index>(part));
        }
        // Larger ones first: what is inside of one finds its patch.
        std::stable_sort(loose.begin(), loose.end(),
                         [&](Index a, Index b) { return size_of(boxes_[a]) > size_of(boxes_[b]); });
        std::vector<Index> containers;
        for (const Index part : loose) {
            execution_.check();
            const Contacts contacts = contacts_of(part);
            const Index container = container_of(part, containers, contacts.least);
            found.containers[part] = container;
            if (container >= 0) {
                found.carriers[part] = found.carriers[container];
                found.patch_of_part[part] = found.patch_of_part[container];
            } else {
                found.carriers[part] = contacts.carrier;
                found.patch_of_part[part] = static_cast<Index>(found.patches.size());
                found.patches.push_back(patch_of(contacts));
            }
            if (members_[part].size() > 3 && containers.size() < kMostContainers) containers.push_back(part);
        }
        return found;
    }

  private:
    struct Contacts {
        Index carrier = -1;
        double least = kAnywhere;         // squared distance of vertices
        std::map<Index, double> weights;  // of vertices of the carrier
    };
    struct Nearest {
        Index row = -1;
        double squared_distance = kAnywhere;
    };
    struct FacePoint {
        std::array<Index, 3> corners;
        Vector3 shares;
        double squared_distance;
    };

    bool is_loose(Index part) const { return components_.fixed[part].empty(); }

    /// @return all vertices of fixed parts.
    std::vector<Index> list_members() {
        std::vector<Index> fixed;
        execution_.check();
        for (Index v = 0; v < rest_.rows(); ++v) {
            const Index part = components_.part_of[v];
            members_[part].push_back(v);
            boxes_[part].extend(rest_.row(v).transpose());
            if (!is_loose(part)) fixed.push_back(v);
        }
        return fixed;
    }

    void list_neighbours(const TrianglesView& faces) {
        neighbours_ = grouped<Index>(components_.part_of.size(), [&](const auto& visit) {
            execution_.check();
            for (Index f = 0; f < faces.rows(); ++f) {
                for (int c = 0; c < 3; ++c) {
                    visit(faces(f, c), faces(f, (c + 1) % 3));
                    visit(faces(f, c), faces(f, (c + 2) % 3));
                }
            }
        });
    }

    /// The vertex of a tree that is nearest to v, if any is no farther than the root of `square`.
    Nearest nearest_of(const TriangleTree& vertices, Index v, double square) const {
        const Vector3 point = rest_.row(v).transpose();
        // The root is rounded.
        const TriangleTree::Place place = vertices.nearest({point}, std::nextafter(std::sqrt(square), kAnywhere));
        const double found = place.triangle < 0 ? kAnywhere : (place.point - point).squaredNorm();
        return found <= square && place.triangle >= 0 ? Nearest{vertices.triangles()(place.triangle, 0), found}
                                                      : Nearest{};
    }

    Contacts contacts_of(Index part) const {
        const std::vector<Index> sample = some_of(members_[part], kSample);
        std::vector<Nearest> nearest;
        Contacts contacts;
        for (const Index v : sample) {
            execution_.check();
            nearest.push_back(nearest_of(fixed_, v, kAnywhere));
            if (nearest.back().squared_distance >= contacts.least) continue;
            contacts.least = nearest.back().squared_distance;
            contacts.carrier = components_.part_of[nearest.back().row];
        }
        std::vector<FacePoint> points;
        double least = kAnywhere;
        for (std::size_t k = 0; k < sample.size(); ++k) {
            execution_.check();
            if (components_.part_of[nearest[k].row] != contacts.carrier) continue;
            points.push_back(point_near(nearest[k], rest_.row(sample[k]).transpose()));
            least = std::min(least, points.back().squared_distance);
        }
        const double size = kSoftDistance * size_of(boxes_[part]);
        const double soft = size * size + least;
        for (const FacePoint& point : points) {
            const double nearness = soft > 0.0 ? soft / (point.squared_distance + soft) : 1.0;
            for (int c = 0; c < 3; ++c) {
                if (point.shares(c) > 0.0)
                    contacts.weights[point.corners[c]] += nearness * nearness * point.shares(c);
            }
        }
        return contacts;
    }

    /// The point of the faces at a vertex that is nearest to `point`; beyond the edges of a face, about.
    FacePoint point_near(const Nearest& vertex, const Vector3& point) const {
        FacePoint best{{vertex.row, vertex.row, vertex.row}, Vector3::UnitX(), vertex.squared_distance};
        const auto around = neighbours_.of(vertex.row);
        for (const Index* next = around.begin(); next != around.end(); next += 2) {  // two neighbors from each face
            const std::array<Index, 3> corners{vertex.row, next[0], next[1]};
            Matrix3 at;
            for (int c = 0; c < 3; ++c)
                at.col(c) = rest_.row(corners[c]).transpose();
            const Vector3 normal = (at.col(1) - at.col(0)).cross(at.col(2) - at.col(0));
            if (normal.isZero(0.0)) continue;
            Vector3 shares;  // area coordinates
            for (int c = 0; c < 3; ++c) {
                const Vector3 next = at.col((c + 1) % 3);
                shares(c) = std::max(0.0, (at.col((c + 2) % 3) - next).cross(point - next).dot(normal));
            }
            shares /= shares.sum();
            const double distance = (at * shares - point).squaredNorm();
            if (distance < best.squared_distance) best = {corners, shares, distance};
        }
        return best;
    }

    /// The smallest of the larger loose parts that `part` is inside of, and nearer to than `least`, a squared
    /// distance; or -1.
    Index container_of(Index part, const std::vector<Index>& containers, double least) {
        const std::vector<Index> sample = some_of(members_[part], kSample);
        for (auto container = containers.rbegin(); container != containers.rend(); ++container) {
            const Box& box = boxes_[*container];
            const Vector3 margin = Vector3::Constant(kSoftDistance * size_of(box));
            if (!Box(box.min() - margin, box.max() + margin).contains(boxes_[part])) continue;
            auto tree = trees_.find(*container);
            if (tree == trees_.end())
                tree = trees_
                           .try_emplace(*container, rest_, as_points(some_of(members_[*container], kSample)),
                                        components_.part_of, execution_)
                           .first;
            const auto is_near = [&](Index v) { return nearest_of(tree->second, v, least).row >= 0; };
            if (std::any_of(sample.begin(), sample.end(), is_near)) return *container;
        }
        return -1;
    }

    LoosePatch patch_of(const Contacts& contacts) const {
        LoosePatch patch;
        patch.contact = points_of(contacts.weights);
        patch.around = points_of(widened(contacts.weights));
        add_edges(patch);
        return patch;
    }

    WeightedPoints points_of(const std::map<Index, double>& weights) const {
        WeightedPoints result;
        double sum = 0.0;
        for (const auto& [v, weight] : weights)
            sum += weight;
        for (const auto& [v, weight] : weights) {
            result.points.push_back(v);
            result.weights.push_back(weight / sum);
        }
        result.centre = weighted_centre(result, rest_.data());
        return result;
    }

    /// By whole rings, each vertex counting half as much as what it was reached from, until there are enough.
    std::map<Index, double> widened(std::map<Index, double> weights) const {
        for (std::map<Index, double> border = weights; !border.empty() && weights.size() < kLeastPoints;) {
            std::map<Index, double> ring;
            for (const auto& [v, weight] : border) {
                for (const Index neighbour : neighbours_.of(v)) {
                    if (weights.count(neighbour) != 0) continue;
                    double& reached = ring[neighbour];
                    reached = std::max(reached, 0.5 * weight);
                }
            }
            weights.insert(ring.begin(), ring.end());
            border = std::move(ring);
        }
        return weights;
    }

    void add_edges(LoosePatch& patch) const {
        for (const Index v : patch.around.points) {
            for (const Index neighbour : neighbours_.of(v)) {
                const double length = (rest_.row(neighbour) - rest_.row(v)).norm();
                if (length == 0.0) continue;
                patch.edges.push_back({v, neighbour});
                patch.lengths.push_back(length);
            }
        }
    }

    const PositionsView& rest_;
    const Components& components_;
    const Execution& execution_;
    std::vector<std::vector<Index>> members_;  // of each part
    std::vector<Box> boxes_;
    TriangleTree fixed_;                   // of vertices
    std::map<Index, TriangleTree> trees_;  // of containers that any part was inside the box of
    Grouped<Index> neighbours_;            // of each vertex; those over inner edges are there twice
};

}  // namespace

FoundPatches find_patches(const PositionsView& rest, const TrianglesView& faces, const Components& components,
                          const Execution& execution) {
    return Finder(rest, faces, components, execution).find();
}

}  // namespace meanvalue
