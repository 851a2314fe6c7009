#include "meanvalue/deform/example_input.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/volume.h"

namespace meanvalue {
namespace {

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
    double farthest = 0.0;
    for (const Index v : vertices)
        farthest = std::max(farthest, (motion.apply(a.row(v).transpose()) - b.row(v).transpose()).norm());
    return farthest <= kCoincident * diagonal;
}

}  // namespace

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

}  // namespace meanvalue
