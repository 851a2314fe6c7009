#include <cmath>

#include "fuzz/entries.h"
#include "fuzz/odd_input.h"
#include "meanvalue/morph/morpher.h"

namespace meanvalue::fuzz {
namespace {

std::vector<double> read_shares(Bytes& bytes, std::size_t shape_count, Index vertex_count) {
    std::vector<double> weights;
    const std::size_t count = shape_count * (bytes.once_in(4) ? vertex_count : 1) + (bytes.once_in(64) ? 1 : 0);
    while (weights.size() < count)
        weights.push_back(bytes.once_in(32) ? bytes.number() : bytes.byte() / 128.0 - (bytes.once_in(8) ? 0.5 : 0.0));
    return weights;
}

}  // namespace

Outcome morph(Bytes bytes) {
    const Mesh mesh = read_mesh(bytes);
    std::vector<Positions> shapes = {mesh.vertices};
    for (int more = bytes.once_in(4) ? 2 : 1; more > 0; --more)
        shapes.push_back(read_other_shape(bytes, mesh));
    MorphBinding binding(shapes, mesh.faces);
    for (Index k = bytes.once_in(2) ? bytes.below(6) : 0; k > 0 && mesh.vertex_count() > 0; --k)
        binding.anchors.push_back(bytes.below(mesh.vertex_count() + (bytes.once_in(64) ? 1 : 0)));
    binding.threads = bytes.once_in(8) ? 2 : 1;
    if (bytes.once_in(4)) binding.instructions = InstructionSet::kPortable;
    return outcome_of([&] {
        Execution execution;
        const Morpher morpher(binding, execution);
        for (int round = 0; round < 2; ++round) {
            MorphOptions options;
            if (bytes.once_in(4)) {
                options.parts.emplace();
                for (int more = bytes.below(3); more > 0; --more)
                    options.parts->push_back(bytes.below(static_cast<Index>(shapes.size()) + 1) - bytes.once_in(16));
            }
            const std::vector<double> weights = read_shares(bytes, shapes.size(), mesh.vertex_count());
            require_solution(morpher.solve(weights, options, execution), mesh.vertex_count());
        }
    });
}

}  // namespace meanvalue::fuzz
