#include "reference/problem.h"

#include "meanvalue/common/checks.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/fixed_vertices.h"

namespace meanvalue::baselines {

Setup set_up(const Problem& problem, Execution& execution) {
    execution.begin_stage("analyse");
    Setup setup;
    setup.threads = thread_count(problem.threads);
    require_finite(problem.vertices, "vertices");
    require_moderate_extent(problem.vertices);
    const Index vertex_count = static_cast<Index>(problem.vertices.rows());
    const std::vector<char> held = fixed_flags(vertex_count, problem.anchors, problem.roi);
    require_targets(problem.targets, problem.anchors, problem.vertices, bounding_box_diagonal(problem.vertices));
    setup.rings = collect_one_rings(vertex_count, problem.faces, execution);
    setup.components = find_components(problem.vertices, problem.faces, held, execution);
    setup.is_fixed = held;
    for (Index v = 0; v < vertex_count; ++v) {
        if (setup.components.fixed[setup.components.part_of[v]].empty()) setup.is_fixed[v] = 1;
    }
    setup.unknowns = find_unknowns(setup.rings.offsets, setup.rings.vertices, setup.is_fixed);

    setup.start = problem.vertices;
    for (std::size_t k = 0; k < problem.anchors.size(); ++k)
        setup.start.row(problem.anchors[k]) = problem.targets.row(k);
    std::vector<Similarity> fits;
    fits.reserve(setup.components.fixed.size());
    for (const std::vector<Index>& fixed : setup.components.fixed)
        fits.push_back(fixed.empty() ? Similarity{} : fit_similarity(problem.vertices, setup.start, fixed));
    setup.carried = problem.vertices;
    for (Index v = 0; v < vertex_count; ++v)
        setup.carried.row(v) = fits[setup.components.part_of[v]].apply(problem.vertices.row(v).transpose());
    for (const Index v : setup.unknowns.free)
        setup.start.row(v) = setup.carried.row(v);
    return setup;
}

}  // namespace meanvalue::baselines
