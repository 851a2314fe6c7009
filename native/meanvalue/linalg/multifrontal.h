// The numbers of a Cholesky factor, front after front.
#pragma once

#include <functional>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/front_kernels.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/supernodal_pattern.h"

namespace meanvalue {

/// Takes the columns of the factor, each supernode's when they are known: a panel, in which what is above the
/// diagonal is undefined. Called from several threads at once, for different supernodes.
using PanelSink = std::function<void(Index supernode, const FrontShape& shape, const double* panel)>;

/// Multifrontal: each supernode adds up the matrix's entries and what its children left, is eliminated, and leaves
/// the rest to its parent (I. S. Duff, J. K. Reid, The multifrontal solution of indefinite sparse symmetric linear
/// equations, ACM Trans. Math. Softw. 9, 1983). Sums run in one order, so that the bits are the same for any number
/// of threads; they differ between kernels, of which some round less often.
/// @param lower the matrix that `pattern` was made of: its lower triangle, other entries are ignored.
/// It is freed before the numbers are found. @param threads as given by thread_count().
/// @return false where the matrix is not positive definite to working precision. @throws Cancelled, std::bad_alloc.
bool factor_fronts(const SupernodalPattern& pattern, SparseMatrix lower, const FrontKernels& kernels, int threads,
                   const PanelSink& sink, const Execution& execution);

}  // namespace meanvalue
