#include "meanvalue/deform/deformer.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "meanvalue/common/abandon.h"
#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/fork.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/fast/fast_decoder.h"
#include "meanvalue/hierarchy/paper_decoder.h"
#include "meanvalue/mesh/fixed_vertices.h"
#include "meanvalue/mesh/region.h"
#include "meanvalue/mesh/triangle_mesh.h"
#include "meanvalue/solver/full_decoder.h"
#include "meanvalue/solver/ring_room.h"

namespace meanvalue {
namespace {

// How often a caller that waits for another one's solve looks at its cancel flag.
constexpr std::chrono::milliseconds kPollInterval{10};
constexpr int kPollsToBeSure = 50;

// Of the diagonal, of a single step. The fast method's steps shorten slowly; docs/benchmarks.md has how far from the
// minimum they end.
constexpr double kMostRigidity = 1e9;  // beyond, single precision ends
constexpr double kMostStrength = 1e9;
constexpr double kFastTolerance = 1e-4;
// The paper's own energy has long flat valleys, in which short steps still lead far.
constexpr double kFlatTolerance = 5e-5;

/// Of the region's vertices: the handle of each anchor, -1 for the others; empty where none are given.
std::vector<Index> handles_of_region(const Binding& binding, const Region& region) {
    if (binding.handles.empty()) return {};
    if (binding.handles.size() != binding.anchors.size()) {
        throw InvalidInput(message("handles has ", binding.handles.size(), " numbers, but there are ",
                                   binding.anchors.size(), " anchors; give one number for each"));
    }
    std::vector<Index> of_mesh(binding.vertices.rows(), -1);
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

/// n flags, empty where all anchors are hard.
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
        flags.resize(binding.vertices.rows(), 0);
        flags[v] = 1;
    }
    return flags;
}

/// In the region's vertex numbers. @param is_soft soft_flags().
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
    return result;
}

PairBytes pair_bytes_of(Method method) {
    switch (method) {
        case Method::kFast:
            return kNumberPairs;
        case Method::kPaper:  // its levels have short rings; its last sweeps look at every ring for each vertex of it
            return kNoPairs;
        case Method::kFull:
            break;
    }
    return kBlockPairs;
}

std::unique_ptr<Decoder> make_decoder(const Binding& binding, const std::vector<char>& is_soft, Region region,
                                      int threads, Execution& execution) {
    const double rigidity = rigidity_of(binding);
    const std::vector<Index> handles = handles_of_region(binding, region);
    std::vector<SoftAnchor> soft = soft_anchors_of_region(binding, is_soft, region);
    switch (binding.method) {
        case Method::kFast:
            return std::make_unique<FastDecoder>(std::move(region), std::move(soft), handles, rigidity, threads,
                                                 execution);
        case Method::kPaper:
            return std::make_unique<PaperDecoder>(std::move(region), threads, execution);
        case Method::kFull:
            break;
    }
    return std::make_unique<FullDecoder>(std::move(region), threads, execution);
}

}  // namespace

Method method_from_name(const std::string& name) {
    if (name == "fast") return Method::kFast;
    if (name == "paper") return Method::kPaper;
    if (name == "full") return Method::kFull;
    throw InvalidInput(message("method is '", name, "'; this version knows 'fast', 'paper' and 'full'"));
}

Deformer::Deformer(const Binding& binding, Execution& execution)
    : solver_generation_(fork_generation()),
      method_(binding.method),
      rest_(binding.vertices),
      anchors_(binding.anchors) {
    if (method_ == Method::kFast) default_tolerance_ = rigidity_of(binding) > 0.0 ? kFastTolerance : kFlatTolerance;
    const int threads = thread_count(binding.threads);
    require_finite(rest_, "vertices");
    require_moderate_extent(rest_);
    diagonal_ = bounding_box_diagonal(rest_);
    execution.begin_stage("encode");
    require_triangles(static_cast<Index>(rest_.rows()), binding.faces);
    is_fixed_ = fixed_flags(static_cast<Index>(rest_.rows()), binding.anchors, binding.roi);
    const std::vector<char> is_soft = soft_flags(binding);
    for (std::size_t v = 0; v < is_soft.size(); ++v) {
        if (is_soft[v]) is_fixed_[v] = 0;
    }
    Components components = find_components(rest_, binding.faces, is_fixed_, execution, is_soft);
    Region region = surroundings_of_free(rest_, binding.faces, solved_as_fixed(is_fixed_, components), execution);
    require_room_for_rings(region, pair_bytes_of(method_), execution);
    // The paper's methods keep the caller's order, which their queue breaks ties by.
    if (binding.method == Method::kFast) region = in_spatial_order(region, execution);
    region_vertices_ = region.vertices;
    report_.components = std::move(components.parts);
    report_.free_count = static_cast<Index>(std::count(region.is_fixed.begin(), region.is_fixed.end(), 0));
    decoder_ = make_decoder(binding, is_soft, std::move(region), threads, execution);
    fill_report(region_vertices_);
}

void Deformer::fill_report(const std::vector<Index>& region_vertices) {
    report_.vertex_count = static_cast<Index>(rest_.rows());
    report_.anchor_count = static_cast<Index>(anchors_.size());
    report_.row_count = decoder_->row_count();
    report_.level_sizes = decoder_->level_sizes();
    report_.longest_ring = decoder_->longest_ring();
    report_.detached_triangle_count = decoder_->detached_triangle_count();
    for (const Index v : decoder_->encoding().guarded)
        report_.guarded.push_back(region_vertices[v]);
    std::sort(report_.guarded.begin(), report_.guarded.end());
    for (const auto& [reason, vertices] : decoder_->encoding().guarded_by_reason()) {
        report_.guarded_reasons[reason] = static_cast<Index>(vertices.size());
    }
    report_.timings = decoder_->bind_timings();
    report_.bytes = decoder_->bytes();
}

Positions Deformer::rows_of_region(const PositionsView& positions, const Execution& execution) const {
    Positions rows(static_cast<Eigen::Index>(region_vertices_.size()), 3);
    for (std::size_t k = 0; k < region_vertices_.size(); ++k) {
        execution.check_every(k);
        rows.row(k) = positions.row(region_vertices_[k]);
    }
    return rows;
}

Positions Deformer::place_anchors(const PositionsView& targets, const std::optional<PositionsView>& start,
                                  const Execution& execution) const {
    require_targets(targets, anchors_, rest_, diagonal_);
    execution.check();
    Positions positions = rest_;
    execution.check();
    if (start) {
        require_start(*start, rest_, diagonal_, is_fixed_, execution);
        for (Index v = 0; v < positions.rows(); ++v) {
            execution.check_every(v);
            if (!is_fixed_[v]) positions.row(v) = start->row(v);
        }
    }
    for (std::size_t k = 0; k < anchors_.size(); ++k) {
        execution.check_every(k);
        if (!start || is_fixed_[anchors_[k]]) positions.row(anchors_[k]) = targets.row(k);
    }
    return positions;
}

std::unique_lock<std::timed_mutex> Deformer::take_turn(const Execution& execution) {
    std::unique_lock<std::timed_mutex> turn(solving_, std::defer_lock);
    int polls_of_others = 0;
    while (!turn.try_lock_for(kPollInterval)) {
        execution.check();
        // Several: who has just got his turn may not have signed yet.
        if (solver_generation_ != fork_generation() && ++polls_of_others > kPollsToBeSure) {
            throw SolverFailure(
                "the deformer was in the middle of a solve when this process was forked; bind the mesh again here");
        }
    }
    solver_generation_ = fork_generation();
    return turn;
}

Solution Deformer::solve(const PositionsView& targets, const std::optional<PositionsView>& start,
                         const SolveOptions& options, Execution& execution) {
    const double tolerance = options.tolerance.value_or(default_tolerance_);
    if (!(tolerance > 0.0)) {
        throw InvalidInput(message("tolerance is ", tolerance, "; give a positive number"));
    }
    if (options.max_iterations < 0) {
        throw InvalidInput(message("max_iterations is ", options.max_iterations, "; give 0 or more"));
    }
    const std::unique_lock<std::timed_mutex> turn = take_turn(execution);
    Solution solution;
    solution.vertices = place_anchors(targets, start, execution);
    Positions positions = rows_of_region(solution.vertices, execution);
    const Positions previous = start ? rows_of_region(*start, execution) : Positions();
    DecodeReport report;
    Timings total;
    {
        const StageTimer timer(total, "total");
        execution.begin_stage("solve");
        DecodeOptions decode_options{tolerance, options.max_iterations, start ? &previous : nullptr, &targets,
                                     options.settle};
        report = decoder_->decode(decode_options, positions, execution);
        if (start && options.settle) {
            Positions fresh = rows_of_region(place_anchors(targets, {}, execution), execution);
            decode_options.previous = nullptr;
            DecodeReport fresh_report = decoder_->decode(decode_options, fresh, execution);
            if (fresh_report.energies.back() < report.energies.back()) {
                report = std::move(fresh_report);
                positions = std::move(fresh);
            }
        }
    }
    for (std::size_t k = 0; k < region_vertices_.size(); ++k) {
        if (!is_fixed_[region_vertices_[k]]) solution.vertices.row(region_vertices_[k]) = positions.row(k);
    }
    solution.energies = report.energies;
    solution.initial_energy = report.energies.front();
    solution.energy = report.energies.back();
    solution.initial_gradient = report.initial_gradient;
    solution.gradient = report.gradient;
    solution.iterations = report.iterations;
    solution.all_iterations = std::max(report.iterations, report.all_iterations);
    solution.converged = report.converged;
    solution.stop_reason = report.stop_reason;
    solution.timings = std::move(report.timings);
    solution.timings.merge(total);
    return solution;
}

std::unique_ptr<Deformer> bind_abandonable(const Binding& binding, const std::shared_ptr<Execution>& execution) {
    struct Bind {
        Positions vertices;
        Triangles faces;
        std::unique_ptr<Binding> binding;
        std::shared_ptr<Execution> execution;
        std::unique_ptr<Deformer> deformer;
    };
    const auto bind = std::make_shared<Bind>(Bind{binding.vertices, binding.faces, {}, execution, {}});
    bind->binding =
        std::make_unique<Binding>(Binding{bind->vertices, bind->faces, binding.anchors, binding.roi, binding.method,
                                          binding.threads, binding.handles, binding.rigidity, binding.strengths});
    run_abandonable([bind] { bind->deformer = std::make_unique<Deformer>(*bind->binding, *bind->execution); },
                    *execution);
    return std::move(bind->deformer);
}

}  // namespace meanvalue
