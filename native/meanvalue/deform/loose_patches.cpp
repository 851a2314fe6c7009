#include "meanvalue/deform/loose_patches.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "meanvalue/mesh/closest_point.h"
#include "meanvalue/mesh/point_tree.h"

namespace meanvalue {
namespace {

// Vertices of a loose part that look for what is near: more hardly tell it better.
constexpr std::size_t kLookouts = 256;
// A patch of fewer points hardly tells how it turns.
constexpr std::size_t kLeastPoints = 24;
// Nearness is told from distances no shorter than this share of the part's size, so that a single touching vertex
// does not decide alone.
constexpr double kSoftDistance = 0.1;
// Of a carrier, so many vertices tell how it grows, and the nearest of these tell a part.
constexpr std::size_t kMostStars = 2048;
constexpr std::size_t kStars = 32;
// Only so many of the largest loose parts may hold others inside.
constexpr std::size_t kMostShells = 256;
constexpr std::size_t kShellLookouts = 32;
constexpr std::size_t kShellPoints = 512;
// How far what is inside a box may stand out of it, as a share of the box.
constexpr double kStandsOut = 0.05;

struct Box {
    Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity());
    Vector3 high = Vector3::Constant(-std::numeric_limits<double>::infinity());

    double size() const { return (high - low).norm(); }
    bool holds(const Box& other, double margin) const {
        return ((other.low - low).array() >= -margin).all() && ((high - other.high).array() >= -margin).all();
    }
};

/// At most `most` of them, evenly.
std::vector<Index> some_of(const std::vector<Index>& vertices, std::size_t most) {
    if (vertices.size() <= most) return vertices;
    std::vector<Index> result;
    for (std::size_t k = 0; k < most; ++k)
        result.push_back(vertices[k * vertices.size() / most]);
    return result;
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
          held_(rest, list_members(), execution) {
        list_neighbours(faces);
    }

    FoundPatches find() {
        FoundPatches found;
        found.carriers.assign(members_.size(), -1);
        found.patch_of_part.assign(members_.size(), -1);
        std::vector<Index> loose;
        for (std::size_t part = 0; part < members_.size(); ++part) {
            if (is_loose(static_cast<Index>(part))) loose.push_back(static_cast<Index>(part));
        }
        // Larger ones first: what is inside of one finds its patch.
        std::stable_sort(loose.begin(), loose.end(),
                         [&](Index a, Index b) { return boxes_[a].size() > boxes_[b].size(); });
        std::vector<Index> shells;
        for (const Index part : loose) {
            execution_.check();
            const Contacts contacts = contacts_of(part);
            const Index shell = shell_of(part, shells, contacts.least);
            if (shell >= 0) {
                found.carriers[part] = found.carriers[shell];
                found.patch_of_part[part] = found.patch_of_part[shell];
            } else {
                found.carriers[part] = contacts.carrier;
                found.patch_of_part[part] = static_cast<Index>(found.patches.size());
                found.patches.push_back(patch_of(part, contacts));
            }
            if (members_[part].size() > 3 && shells.size() < kMostShells) shells.push_back(part);
        }
        return found;
    }

  private:
    struct Contacts {
        Index carrier = -1;
        double least = std::numeric_limits<double>::infinity();  // squared distance of vertices
        std::map<Index, double> weights;                         // of vertices of the carrier
    };
    struct Place {  // on a face
        std::array<Index, 3> corners;
        Vector3 shares;
        double squared_distance;
    };

    bool is_loose(Index part) const { return components_.fixed[part].empty(); }

    /// @return all vertices of held parts.
    std::vector<Index> list_members() {
        std::vector<Index> held;
        for (std::size_t v = 0; v < components_.part_of.size(); ++v) {
            execution_.check_every(v);
            const Index part = components_.part_of[v];
            members_[part].push_back(static_cast<Index>(v));
            boxes_[part].low = boxes_[part].low.cwiseMin(Vector3(rest_.row(static_cast<Index>(v))));
            boxes_[part].high = boxes_[part].high.cwiseMax(Vector3(rest_.row(static_cast<Index>(v))));
            if (!is_loose(part)) held.push_back(static_cast<Index>(v));
        }
        return held;
    }

    void list_neighbours(const TrianglesView& faces) {
        offsets_.assign(components_.part_of.size() + 1, 0);
        execution_.check();
        for (Index f = 0; f < faces.rows(); ++f) {
            for (int c = 0; c < 3; ++c)
                offsets_[faces(f, c) + 1] += 2;
        }
        std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
        neighbours_.resize(offsets_.back());
        std::vector<Index> filled(offsets_.begin(), offsets_.end() - 1);
        execution_.check();
        for (Index f = 0; f < faces.rows(); ++f) {
            for (int c = 0; c < 3; ++c) {
                neighbours_[filled[faces(f, c)]++] = faces(f, (c + 1) % 3);
                neighbours_[filled[faces(f, c)]++] = faces(f, (c + 2) % 3);
            }
        }
    }

    Contacts contacts_of(Index part) const {
        const std::vector<Index> lookouts = some_of(members_[part], kLookouts);
        std::vector<PointTree::Nearest> nearest;
        Contacts contacts;
        for (const Index v : lookouts) {
            execution_.check();
            nearest.push_back(held_.nearest(rest_.row(v).transpose()));
            if (nearest.back().squared_distance >= contacts.least) continue;
            contacts.least = nearest.back().squared_distance;
            contacts.carrier = components_.part_of[nearest.back().row];
        }
        std::vector<Place> places;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < lookouts.size(); ++k) {
            execution_.check();
            if (components_.part_of[nearest[k].row] != contacts.carrier) continue;
            places.push_back(place_near(nearest[k], rest_.row(lookouts[k]).transpose()));
            least = std::min(least, places.back().squared_distance);
        }
        const double size = kSoftDistance * boxes_[part].size();
        const double soft = size * size + least;
        for (const Place& place : places) {
            const double nearness = soft > 0.0 ? soft / (place.squared_distance + soft) : 1.0;
            for (int c = 0; c < 3; ++c) {
                if (place.shares(c) > 0.0)
                    contacts.weights[place.corners[c]] += nearness * nearness * place.shares(c);
            }
        }
        return contacts;
    }

    /// The place of the carrier's faces nearest to `point`: from those around the nearest vertex on to those around
    /// the corners of the nearest one, as long as that comes nearer.
    Place place_near(const PointTree::Nearest& vertex, const Vector3& point) const {
        Place best{{vertex.row, vertex.row, vertex.row}, Vector3::UnitX(), vertex.squared_distance};
        std::vector<Index> looked_around;
        for (bool is_nearer = true; is_nearer;) {
            const std::array<Index, 3> corners = best.corners;
            is_nearer = false;
            for (const Index v : corners) {
                if (std::find(looked_around.begin(), looked_around.end(), v) != looked_around.end()) continue;
                looked_around.push_back(v);
                is_nearer = look_around(v, point, best) || is_nearer;
            }
        }
        return best;
    }

    bool look_around(Index v, const Vector3& point, Place& best) const {
        bool is_nearer = false;
        for (Index j = offsets_[v]; j < offsets_[v + 1]; j += 2) {  // two neighbours from each face
            const std::array<Index, 3> corners{v, neighbours_[j], neighbours_[j + 1]};
            std::array<Vector3, 3> at;
            for (int c = 0; c < 3; ++c)
                at[c] = rest_.row(corners[c]).transpose();
            const Vector3 shares = closest_point(at, point);
            const double distance = (shares(0) * at[0] + shares(1) * at[1] + shares(2) * at[2] - point).squaredNorm();
            if (distance >= best.squared_distance) continue;
            best = {corners, shares, distance};
            is_nearer = true;
        }
        return is_nearer;
    }

    /// The smallest of the larger loose parts that `part` is inside of, and nearer to than `held`, a squared
    /// distance; or -1.
    Index shell_of(Index part, const std::vector<Index>& shells, double held) const {
        const std::vector<Index> lookouts = some_of(members_[part], kShellLookouts);
        for (auto shell = shells.rbegin(); shell != shells.rend(); ++shell) {
            if (!boxes_[*shell].holds(boxes_[part], kStandsOut * boxes_[*shell].size())) continue;
            for (const Index v : some_of(members_[*shell], kShellPoints)) {
                for (const Index from : lookouts) {
                    if ((rest_.row(v) - rest_.row(from)).squaredNorm() <= held) return *shell;
                }
            }
        }
        return -1;
    }

    LoosePatch patch_of(Index part, const Contacts& contacts) {
        LoosePatch patch;
        patch.contact = points_of(contacts.weights);
        patch.around = points_of(widened(contacts.weights));
        add_stars(0.5 * (boxes_[part].low + boxes_[part].high), contacts.carrier, patch);
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
                for (Index j = offsets_[v]; j < offsets_[v + 1]; ++j) {
                    if (weights.count(neighbours_[j]) != 0) continue;
                    double& reached = ring[neighbours_[j]];
                    reached = std::max(reached, 0.5 * weight);
                }
            }
            weights.insert(ring.begin(), ring.end());
            border = std::move(ring);
        }
        return weights;
    }

    void add_stars(const Vector3& centre, Index carrier, LoosePatch& patch) {
        std::vector<Index>& stars = stars_of(carrier);
        const std::size_t count = std::min(kStars, stars.size());
        std::vector<std::pair<double, Index>> near;
        near.reserve(stars.size());
        for (const Index v : stars)
            near.emplace_back((Vector3(rest_.row(v)) - centre).squaredNorm(), v);
        std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
        for (std::size_t k = 0; k < count; ++k) {
            const Index v = near[k].second;
            patch.middles.push_back(v);
            patch.stars.emplace_back(neighbours_.begin() + offsets_[v], neighbours_.begin() + offsets_[v + 1]);
            patch.star_lengths.push_back(length_around(v));
        }
    }

    double length_around(Index v) const {
        return star_length(v, neighbours_.data() + offsets_[v], neighbours_.data() + offsets_[v + 1], rest_.data());
    }

    /// Of those vertices of a held part that have edges with a length, some.
    std::vector<Index>& stars_of(Index part) {
        const auto [at, is_new] = stars_.try_emplace(part);
        if (is_new) {
            for (const Index v : some_of(members_[part], kMostStars)) {
                if (length_around(v) > 0.0) at->second.push_back(v);
            }
        }
        return at->second;
    }

    const PositionsView& rest_;
    const Components& components_;
    const Execution& execution_;
    std::vector<std::vector<Index>> members_;  // of each part
    std::vector<Box> boxes_;
    PointTree held_;
    std::vector<Index> offsets_;  // n + 1, into neighbours_; those over inner edges are there twice
    std::vector<Index> neighbours_;
    std::map<Index, std::vector<Index>> stars_;  // of carriers
};

}  // namespace

FoundPatches find_patches(const PositionsView& rest, const TrianglesView& faces, const Components& components,
                          const Execution& execution) {
    return Finder(rest, faces, components, execution).find();
}

}  // namespace meanvalue
