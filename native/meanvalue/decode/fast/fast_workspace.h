// What a solve by the fast method writes besides its result.
#pragma once

#include "meanvalue/decode/decoder.h"
#include "meanvalue/decode/fast/deformation_energy.h"
#include "meanvalue/decode/fast/secant_predictor.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/optimise/lbfgs.h"

namespace meanvalue {

struct FastWorkspace : Workspace {
    /// For one level.
    struct OfLevel {
        DeformationEnergy::Workspace energy;
        Lbfgs minimiser;
        std::vector<DiagonalDowndate> downdates;  // for each stage
    };

    void forget() override {
        predictor.forget();
        keeps_history = false;
    }
    std::size_t bytes() const override;

    OfLevel fine;
    OfLevel coarse;
    OfLevel middle;
    SupernodalFactor::Workspace factor;
    SecantPredictor predictor;    // of the solves of a drag
    bool keeps_history = false;   // fine's minimiser: of the last of those, which came to its end
    std::size_t later_bytes = 0;  // of the predictor and the factor's, once they are in use
};

}  // namespace meanvalue
