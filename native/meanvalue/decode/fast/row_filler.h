// The coefficients of rows at rest, written to where EnergyPatches has them.
#pragma once

#include <vector>

#include "meanvalue/decode/fast/energy_patches.h"

namespace meanvalue {

/// A weight, of which the share of all weights is given: 1 at none of it, itself at all.
double share_of(double weight, double by_length);

/// Writes what rows have of an encoding and of cells to where they are in the patches.
class RowFiller {
  public:
    RowFiller(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells, double size,
              double by_length, EnergyPatches& result)
        : encoding_(encoding),
          unknowns_(unknowns),
          cells_(cells),
          size_(size),
          by_length_(by_length),
          result_(result) {}

    void fill(RowBatch& batch);
    void fill(const SingleRow& single);

  private:
    /// Its spokes, by the rigidity of the row, and 1 / h_i^2 into the row's bending.
    void measure(std::size_t row, const EncodedRing& ring, Spoke* spokes);

    const Encoding& encoding_;
    const Unknowns& unknowns_;
    const RestCells& cells_;
    double size_;
    double by_length_;  // 0: all rows count alike
    EnergyPatches& result_;
    std::vector<Spoke> spokes_;
};

}  // namespace meanvalue
