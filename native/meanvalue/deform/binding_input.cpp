#include "meanvalue/deform/binding_input.h"

#include <cmath>
#include <iomanip>
#include <limits>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/physical_memory.h"

namespace meanvalue {
namespace {

constexpr double kMostRigidity = 1e9;  // beyond, single precision ends
constexpr double kMostStrength = 1e9;
constexpr double kInfinite = std::numeric_limits<double>::infinity();
// Of a point that is to be met: 1e-6 of the size is kept also where the pull is hard, and single precision still
// tells apart what the face's corners may do besides.
constexpr double kExactStrength = 1e5;
constexpr double kWeightRounding = 1e-6;
constexpr double kMostStiffness = 1e6;  // beside the rigidity that solves begin with: as kMostRigidity
// At the peak of a bind, for each free vertex: measured at 200,000 and a million (./dev bench size).
constexpr std::uint64_t kPeakBytes = 2700;

}  // namespace

double rigidity_of(const Binding& binding) {
    if (!binding.rigidity) return binding.method == Method::kFast ? kDefaultRigidity : 0.0;
    if (!(*binding.rigidity >= 0.0) || !std::isfinite(*binding.rigidity)) {
        throw InvalidInput(message("rigidity is ", *binding.rigidity, "; give 0 or a positive number"));
    }
    if (*binding.rigidity > 0.0 && binding.method != Method::kFast) {
        throw InvalidInput(
            message("rigidity is ", *binding.rigidity, "; only method 'fast' has one: give 0 or None to the others"));
    }
    if (*binding.rigidity > kMostRigidity) {
        throw InvalidInput(message("rigidity is ", *binding.rigidity, "; give at most ", kMostRigidity));
    }
    return *binding.rigidity;
}

void require_stiffness(const Binding& binding) {
    if (binding.stiffness.empty()) return;
    if (binding.method != Method::kFast) {
        throw InvalidInput("only method 'fast' has a stiffness: use it, or give None");
    }
    const std::vector<double>& factors = binding.stiffness;
    if (static_cast<Eigen::Index>(factors.size()) != binding.vertices->rows()) {
        throw InvalidInput(message("stiffness has ", factors.size(), " numbers, but there are ",
                                   binding.vertices->rows(), " vertices; give one number for each"));
    }
    for (std::size_t v = 0; v < factors.size(); ++v) {
        if (factors[v] >= 1.0 / kMostStiffness && factors[v] <= kMostStiffness) continue;
        throw InvalidInput(message("stiffness[", v, "] is ", factors[v], "; give a number from ",
                                   1.0 / kMostStiffness, " to ", kMostStiffness,
                                   ", 1 where it is as stiff as without"));
    }
}

Binding with_points_as_anchors(Binding binding) {
    const Index count = static_cast<Index>(binding.vertices->rows());
    std::vector<char> is_hard(count, 0);
    std::vector<char> is_taken(count, 0);
    for (std::size_t k = 0; k < binding.anchors.size(); ++k) {
        const Index v = binding.anchors[k];
        if (v < 0 || v >= count) return binding;
        is_hard[v] = k >= binding.strengths.size() || std::isinf(binding.strengths[k]) ? 1 : 0;
        is_taken[v] = 1;
    }
    if (binding.strengths.empty())
        binding.strengths.assign(binding.anchors.size() + binding.points.size(), kInfinite);
    if (!binding.is_border.empty() && binding.is_border.size() == binding.anchors.size())
        binding.is_border.resize(binding.anchors.size() + binding.points.size(), 0);
    for (std::size_t p = 0; p < binding.points.size(); ++p) {
        const auto refuse = [&](const auto&... why) { throw InvalidInput(message("points[", p, "]", why...)); };
        auto& [face, weights] = binding.points[p];
        if (binding.method != Method::kFast) refuse(": only method 'fast' has points: use it, or anchor vertices");
        if (face < 0 || face >= binding.faces->rows()) {
            refuse(" is in face ", face, ", but the mesh has ", binding.faces->rows(), " faces, numbered from 0");
        }
        if (!(weights.minCoeff() >= -kWeightRounding && std::abs(weights.sum() - 1.0) <= 3.0 * kWeightRounding)) {
            refuse(" has the weights (", weights[0], ", ", weights[1], ", ", weights[2],
                   "); give three from 0 to 1 that sum to 1");
        }
        weights /= weights.sum();
        Index at = -1;
        double most = -1.0;
        for (int corner = 0; corner < 3; ++corner) {
            const Index v = (*binding.faces)(face, corner);
            if (v < 0 || v >= count) return binding;
            if (is_hard[v] ||
                (binding.roi && static_cast<Index>(binding.roi->size()) == count && !(*binding.roi)[v])) {
                refuse(" is in face ", face, ", of which vertex ", v,
                       is_hard[v] ? " is an anchor that is met exactly" : " is outside the region of influence",
                       "; choose a face whose corners are free");
            }
            if (is_taken[v] || weights[corner] <= most) continue;
            at = v;
            most = weights[corner];
        }
        if (at < 0) refuse(" is in face ", face, ", whose three corners are taken by other anchors; leave it out");
        is_taken[at] = 1;
        binding.anchors.push_back(at);
        const std::size_t k = binding.anchors.size() - 1;
        if (k < binding.strengths.size() && binding.strengths[k] == kInfinite) binding.strengths[k] = kExactStrength;
    }
    return binding;
}

Positions offsets_of_points(const Binding& binding) {
    const auto count = static_cast<Eigen::Index>(binding.points.size());
    const auto first = static_cast<Eigen::Index>(binding.anchors.size()) - count;
    Positions offsets(count, 3);
    for (Eigen::Index p = 0; p < count; ++p) {
        const auto& [face, weights] = binding.points[p];
        const Eigen::RowVector3d from = binding.vertices->row(binding.anchors[first + p]);
        offsets.row(p).setZero();
        for (int corner = 0; corner < 3; ++corner)
            offsets.row(p) += weights[corner] * (binding.vertices->row((*binding.faces)(face, corner)) - from);
    }
    return offsets;
}

void require_memory(Index free_count, std::uint64_t there) {
    const std::uint64_t needed = kPeakBytes * static_cast<std::uint64_t>(free_count);
    if (needed <= there) return;
    constexpr double kGigabyte = 1e9;
    throw TooLittleMemory(message("binding ", free_count, " free vertices takes about ", std::setprecision(3),
                                  static_cast<double>(needed) / kGigabyte, " GB of memory, and this computer has ",
                                  static_cast<double>(there) / kGigabyte, " GB"));
}

std::vector<Index> handles_of_region(const Binding& binding, const Region& region) {
    if (binding.handles.empty()) return {};
    if (binding.handles.size() != binding.anchors.size()) {
        throw InvalidInput(message("handles has ", binding.handles.size(), " numbers, but there are ",
                                   binding.anchors.size(), " anchors; give one number for each"));
    }
    std::vector<Index> of_mesh(binding.vertices->rows(), -1);
    for (std::size_t k = 0; k < binding.anchors.size(); ++k) {
        if (binding.handles[k] < 0) {
            throw InvalidInput(message("handles[", k, "] is ", binding.handles[k], "; give numbers from 0"));
        }
        of_mesh[binding.anchors[k]] = binding.handles[k];
    }
    std::vector<Index> result;
    for (const Index v : region.vertices)
        result.push_back(of_mesh[v]);
    return result;
}

std::vector<char> soft_flags(const Binding& binding) {
    if (binding.strengths.empty()) return {};
    if (binding.strengths.size() != binding.anchors.size()) {
        throw InvalidInput(message("strengths has ", binding.strengths.size(), " numbers, but there are ",
                                   binding.anchors.size(), " anchors; give one number for each"));
    }
    std::vector<char> flags;
    for (std::size_t k = 0; k < binding.strengths.size(); ++k) {
        const double strength = binding.strengths[k];
        const Index v = binding.anchors[k];
        const auto refuse = [&](const auto&... why) {
            throw InvalidInput(message("strengths[", k, "], of vertex ", v, ", is ", strength, why...));
        };
        if (!(strength > 0.0)) refuse("; give a positive number, or infinity for an anchor that is met exactly");
        if (std::isinf(strength)) continue;
        if (binding.method != Method::kFast) {
            refuse("; only method 'fast' has soft anchors: use it, or give infinity or None");
        }
        if (strength > kMostStrength) {
            refuse("; give at most ", kMostStrength, ", or infinity for an anchor that is met exactly");
        }
        if (binding.roi && !(*binding.roi)[v]) {
            refuse(
                ", but lies outside the region of influence, where nothing is free; take it into the region, or give "
                "infinity for an anchor that is met exactly");
        }
        flags.resize(binding.vertices->rows(), 0);
        flags[v] = 1;
    }
    return flags;
}

std::vector<char> border_flags(const Binding& binding) {
    if (binding.is_border.size() != binding.anchors.size()) {
        throw InvalidInput(message("is_border has ", binding.is_border.size(), " flags, but there are ",
                                   binding.anchors.size(), " anchors; give one for each, or none"));
    }
    std::vector<char> flags(binding.vertices->rows(), 0);
    for (std::size_t k = 0; k < binding.anchors.size(); ++k) {
        if (!binding.is_border[k]) continue;
        if (binding.strengths.empty() || std::isinf(binding.strengths[k])) {
            throw InvalidInput(
                message("anchor ", k, " of the soft border is met exactly; give it a finite strength"));
        }
        flags[binding.anchors[k]] = 1;
    }
    return flags;
}

std::vector<SoftAnchor> soft_anchors_of_region(const Binding& binding, const std::vector<char>& is_soft,
                                               const Region& region) {
    if (is_soft.empty()) return {};
    std::vector<Index> anchor_of(is_soft.size(), -1);
    for (std::size_t k = 0; k < binding.anchors.size(); ++k)
        anchor_of[binding.anchors[k]] = static_cast<Index>(k);
    std::vector<SoftAnchor> result;
    for (std::size_t v = 0; v < region.vertices.size(); ++v) {
        if (!is_soft[region.vertices[v]]) continue;
        const Index k = anchor_of[region.vertices[v]];
        result.push_back({static_cast<Index>(v), k, binding.strengths[k]});
    }
    if (binding.points.empty()) return result;
    std::vector<Index> row_of(is_soft.size(), -1);
    for (std::size_t v = 0; v < region.vertices.size(); ++v)
        row_of[region.vertices[v]] = static_cast<Index>(v);
    const Positions offsets = offsets_of_points(binding);
    const std::size_t first = binding.anchors.size() - binding.points.size();
    for (SoftAnchor& anchor : result) {
        if (static_cast<std::size_t>(anchor.anchor) < first) continue;
        const auto& [face, weights] = binding.points[anchor.anchor - first];
        for (int corner = 0; corner < 3; ++corner)
            anchor.corners.push_back(row_of[(*binding.faces)(face, corner)]);
        anchor.weights = weights;
        anchor.offset = offsets.row(static_cast<Eigen::Index>(anchor.anchor - first));
    }
    return result;
}

}  // namespace meanvalue
