// All of the library: bind a mesh and deform it, solve a clip, mix shapes, find values of shape keys, carry keys.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include "meanvalue/bones/fit_bones.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/execution.h"
#include "meanvalue/common/physical_memory.h"
#include "meanvalue/deform/deformer.h"
#include "meanvalue/follow/follower.h"
#include "meanvalue/morph/morpher.h"
#include "meanvalue/sequence/sequence.h"
#include "meanvalue/sliders/slider_fit.h"
#include "meanvalue/transfer/transfer.h"
