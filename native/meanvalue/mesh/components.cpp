#include "meanvalue/mesh/components.h"

#include <numeric>

#include <Eigen/Geometry>

namespace meanvalue {
namespace {

// Three points are collinear when the third is off the line of the two farthest by less than this share of
// their distance: below it, the turn about that line is lost in rounding.
constexpr double kCollinearity = 1e-6;

class DisjointSets {
  public:
    explicit DisjointSets(Index count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

    Index root(Index item) {
        while (parent_[item] != item) {
            parent_[item] = parent_[parent_[item]];
            item = parent_[item];
        }
        return item;
    }

    /// The lower root stays root, so that a set is named by its lowest member.
    void join(Index a, Index b) {
        a = root(a);
        b = root(b);
        if (a < b) {
            parent_[b] = a;
        } else {
            parent_[a] = b;
        }
    }

  private:
    std::vector<Index> parent_;
};

/// @param fixed the numbers of the fixed vertices of one part.
int undetermined_dimensions(const PositionsView& positions, const std::vector<Index>& fixed) {
    if (fixed.empty()) return 7;
    const Vector3 first = positions.row(fixed.front());
    Vector3 axis = Vector3::Zero();
    for (const Index v : fixed) {
        const Vector3 offset = Vector3(positions.row(v)) - first;
        if (offset.squaredNorm() > axis.squaredNorm()) axis = offset;
    }
    if (axis.squaredNorm() == 0.0) return 4;
    for (const Index v : fixed) {
        const Vector3 offset = Vector3(positions.row(v)) - first;
        if (axis.cross(offset).norm() > kCollinearity * axis.squaredNorm()) return 0;
    }
    return 1;
}

}  // namespace

std::vector<Component> find_components(const PositionsView& positions, const TrianglesView& faces,
                                       const std::vector<char>& is_fixed) {
    const Index vertex_count = static_cast<Index>(positions.rows());
    DisjointSets sets(vertex_count);
    for (Index f = 0; f < faces.rows(); ++f) {
        sets.join(faces(f, 0), faces(f, 1));
        sets.join(faces(f, 1), faces(f, 2));
    }
    std::vector<Index> component_of(vertex_count, -1);
    std::vector<Component> components;
    std::vector<std::vector<Index>> fixed;
    for (Index v = 0; v < vertex_count; ++v) {
        Index& number = component_of[sets.root(v)];
        if (number < 0) {
            number = static_cast<Index>(components.size());
            components.emplace_back();
            components.back().first_vertex = v;
            fixed.emplace_back();
        }
        Component& component = components[number];
        ++component.vertex_count;
        if (is_fixed[v]) {
            ++component.fixed_count;
            fixed[number].push_back(v);
        } else {
            ++component.free_count;
        }
    }
    for (std::size_t k = 0; k < components.size(); ++k) {
        components[k].undetermined = undetermined_dimensions(positions, fixed[k]);
    }
    return components;
}

}  // namespace meanvalue
