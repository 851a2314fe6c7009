#include "meanvalue/decode/encoded_region.h"

#include <utility>

#include "meanvalue/encoding/encoder.h"
#include "meanvalue/mesh/triangle_mesh.h"

namespace meanvalue {

EncodedRegion encode_region(Region region, const std::vector<char>& is_soft, int threads, Execution& execution) {
    EncodedRegion result;
    result.region = std::move(region);
    const Region& of = result.region;
    result.components = find_components(of.positions, of.faces, of.is_fixed, execution, is_soft);
    {
        const StageTimer timer(result.timings, "encode");
        const TriangleMesh mesh(static_cast<Index>(of.vertices.size()), of.faces, execution);
        result.detached_triangle_count = mesh.detached_count();
        result.rings = collect_one_rings(mesh, execution);
        result.encoding = encode(result.rings, of.positions, threads, execution);
    }
    return result;
}

}  // namespace meanvalue
