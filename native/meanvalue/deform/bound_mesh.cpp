#include "meanvalue/deform/bound_mesh.h"

#include <algorithm>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/physical_memory.h"
#include "meanvalue/common/stage_timer.h"
#include "meanvalue/decode/fast/fast_decoder.h"
#include "meanvalue/deform/binding_input.h"
#include "meanvalue/deform/example_input.h"
#include "meanvalue/mesh/fixed_vertices.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/region.h"
#include "meanvalue/mesh/triangle_mesh.h"
#include "meanvalue/optimise/ring_limit.h"
#include "meanvalue/paper/full_decoder.h"
#include "meanvalue/paper/paper_decoder.h"

namespace meanvalue {
namespace {

// Tolerance of a single step, as a share of the diagonal. The fast method's steps shorten slowly; docs/benchmarks.md
// has how far from the minimum they end.
constexpr double kFastTolerance = 1e-4;
// The paper's own energy has long flat valleys, in which short steps still lead far.
constexpr double kFlatTolerance = 5e-5;

std::unique_ptr<Decoder> make_decoder(const Binding& binding, const std::vector<char>& is_soft,
                                      std::shared_ptr<const RegionShape> shape, std::vector<char> is_fixed,
                                      const Decoder* earlier,
                                      std::function<void(std::unique_ptr<const Decoder>)> when_coarse, int threads,
                                      Execution& execution) {
    const Region& region = shape->region;
    const double rigidity = rigidity_of(binding);
    const std::vector<Index> handles = handles_of_region(binding, region);
    std::vector<SoftAnchor> soft = soft_anchors_of_region(binding, is_soft, region);
    std::vector<char> is_soft_there(soft.empty() ? 0 : region.vertices.size(), 0);
    for (const SoftAnchor& anchor : soft)
        is_soft_there[anchor.vertex] = 1;
    std::vector<double> stiffness;
    if (!binding.stiffness.empty()) stiffness = picked(binding.stiffness, region.vertices);
    EncodedRegion encoded = with_fixed(std::move(shape), std::move(is_fixed), is_soft_there, execution);
    encoded.instructions = binding.instructions;
    if (earlier != nullptr) encoded.elimination_order = earlier->elimination_order();
    encoded.when_coarse = std::move(when_coarse);
    switch (binding.method) {
        case Method::kFast:
            return std::make_unique<FastDecoder>(std::move(encoded), std::move(soft), handles, rigidity,
                                                 std::move(stiffness), threads, execution);
        case Method::kPaper:
            return std::make_unique<PaperDecoder>(std::move(encoded), threads, execution);
        case Method::kFull:
            break;
    }
    return std::make_unique<FullDecoder>(std::move(encoded), threads, execution);
}

std::shared_ptr<const RestMesh> checked_mesh(const Binding& binding) {
    require_finite(*binding.vertices, "vertices");
    require_moderate_extent(*binding.vertices);
    require_triangles(static_cast<Index>(binding.vertices->rows()), *binding.faces);
    require_examples(binding);
    return std::make_shared<RestMesh>(RestMesh{binding.vertices, binding.faces, binding.roi,
                                               bounding_box_diagonal(*binding.vertices), binding.examples});
}

template <typename Array>
bool is_same_array(const std::shared_ptr<const Array>& a, const std::shared_ptr<const Array>& b) {
    return a == b || (a->rows() == b->rows() && *a == *b);
}

bool is_same_mesh(const Binding& binding, const RestMesh& mesh) {
    return is_same_array(binding.vertices, mesh.vertices) && is_same_array(binding.faces, mesh.faces) &&
           binding.roi == mesh.roi &&
           std::equal(binding.examples.begin(), binding.examples.end(), mesh.examples.begin(), mesh.examples.end(),
                      is_same_array<Positions>);
}

}  // namespace

BoundMesh::BoundMesh(const Binding& binding, Execution& execution, const BoundMesh* earlier,
                     const std::function<void(std::unique_ptr<const BoundMesh>)>& when_coarse)
    : method_(binding.method),
      instructions_(binding.instructions),
      loose_(binding.loose),
      threads_(thread_count(binding.threads)),
      anchors_(binding.anchors) {
    const StageTimer timer(report_.timings, "total");
    pin_eigen_cache_sizes();
    if (earlier != nullptr && (binding.method != earlier->method_ || !is_same_mesh(binding, *earlier->mesh_))) {
        throw InvalidInput(
            "binding again is to another mesh, region, method or examples than before; begin with binding_again(), "
            "or "
            "bind without an earlier one");
    }
    if (method_ == Method::kFast) default_tolerance_ = rigidity_of(binding) > 0.0 ? kFastTolerance : kFlatTolerance;
    mesh_ = earlier != nullptr ? earlier->mesh_ : checked_mesh(binding);
    require_stiffness(binding);
    execution.begin_stage("encode");
    is_fixed_ = fixed_flags(static_cast<Index>(rest().rows()), binding.anchors, binding.roi);
    const std::vector<char> is_soft = soft_flags(binding);
    for (std::size_t v = 0; v < is_soft.size(); ++v) {
        if (is_soft[v]) is_fixed_[v] = 0;
    }
    Components components = find_components(rest(), *mesh_->faces, is_fixed_, execution, is_soft);
    if (loose_ == LooseRule::kFollow) {
        if (!binding.is_border.empty()) free_parts_held_by_border(components, border_flags(binding));
        loose_parts_ = LooseParts(rest(), *mesh_->faces, components, execution);
    }
    for (const Index v : anchors_)
        is_of_loose_part_.push_back(components.fixed[components.part_of[v]].empty() ? 1 : 0);
    for (std::size_t v = 0; v < is_fixed_.size(); ++v) {  // loose parts are no unknowns
        if (components.fixed[components.part_of[v]].empty()) is_fixed_[v] = 1;
    }
    if (method_ == Method::kFast)
        require_memory(static_cast<Index>(std::count(is_fixed_.begin(), is_fixed_.end(), 0)),
                       binding.memory > 0 ? binding.memory : physical_memory());
    const auto shape = shape_for(components, earlier, execution);
    region_vertices_ = shape->region.vertices;
    std::vector<Index> row_of(is_fixed_.size(), -1);
    for (std::size_t row = 0; row < region_vertices_.size(); ++row)
        row_of[region_vertices_[row]] = static_cast<Index>(row);
    anchor_rows_ = picked(row_of, anchors_);
    std::vector<char> is_fixed_there = picked(is_fixed_, region_vertices_);
    report_.free_count = static_cast<Index>(std::count(is_fixed_there.begin(), is_fixed_there.end(), 0));
    const bool is_same_shape = earlier != nullptr && earlier->decoder().shape() == shape;
    const auto hand_on = [&](std::unique_ptr<const Decoder> coarse) {
        std::unique_ptr<BoundMesh> early(new BoundMesh(*this));
        early->decoder_ = std::move(coarse);
        early->fill_report(components);
        when_coarse(std::move(early));
    };
    decoder_ = make_decoder(
        binding, is_soft, shape, std::move(is_fixed_there), is_same_shape ? &earlier->decoder() : nullptr,
        when_coarse ? hand_on : std::function<void(std::unique_ptr<const Decoder>)>(), threads_, execution);
    if (!is_same_shape) report_.timings.insert(shape->timings.begin(), shape->timings.end());
    fill_report(std::move(components));
}

/// The shape of the region of free vertices and their surroundings: the earlier mesh' own, if it is the same.
std::shared_ptr<const RegionShape> BoundMesh::shape_for(const Components& components, const BoundMesh* earlier,
                                                        Execution& execution) {
    std::vector<char> may_move = mesh_->roi.value_or(std::vector<char>(is_fixed_.size(), 1));
    for (std::size_t v = 0; v < may_move.size(); ++v) {
        may_move[v] = may_move[v] != 0 && !components.fixed[components.part_of[v]].empty() ? 1 : 0;
    }
    is_outside_ = without_small_patches(is_fixed_, may_move, *mesh_->faces, execution);
    const bool is_same = earlier != nullptr && is_outside_ == earlier->is_outside_;
    Region region = is_same ? Region() : surroundings_of_free(rest(), *mesh_->faces, is_outside_, execution);
    const Region& of = is_same ? earlier->decoder().shape()->region : region;
    require_short_rings(of, picked(is_fixed_, of.vertices), execution);
    if (is_same) return earlier->decoder().shape();
    return encode_shape(in_spatial_order(region, execution), threads_, execution, mesh_->examples);
}

Binding BoundMesh::binding_again() const {
    Binding binding(mesh_->vertices, mesh_->faces, {}, mesh_->roi);
    binding.method = method_;
    binding.threads = threads_;
    binding.instructions = instructions_;
    binding.loose = loose_;
    binding.examples = mesh_->examples;
    return binding;
}

void BoundMesh::fill_report(Components components) {
    report_.components = std::move(components.parts);
    report_.carriers = loose_parts_.carriers();
    report_.carriers.resize(report_.components.size(), -1);
    report_.part_of = std::move(components.part_of);
    report_.vertex_count = static_cast<Index>(rest().rows());
    report_.anchor_count = static_cast<Index>(anchors_.size());
    report_.row_count = decoder_->row_count();
    report_.level_sizes = decoder_->level_sizes();
    report_.longest_ring = decoder_->longest_ring();
    report_.detached_triangle_count = decoder_->detached_triangle_count();
    report_.guarded = picked(region_vertices_, decoder_->encoding().guarded);
    std::sort(report_.guarded.begin(), report_.guarded.end());
    report_.guarded_by_reason = decoder_->encoding().guarded_by_reason();
    for (auto& [reason, vertices] : report_.guarded_by_reason) {
        for (Index& v : vertices)
            v = region_vertices_[v];
        std::sort(vertices.begin(), vertices.end());
    }
    for (const auto& [stage, seconds] : decoder_->bind_timings())
        report_.timings[stage] += seconds;
    report_.bytes = decoder_->bytes();
}

void BoundMesh::check_weights(const std::vector<double>& weights) const {
    if (!weights.empty()) require_count("weights", weights.size(), "number", anchors_.size(), "anchors");
    for (std::size_t k = 0; k < weights.size(); ++k) {
        const auto refuse = [&](const char* why) {
            throw InvalidInput(message("weights[", k, "], of vertex ", anchors_[k], ", is ", weights[k], why));
        };
        if (!(weights[k] >= 0.0 && weights[k] <= 1.0)) refuse("; give numbers from 0 to 1");
        if (weights[k] != 1.0 && is_fixed_[anchors_[k]] && !is_of_loose_part_[k])
            refuse(", but its anchor is met exactly; bind it with a finite strength, so that it can give way");
    }
}

bool BoundMesh::can_be_placed(const PositionsView& targets, const std::vector<double>& weights) const {
    try {
        require_targets(targets_without_gaps(targets, weights), anchors_, rest(), mesh_->diagonal);
    } catch (const InvalidInput&) {
        return false;
    }
    return true;
}

Positions BoundMesh::targets_without_gaps(const PositionsView& targets, const std::vector<double>& weights) const {
    check_weights(weights);
    Positions filled = targets;
    const std::size_t count = std::min<std::size_t>(weights.size(), filled.rows());
    for (std::size_t k = 0; k < count; ++k) {
        if (weights[k] == 0.0) filled.row(k) = rest().row(anchors_[k]);
    }
    return filled;
}

Positions BoundMesh::start_of_region(const PositionsView& targets, const Positions* previous,
                                     const std::vector<double>& weights, int threads,
                                     const Execution& execution) const {
    require_targets(targets, anchors_, rest(), mesh_->diagonal);
    Positions region(static_cast<Eigen::Index>(region_vertices_.size()), 3);
    parallel_for(static_cast<Index>(region.rows()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            if (previous != nullptr && !is_fixed_[region_vertices_[k]]) {
                region.row(k) = previous->row(k);
            } else {
                region.row(k) = rest().row(region_vertices_[k]);
            }
        }
    });
    for (std::size_t k = 0; k < anchors_.size(); ++k) {
        if (anchor_rows_[k] < 0 || is_of_loose_part_[k]) continue;
        const bool is_freed = !weights.empty() && weights[k] == 0.0;
        if (is_fixed_[anchors_[k]] || (previous == nullptr && !is_freed))
            region.row(anchor_rows_[k]) = targets.row(k);
    }
    return region;
}

Positions BoundMesh::region_of(const PositionsView& start, int threads, const Execution& execution) const {
    require_start(start, rest(), mesh_->diagonal, is_fixed_);
    Positions region(static_cast<Eigen::Index>(region_vertices_.size()), 3);
    parallel_for(static_cast<Index>(region.rows()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k)
            region.row(k) = start.row(region_vertices_[k]);
    });
    return region;
}

Positions BoundMesh::whole_mesh(const Positions& region, const PositionsView& targets, int threads) const {
    const Execution uncancelled;
    Positions positions = rest();
    parallel_for(static_cast<Index>(region.rows()), threads, uncancelled, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            if (!is_fixed_[region_vertices_[k]]) positions.row(region_vertices_[k]) = region.row(k);
        }
    });
    for (std::size_t k = 0; k < anchors_.size(); ++k) {
        if (is_fixed_[anchors_[k]] && !is_of_loose_part_[k]) positions.row(anchors_[k]) = targets.row(k);
    }
    loose_parts_.carry(rest(), positions.data(), threads, uncancelled);
    return positions;
}

std::vector<double> BoundMesh::example_weights(const ExampleWeights& weights, int threads) const {
    if (!decoder_->shape()->examples) return {};
    const ExampleSpace& examples = decoder_->shape()->examples->whole;
    const std::size_t count = static_cast<std::size_t>(examples.count()) + 1;
    std::vector<double> result(count * is_fixed_.size(), 0.0);
    for (std::size_t v = 0; v < is_fixed_.size(); ++v)
        result[v * count] = 1.0;
    if (weights.size() == 0) return result;
    parallel_for(static_cast<Index>(region_vertices_.size()), threads, Execution(), [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k)
            examples.weights_at(k, weights, result.data() + region_vertices_[k] * count);
    });
    return result;
}

}  // namespace meanvalue
