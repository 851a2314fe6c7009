#include "meanvalue/morph/cell_patches.h"

#include <algorithm>

namespace meanvalue {
namespace {

// Enough for every finger. Finer patches follow strains, which tilt the axes of relative rotations.
constexpr Index kPatches = 600;

}  // namespace

CellPatches grow_patches(const Encoding& layout, const Execution& execution) {
    CellPatches patches;
    std::vector<Index>& of = patches.of;
    std::vector<Index>& sizes = patches.sizes;
    const Index vertices = layout.vertex_count();
    const Index most = std::max<Index>(1, (vertices + kPatches - 1) / kPatches);
    of.assign(vertices, -1);
    std::vector<Index> seeds;
    std::vector<char> is_seed(vertices, 0);
    std::vector<Index> members;
    for (Index first = 0; first < vertices; ++first) {
        execution.check_every(first);
        if (of[first] >= 0 || !layout.predictable(first)) continue;
        seeds.assign(1, first);
        for (std::size_t next = 0; next < seeds.size(); ++next) {  // a part of the mesh, patch after patch outwards
            if (of[seeds[next]] >= 0) continue;
            const Index current = patches.count();
            members.assign(1, seeds[next]);
            of[seeds[next]] = current;
            Index neighbour = -1;
            for (std::size_t k = 0; k < members.size(); ++k) {
                for (Index place = layout.ring_offsets[members[k]]; place < layout.ring_offsets[members[k] + 1];
                     ++place) {
                    const Index v = layout.ring[place];
                    if (!layout.predictable(v)) continue;
                    if (of[v] >= 0) {
                        if (of[v] != current) neighbour = of[v];
                    } else if (static_cast<Index>(members.size()) < most) {
                        of[v] = current;
                        members.push_back(v);
                    } else if (!is_seed[v]) {
                        is_seed[v] = 1;
                        seeds.push_back(v);
                    }
                }
            }
            if (neighbour >= 0 && static_cast<Index>(members.size()) * 3 < most) {
                for (const Index v : members)
                    of[v] = neighbour;
                sizes[neighbour] += static_cast<Index>(members.size());
            } else {
                sizes.push_back(static_cast<Index>(members.size()));
            }
        }
    }
    return patches;
}

}  // namespace meanvalue
