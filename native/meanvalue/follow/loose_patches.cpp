#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "meanvalue/follow/loose_parts.h"
#include "meanvalue/mesh/extent.h"

namespace meanvalue {
namespace {

// Shares of the carrier's size: buttons, eyes, teeth of a figure have diagonals of 0.008 to 0.04, shoes 0.11; what is
// held in a hand is 0.1 away, skirts 0.014.
constexpr double kSmallPart = 0.05;
constexpr double kFarPart = 0.08;
// Up to this share it may be a ball, as the eyes of a bust: beyond, it goes around its carrier. It is so near to its
// sphere, in radii.
constexpr double kLargestBall = 0.3;
constexpr double kBallRoughness = 0.06;
// So many vertices stand for all of a part: more change little.
constexpr std::size_t kSample = 256;
// The rotation of a patch of fewer points is hardly determined.
constexpr std::size_t kLeastPoints = 24;
// Distances shorter than this share of a part's size are all alike: a single touching vertex does not decide alone,
// and a part whose box sticks out by less may be inside.
constexpr double kSoftDistance = 0.1;
// Only so many of the largest rigid parts may contain others.
constexpr std::size_t kMostContainers = 256;

using Box = Eigen::AlignedBox3d;

double size_of(const Box& box) {
    return box.diagonal().norm();
}

bool is_ball(const Positions& points, const Vector3& middle) {
    const Eigen::ArrayXd distances = (points.rowwise() - middle.transpose()).rowwise().norm();
    return ((distances / distances.mean() - 1.0).square().mean()) <= kBallRoughness * kBallRoughness;
}

class Finder {
  public:
    Finder(const PositionsView& rest, const TrianglesView& faces, const Components& components,
           const Execution& execution)
        : rest_(rest),
          faces_(faces),
          components_(components),
          execution_(execution),
          members_(components.parts.size()),
          boxes_(components.parts.size()) {
        execution_.check();
        for (Index v = 0; v < rest_.rows(); ++v) {
            members_[components_.part_of[v]].push_back(v);
            boxes_[components_.part_of[v]].extend(rest_.row(v).transpose());
        }
    }

    FoundPatches find(const CarrierSurface& carrier, double size, FollowKind kind) {
        FoundPatches found;
        const std::size_t count = members_.size();
        found.carriers.assign(count, -1);
        found.is_cloth.assign(count, 0);
        found.patch_of_part.assign(count, -1);
        std::vector<char> is_carrier(count);
        std::vector<Index> loose, rigid, containers;
        for (std::size_t part = 0; part < count; ++part) {
            is_carrier[part] = components_.is_loose(static_cast<Index>(part)) ? 0 : 1;
            if (!is_carrier[part]) loose.push_back(static_cast<Index>(part));
        }
        // Larger ones first: what is inside of one finds its patch.
        std::stable_sort(loose.begin(), loose.end(),
                         [&](Index a, Index b) { return size_of(boxes_[a]) > size_of(boxes_[b]); });
        std::vector<Contacts> contacts(count);
        std::vector<Index> container(count, -1);
        for (const Index part : loose) {
            execution_.check();
            contacts[part] = contacts_of(part, carrier);
            found.carriers[part] = contacts[part].carrier;
            container[part] = container_of(part, containers, contacts[part].least);
            const bool may_be_cloth = members_[part].size() > 3 && kind != FollowKind::kRigid;
            if (may_be_cloth &&
                (kind == FollowKind::kCloth || (container[part] < 0 && drapes(part, contacts[part], size)))) {
                found.is_cloth[part] = is_carrier[part] = 1;
                continue;
            }
            rigid.push_back(part);
            if (members_[part].size() > 3 && containers.size() < kMostContainers) containers.push_back(part);
        }
        std::optional<CarrierSurface> dressed;
        if (!rigid.empty() && rigid.size() < loose.size())
            dressed.emplace(rest_, faces_, components_.part_of, is_carrier, execution_);
        for (const Index part : rigid) {
            execution_.check();
            if (container[part] >= 0) {
                found.carriers[part] = found.carriers[container[part]];
                found.patch_of_part[part] = found.patch_of_part[container[part]];
                continue;
            }
            if (dressed) contacts[part] = contacts_of(part, *dressed);
            found.carriers[part] = contacts[part].carrier;
            found.patch_of_part[part] = static_cast<Index>(found.patches.size());
            found.patches.push_back(patch_of(contacts[part], dressed ? *dressed : carrier));
        }
        return found;
    }

  private:
    struct Contacts {
        Index carrier = -1;
        double least = std::numeric_limits<double>::infinity();  // distance of vertices
        double median = 0.0;                                     // distance of the faces
        std::map<Index, double> weights;                         // of vertices of the carrier
    };

    std::vector<Index> sample_of(Index part) const {
        const std::size_t count = std::min(members_[part].size(), kSample);
        std::vector<Index> result;
        result.reserve(count);
        for (std::size_t k = 0; k < count; ++k)
            result.push_back(members_[part][k * members_[part].size() / count]);
        return result;
    }

    /// Whether a part is cloth by its shape and by how it lies: neither small beside its carrier nor far from it nor
    /// a ball.
    bool drapes(Index part, const Contacts& contacts, double size) const {
        const Positions points = rest_(members_[part], Eigen::all);
        const double diagonal = mean_diagonal(points, 1, execution_);
        return diagonal > kSmallPart * size && contacts.median <= kFarPart * size &&
               !(diagonal <= kLargestBall * size && is_ball(points, boxes_[part].center()));
    }

    Contacts contacts_of(Index part, const CarrierSurface& carrier) const {
        Contacts contacts;
        std::vector<SurfacePlace> places;
        std::vector<double> distances;
        for (const Index v : sample_of(part)) {
            const Vector3 point = rest_.row(v);
            places.push_back(carrier.nearest(point));
            distances.push_back((places.back().of(rest_.data()) - point).norm());
            for (const Index corner : places.back().corners) {
                const double distance = (point_at(rest_.data(), corner) - point).norm();
                if (distance >= contacts.least) continue;
                contacts.least = distance;
                contacts.carrier = components_.part_of[corner];
            }
        }
        const double least = *std::min_element(distances.begin(), distances.end());
        const double size = kSoftDistance * size_of(boxes_[part]);
        const double soft = size * size + least * least;
        for (std::size_t k = 0; k < places.size(); ++k) {
            if (components_.part_of[places[k].corners[0]] != contacts.carrier) continue;
            const double nearness = soft > 0.0 ? soft / (distances[k] * distances[k] + soft) : 1.0;
            for (int c = 0; c < 3; ++c) {
                if (places[k].weights(c) > 0.0)
                    contacts.weights[places[k].corners[c]] += nearness * nearness * places[k].weights(c);
            }
        }
        const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
        std::nth_element(distances.begin(), middle, distances.end());
        contacts.median = *middle;
        return contacts;
    }

    /// The smallest of the larger rigid parts that `part` is inside of, and nearer to than `least`; or -1.
    Index container_of(Index part, const std::vector<Index>& containers, double least) {
        const std::vector<Index> sample = sample_of(part);
        for (auto container = containers.rbegin(); container != containers.rend(); ++container) {
            const Box& box = boxes_[*container];
            const Vector3 margin = Vector3::Constant(kSoftDistance * size_of(box));
            if (!Box(box.min() - margin, box.max() + margin).contains(boxes_[part])) continue;
            auto tree = trees_.find(*container);
            if (tree == trees_.end()) {
                const std::vector<Index> points = sample_of(*container);
                const auto column = Eigen::Map<const Eigen::Matrix<Index, Eigen::Dynamic, 1>>(
                    points.data(), static_cast<Eigen::Index>(points.size()));
                tree =
                    trees_.try_emplace(*container, rest_, column.replicate<1, 3>(), components_.part_of, execution_)
                        .first;
            }
            const auto is_near = [&](Index v) {
                return tree->second.nearest({rest_.row(v).transpose()}, least).triangle >= 0;
            };
            if (std::any_of(sample.begin(), sample.end(), is_near)) return *container;
        }
        return -1;
    }

    LoosePatch patch_of(const Contacts& contacts, const CarrierSurface& carrier) const {
        const auto patch = [&](const std::map<Index, double>& weights) {
            std::vector<std::pair<double, Index>> weighted;
            weighted.reserve(weights.size());
            for (const auto& [v, weight] : weights)
                weighted.emplace_back(weight, v);
            return SurfacePatch(weighted, rest_.data());
        };
        LoosePatch result{patch(contacts.weights), patch(widened(contacts.weights, carrier)), {}};
        for (const SurfacePatch::Point& point : result.around.points) {
            for (const Index neighbour : carrier.fans().of(point.vertex))
                result.edges.add(point.vertex, neighbour, rest_.data());
        }
        return result;
    }

    /// By whole rings, each vertex counting half as much as what it was reached from, until there are enough.
    static std::map<Index, double> widened(std::map<Index, double> weights, const CarrierSurface& carrier) {
        for (std::map<Index, double> border = weights; !border.empty() && weights.size() < kLeastPoints;) {
            std::map<Index, double> ring;
            for (const auto& [v, weight] : border) {
                for (const Index neighbour : carrier.fans().of(v)) {
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

    const PositionsView& rest_;
    const TrianglesView& faces_;
    const Components& components_;
    const Execution& execution_;
    std::vector<std::vector<Index>> members_;  // of each part
    std::vector<Box> boxes_;
    std::map<Index, TriangleTree> trees_;  // of vertices of containers that any part was inside the box of
};

}  // namespace

FoundPatches find_patches(const PositionsView& rest, const TrianglesView& faces, const Components& components,
                          const CarrierSurface& carrier, double size, FollowKind kind, const Execution& execution) {
    return Finder(rest, faces, components, execution).find(carrier, size, kind);
}

}  // namespace meanvalue
