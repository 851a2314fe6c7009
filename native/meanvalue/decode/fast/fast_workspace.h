// What a solve by the fast method writes besides its result.
#pragma once

#include <mutex>
#include <vector>

#include "meanvalue/decode/decoder.h"
#include "meanvalue/decode/fast/deformation_energy.h"
#include "meanvalue/decode/fast/handle_responses.h"
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
        Encoding blended;                         // of the examples
        RestCells blended_cells;
    };

    void forget() override {
        const std::lock_guard<std::mutex> lock(drafting);
        predictor.end();
        is_drafting = false;
        keeps_history = false;
    }

    std::vector<OfLevel> levels;     // as FastProblem::levels
    ExampleWeights example_weights;  // of the last blend; empty: the rest shape alone
    SupernodalFactor::Workspace factor;
    // Of the solves of a drag. What the next solve begins with is what its draft shows: the solve locks to write.
    std::mutex drafting;
    bool is_drafting = false;  // there is a shape to go on from, and all anchors count in it
    SecantPredictor predictor;
    HandleResponses responses;
    bool keeps_history = false;  // the whole mesh' minimizer: of the last of those, which came to its end
};

}  // namespace meanvalue
