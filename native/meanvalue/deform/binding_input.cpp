#include "meanvalue/deform/binding_input.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numeric>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/physical_memory.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/extent.h"

namespace meanvalue {
namespace {

constexpr double kMostRigidity = 1e9;  // beyond, single precision ends
constexpr double kMostStrength = 1e9;
constexpr double kMostStiffness = 1e6;  // beside the rigidity that solves begin with: as kMostRigidity
// At the peak of a bind, for each free vertex: measured at 200,000 and a million (./dev bench size).
constexpr std::uint64_t kPeakBytes = 2700;

// Examples beyond this size over the rest shape's, or one over it, are in other units.
constexpr double kMostScale = 10.0;

/// The root mean square of all edges: the same however a shape is rotated.
double edge_size(const PositionsView& shape, const TrianglesView& faces) {
    double sum = 0.0;
    for (Index f = 0; f < faces.rows(); ++f) {
        for (int c = 0; c < 3; ++c)
            sum += (shape.row(faces(f, c)) - shape.row(faces(f, (c + 1) % 3))).squaredNorm();
    }
    return faces.rows() > 0 ? std::sqrt(sum / static_cast<double>(3 * faces.rows())) : 0.0;
}

/// Whether one is the other, rotated and moved.
bool are_same(const PositionsView& a, const PositionsView& b, double diagonal, const std::vector<Index>& vertices) {
    Similarity motion = fit_similarity(a, b, vertices);
    if (std::abs(motion.scale - 1.0) > kCoincident) return false;
    return std::all_of(vertices.begin(), vertices.end(), [&](Index v) {
        return (motion.apply(a.row(v).transpose()) - b.row(v).transpose()).norm() <= kCoincident * diagonal;
    });
}

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
    require_count("stiffness", factors.size(), "number", binding.vertices->rows(), "vertices");
    for (std::size_t v = 0; v < factors.size(); ++v) {
        if (factors[v] >= 1.0 / kMostStiffness && factors[v] <= kMostStiffness) continue;
        throw InvalidInput(message("stiffness[", v, "] is ", factors[v], "; give a number from ",
                                   1.0 / kMostStiffness, " to ", kMostStiffness, ", as a rule 1"));
    }
}

void require_examples(const Binding& binding) {
    if (binding.examples.empty()) return;
    if (binding.method != Method::kFast) {
        throw InvalidInput("examples are given, but only method 'fast' knows them; use it, or leave them out");
    }
    const Positions& rest = *binding.vertices;
    const Triangles& faces = *binding.faces;
    std::vector<Index> vertices(rest.rows());
    std::iota(vertices.begin(), vertices.end(), 0);
    const double diagonal = bounding_box_diagonal(rest);
    std::vector<double> sizes(1, edge_size(rest, faces));
    const bool has_inside = is_closed(rest, faces);
    const double volume = signed_volume(rest, faces);
    for (std::size_t k = 0; k < binding.examples.size(); ++k) {
        const Positions& example = *binding.examples[k];
        const std::string name = message("examples[", k, "]");
        if (example.rows() != rest.rows()) {
            throw InvalidInput(message(name, " has ", example.rows(), " vertices, but the mesh has ", rest.rows(),
                                       "; give shapes of this mesh"));
        }
        require_finite(example, name.c_str());
        require_moderate_extent(example);
        sizes.push_back(edge_size(example, faces));
        if (!(sizes.back() <= kMostScale * sizes.front() && kMostScale * sizes.back() >= sizes.front())) {
            throw InvalidInput(message(name, " is ", sizes.back() / sizes.front(),
                                       " times as large as the rest shape; give it in the same units"));
        }
        if (has_inside && volume * signed_volume(example, faces) < 0.0) {
            throw InvalidInput(message(name, " is mirrored, or inside out; mirror it back along one axis"));
        }
        for (std::size_t other = 0; other <= k; ++other) {
            if (std::abs(sizes[other] - sizes.back()) > kCoincident * sizes.back()) continue;
            const Positions& earlier = other == 0 ? rest : *binding.examples[other - 1];
            if (!are_same(earlier, example, diagonal, vertices)) continue;
            throw InvalidInput(
                other == 0 ? message(name, " is the rest shape; leave it out")
                           : message(name, " is the same shape as examples[", other - 1, "]; leave one of them out"));
        }
    }
}

void require_memory(Index free_count, std::uint64_t there) {
    const std::uint64_t needed = kPeakBytes * static_cast<std::uint64_t>(free_count);
    if (needed <= there) return;
    constexpr double kGigabyte = 1e9;
    throw TooLittleMemory(message("binding ", free_count, " free vertices takes about ", std::setprecision(3),
                                  static_cast<double>(needed) / kGigabyte, " GB of memory, and this computer has ",
                                  static_cast<double>(there) / kGigabyte, " GB"));
}

std::vector<char> soft_flags(const Binding& binding) {
    if (binding.strengths.empty()) return {};
    require_count("strengths", binding.strengths.size(), "number", binding.anchors.size(), "anchors");
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
    require_count("is_border", binding.is_border.size(), "flag", binding.anchors.size(), "anchors");
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

}  // namespace meanvalue
