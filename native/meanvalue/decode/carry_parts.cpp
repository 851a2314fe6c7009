#include "meanvalue/decode/carry_parts.h"

#include "meanvalue/linalg/procrustes.h"

namespace meanvalue {

Positions carry_parts(const Components& components, const PositionsView& rest, const PositionsView& placed,
                      const std::vector<double>& weights) {
    std::vector<Similarity> fits;
    for (const std::vector<Index>& fixed : components.fixed) {
        fits.push_back(fixed.empty() ? Similarity{} : fit_similarity(rest, placed, fixed, weights));
    }
    Positions carried = rest;
    for (Index v = 0; v < carried.rows(); ++v) {
        carried.row(v) = fits[components.part_of[v]].apply(rest.row(v).transpose());
    }
    return carried;
}

}  // namespace meanvalue
