// Input made of bytes: mostly what an artist might have, with a few things wrong.
#pragma once

#include <optional>
#include <vector>

#include "fuzz/bytes.h"
#include "meanvalue/deform/deformer.h"
#include "tests/meshes.h"

namespace meanvalue::fuzz {

using tests::Mesh;

/// Up to about 250 vertices: a plain surface, now and then with small parts beside it, or a heap of triangles, with
/// vertices moved, in one place or no numbers, faces turned over, doubled, collapsed, joined elsewhere or out of
/// range; small, large, far away.
Mesh read_mesh(Bytes& bytes);

/// Of the same mesh: turned, with some vertices moved; now and then of another size.
Positions read_other_shape(Bytes& bytes, const Mesh& mesh);

/// Where vertices of a mesh go: near or far from where they are.
Positions read_targets(Bytes& bytes, const Mesh& mesh, const std::vector<Index>& anchors);

/// Anchors, region, handles, strengths, stiffness, method, rigidity, examples and what becomes of loose parts of
/// `mesh`, which the binding must not outlive.
Binding read_binding(Bytes& bytes, const Mesh& mesh);
/// The anchors alone, and what belongs to them.
void read_anchors(Bytes& bytes, Index vertex_count, Binding& binding);

/// From 0 to 1, one for each anchor, or none; now and then out of range.
std::vector<double> read_weights(Bytes& bytes, std::size_t anchor_count);
/// Mostly few: the first iterations go through all that later ones do.
int read_max_iterations(Bytes& bytes);
std::optional<double> read_tolerance(Bytes& bytes);

}  // namespace meanvalue::fuzz
