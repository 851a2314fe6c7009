#include "meanvalue/deform/bound_mesh.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/physical_memory.h"
#include "meanvalue/common/stage_timer.h"
#include "meanvalue/decode/fast/fast_decoder.h"
#include "meanvalue/mesh/fixed_vertices.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/region.h"
#include "meanvalue/optimise/ring_limit.h"
#include "meanvalue/paper/paper_decoder.h"

namespace meanvalue {
namespace {

// Tolerance of a single step, as a share of the diagonal. The fast method's steps shorten slowly; docs/benchmarks.md
// has how far from the minimum they end.
constexpr double kFastTolerance = 1e-4;
// The paper's own energy has long flat valleys, in which short steps still lead far.
constexpr double kFlatTolerance = 5e-5;

/// Of a part with its shape, anchors, and the decoder that it had before, if any; not finished.
std::shared_ptr<Decoder> make_decoder(const Binding& binding, const BoundPart& part, std::vector<char> is_fixed,
                                      int threads, Execution& execution) {
    const double rigidity = rigidity_of(binding);
    std::vector<Index> handles;  // empty where none are given
    std::vector<SoftAnchor> soft;
    for (const auto& [number, vertex, handle, strength] : part.anchors) {
        if (handle >= 0) handles.resize(is_fixed.size(), -1);
        if (handle >= 0) handles[vertex] = handle;
        if (std::isfinite(strength)) soft.push_back({vertex, number, strength});
    }
    std::vector<double> stiffness;
    if (!binding.stiffness.empty()) stiffness = picked(binding.stiffness, part.vertices());
    EncodedRegion encoded{part.shape, std::move(is_fixed), binding.instructions};
    if (part.decoder == nullptr)
        encoded.timings = part.shape->timings;
    else
        encoded.elimination_order = part.decoder->elimination_order();
    switch (binding.method) {
        case Method::kFast:
            return std::make_shared<FastDecoder>(std::move(encoded), std::move(soft), handles, rigidity,
                                                 std::move(stiffness), threads, execution);
        case Method::kPaper:
            return std::make_shared<PaperDecoder>(std::move(encoded), threads, execution);
        case Method::kFull:
            break;
    }
    return std::make_shared<FullDecoder>(std::move(encoded), threads, execution);
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
            "or bind without an earlier one");
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
        bool is_same = earlier != nullptr && earlier->instructions_ == instructions_;  // other anchors change nothing
        for (std::size_t part = 0; is_same && part < components.parts.size(); ++part)
            is_same = components.fixed[part].empty() == (earlier->report_.carriers[part] >= 0);
        loose_parts_ = is_same ? earlier->loose_parts_
                               : LooseParts(rest(), *mesh_->faces, components, FollowKind::kAuto, instructions_,
                                            threads_, execution);
    }
    for (const Index v : anchors_)
        is_of_loose_part_.push_back(components.is_loose(components.part_of[v]) ? 1 : 0);
    for (std::size_t v = 0; v < is_fixed_.size(); ++v) {  // loose parts are no unknowns
        if (components.is_loose(components.part_of[v])) is_fixed_[v] = 1;
    }
    report_.free_count = static_cast<Index>(std::count(is_fixed_.begin(), is_fixed_.end(), 0));
    if (method_ == Method::kFast)
        require_memory(report_.free_count, binding.memory > 0 ? binding.memory : physical_memory());
    find_parts(components, earlier, execution);
    find_anchors(binding);
    std::vector<std::shared_ptr<Decoder>> decoders(parts_.size());
    const auto finish = [&](std::size_t number, Execution& of_part) {
        decoders[number]->finish(of_part);
        parts_[number].decoder = decoders[number];
    };
    std::atomic<bool> has_early{false};
    for_parts("factor", threads_, execution, [&](std::size_t number, int threads, Execution& of_part) {
        BoundPart& part = parts_[number];
        decoders[number] = make_decoder(binding, part, picked(is_fixed_, part.vertices()), threads, of_part);
        part.decoder = when_coarse ? decoders[number]->early() : nullptr;
        if (part.decoder == nullptr) return finish(number, of_part);
        has_early = true;
    });
    if (has_early) {
        std::unique_ptr<BoundMesh> early(new BoundMesh(*this));
        early->fill_report(components);
        when_coarse(std::move(early));
        for_parts("factor", threads_, execution, [&](std::size_t number, int, Execution& of_part) {
            if (parts_[number].decoder != decoders[number]) finish(number, of_part);
        });
    }
    for (const auto& decoder : decoders) {
        for (const auto& [stage, seconds] : decoder->bind_timings())
            report_.timings[stage] += seconds;
    }
    fill_report(std::move(components));
}

/// The parts of the region with their shapes: the earlier mesh' own where they are the same.
void BoundMesh::find_parts(const Components& components, const BoundMesh* earlier, Execution& execution) {
    std::vector<char> may_move = mesh_->roi.value_or(std::vector<char>(is_fixed_.size(), 1));
    for (std::size_t v = 0; v < may_move.size(); ++v) {
        may_move[v] = may_move[v] != 0 && !components.is_loose(components.part_of[v]) ? 1 : 0;
    }
    is_outside_ = without_small_patches(is_fixed_, may_move, *mesh_->faces, execution);
    const bool is_same = earlier != nullptr && is_outside_ == earlier->is_outside_;
    std::vector<Region> regions;
    if (is_same) {
        parts_ = earlier->parts_;
        region_size_ = earlier->region_size_;
    } else {
        const Region whole = surroundings_of_free(rest(), *mesh_->faces, is_outside_, execution);
        region_size_ = static_cast<Index>(whole.vertices.size());
        regions = parts_in_spatial_order(whole, execution);
        for (const Region& region : regions)
            parts_.push_back({static_cast<Index>(region.vertices.size()), nullptr, nullptr, {}});
    }
    for_parts("encode", threads_, execution, [&](std::size_t number, int threads, Execution& of_part) {
        BoundPart& part = parts_[number];
        const Region& region = is_same ? part.shape->region : regions[number];
        require_short_rings(region, picked(is_fixed_, region.vertices), of_part);
        if (is_same) return;
        part.shape = encode_shape(std::move(regions[number]), threads, of_part, mesh_->examples,
                                  mesh_->diagonal > 0.0 ? mesh_->diagonal : 1.0);
    });
}

/// Those of each part. @throws InvalidInput.
void BoundMesh::find_anchors(const Binding& binding) {
    if (!binding.handles.empty())
        require_count("handles", binding.handles.size(), "number", anchors_.size(), "anchors");
    std::vector<Index> anchor_of(is_fixed_.size(), -1);
    for (std::size_t k = 0; k < anchors_.size(); ++k) {
        anchor_of[anchors_[k]] = static_cast<Index>(k);
        if (!binding.handles.empty() && binding.handles[k] < 0)
            throw InvalidInput(message("handles[", k, "] is ", binding.handles[k], "; give numbers from 0"));
    }
    for (BoundPart& part : parts_) {
        part.anchors.clear();
        for (Index row = 0; row < part.size; ++row) {
            const Index k = anchor_of[part.vertices()[row]];
            if (k < 0) continue;
            part.anchors.push_back({k, row});
            if (!binding.handles.empty()) part.anchors.back().handle = binding.handles[k];
            if (!binding.strengths.empty()) part.anchors.back().strength = binding.strengths[k];
        }
    }
}

void BoundMesh::for_parts(const char* stage, int threads, Execution& execution, const PartBody& body) const {
    if (parts_.size() == 1) return body(0, threads, execution);
    execution.begin_stage(stage);
    std::mutex mutex;  // of what is done, in vertices
    Index done = 0;
    const auto run = [&](std::size_t number, int threads_of_part) {
        Execution of_part(&execution);
        body(number, threads_of_part, of_part);
        const std::lock_guard<std::mutex> lock(mutex);
        done += parts_[number].size;
        execution.set_progress(static_cast<double>(done) / region_size_);
    };
    const auto is_small = [&](std::size_t number) { return parts_[number].size < 2 * kPiece; };
    for (std::size_t number = 0; number < parts_.size(); ++number)
        if (!is_small(number)) run(number, threads);
    parallel_items(parts_.size(), threads, execution, [&](int, std::size_t number) {
        if (is_small(number)) run(number, 1);
    });
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
    for (const BoundPart& part : parts_) {
        const Decoder& decoder = *part.decoder;
        report_.row_count += decoder.row_count();
        const std::vector<Index> sizes = decoder.level_sizes();
        report_.level_sizes.resize(std::max(report_.level_sizes.size(), sizes.size()));
        std::transform(sizes.begin(), sizes.end(), report_.level_sizes.begin(), report_.level_sizes.begin(),
                       std::plus<>());
        report_.longest_ring = std::max(report_.longest_ring, decoder.longest_ring());
        report_.detached_triangle_count += decoder.detached_triangle_count();
        for (const Index v : decoder.encoding().guarded)
            report_.guarded.push_back(part.vertices()[v]);
        for (const auto& [reason, guarded] : decoder.encoding().guarded_by_reason()) {
            for (const Index v : guarded)
                report_.guarded_by_reason[reason].push_back(part.vertices()[v]);
        }
        report_.bytes += decoder.bytes();
    }
    std::sort(report_.guarded.begin(), report_.guarded.end());
    for (auto& [reason, vertices] : report_.guarded_by_reason)
        std::sort(vertices.begin(), vertices.end());
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

Positions BoundMesh::targets_without_gaps(const PositionsView& targets, const std::vector<double>& weights) const {
    check_weights(weights);
    Positions filled = targets;
    const std::size_t count = std::min<std::size_t>(weights.size(), filled.rows());
    for (std::size_t k = 0; k < count; ++k) {
        if (weights[k] == 0.0) filled.row(k) = rest().row(anchors_[k]);
    }
    require_targets(filled, anchors_, rest(), mesh_->diagonal);
    return filled;
}

Positions BoundMesh::start_of(const BoundPart& part, const PositionsView& targets, const Positions* previous,
                              const std::vector<double>& weights, int threads, const Execution& execution) const {
    const std::vector<Index>& vertices = part.vertices();
    Positions start(static_cast<Eigen::Index>(vertices.size()), 3);
    parallel_for(static_cast<Index>(start.rows()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            const bool goes_on = previous != nullptr && !is_fixed_[vertices[k]];
            start.row(k) = goes_on ? previous->row(k) : rest().row(vertices[k]);
        }
    });
    for (const auto& [number, vertex, handle, strength] : part.anchors) {
        const bool is_freed = !weights.empty() && weights[number] == 0.0;
        if (is_fixed_[anchors_[number]] || (previous == nullptr && !is_freed))
            start.row(vertex) = targets.row(number);
    }
    return start;
}

std::vector<Positions> BoundMesh::parts_of(const PositionsView& start, const Execution& execution) const {
    require_start(start, rest(), mesh_->diagonal, is_fixed_);
    std::vector<Positions> shapes;
    for (const BoundPart& part : parts_) {
        execution.check();
        shapes.emplace_back(start(part.vertices(), Eigen::all));
    }
    return shapes;
}

Positions BoundMesh::whole_mesh(const std::vector<Positions>& parts, const PositionsView& targets,
                                int threads) const {
    const Execution uncancelled;
    Positions positions = rest();
    for (std::size_t number = 0; number < parts_.size(); ++number) {
        const std::vector<Index>& vertices = parts_[number].vertices();
        parallel_for(parts_[number].size, threads, uncancelled, [&](Index begin, Index end) {
            for (Index k = begin; k < end; ++k) {
                if (!is_fixed_[vertices[k]]) positions.row(vertices[k]) = parts[number].row(k);
            }
        });
    }
    for (std::size_t k = 0; k < anchors_.size(); ++k) {
        if (is_fixed_[anchors_[k]] && !is_of_loose_part_[k]) positions.row(anchors_[k]) = targets.row(k);
    }
    loose_parts_.carry(rest(), positions.data(), threads, uncancelled);
    return positions;
}

std::vector<double> BoundMesh::example_weights(const std::vector<DecodeReport>& reports, int threads) const {
    if (mesh_->examples.empty()) return {};
    const std::size_t count = mesh_->examples.size() + 1;
    std::vector<double> result(count * is_fixed_.size(), 0.0);
    for (std::size_t v = 0; v < is_fixed_.size(); ++v)
        result[v * count] = 1.0;
    for (std::size_t number = 0; number < parts_.size(); ++number) {
        const ExampleWeights& weights = reports[number].example_weights;
        if (weights.size() == 0) continue;
        const RegionShape& shape = *parts_[number].shape;
        parallel_for(parts_[number].size, threads, Execution(), [&](Index begin, Index end) {
            for (Index k = begin; k < end; ++k)
                shape.examples->whole.weights_at(k, weights, result.data() + shape.region.vertices[k] * count);
        });
    }
    return result;
}

}  // namespace meanvalue
