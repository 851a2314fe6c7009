#include "meanvalue/mesh/extent.h"

#include <cmath>
#include <utility>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

Positions turned(const Positions& positions, double angle_rad) {
    return moved_by_similarity(positions, 1.0, Vector3(1, -2, 0.5), angle_rad, Vector3(3, -1, 2));
}

/// Three different axes and a longer tail along each.
Mesh lopsided() {
    Mesh mesh = capped_tube(12, 20, 5.0);
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        mesh.vertices.row(v) =
            Eigen::RowVector3d(std::exp(0.5 * mesh.vertices(v, 0)), 2.0 * std::exp(0.3 * mesh.vertices(v, 1)),
                               std::exp(0.2 * mesh.vertices(v, 2)) + mesh.vertices(v, 2));
    return mesh;
}

/// Symmetric about three planes, with three different axes.
Mesh ellipsoid() {
    Mesh mesh = sphere(3);
    mesh.vertices = mesh.vertices * Vector3(1.0, 2.0, 3.5).asDiagonal();
    return mesh;
}

TEST(Extent, OfATurnedShapeIsTheSameOrNearlySoWithoutDistinctAxes) {
    for (const auto& [mesh, tolerance] :
         {std::pair(lopsided(), 1e-9), {ellipsoid(), 1e-9}, {bar(4, 20), 0.01}, {sphere(4), 0.01}}) {
        const double expected = mean_diagonal(mesh.vertices, 1, Execution());
        EXPECT_NEAR(expected, mesh.diagonal(), 0.25 * mesh.diagonal()) << mesh.name;
        for (const double angle_rad : {0.3, 1.0, 2.5}) {
            EXPECT_NEAR(mean_diagonal(turned(mesh.vertices, angle_rad), 1, Execution()), expected,
                        tolerance * expected)
                << mesh.name;
        }
    }
}

TEST(Extent, IsTheSameForAnyNumberOfThreads) {
    const Mesh mesh = torus(120, 60);
    const double alone = mean_diagonal(mesh.vertices, 1, Execution());
    for (const int threads : {2, 3, 5})
        EXPECT_EQ(mean_diagonal(mesh.vertices, threads, Execution()), alone);
}

TEST(Extent, OfNothingOrOnePointIsZero) {
    EXPECT_EQ(mean_diagonal(Positions(0, 3), 1, Execution()), 0.0);
    EXPECT_EQ(mean_diagonal(Positions::Constant(1, 3, 7.0), 1, Execution()), 0.0);
    EXPECT_EQ(principal_axes(Positions(0, 3), Execution()), Matrix3::Identity());
}

TEST(PrincipalAxes, TurnWithTheShape) {
    for (const Mesh& mesh : {lopsided(), ellipsoid()}) {
        const Positions along = mesh.vertices * principal_axes(mesh.vertices, Execution());
        for (const double angle_rad : {0.3, 1.0, 2.5}) {
            const Positions other = turned(mesh.vertices, angle_rad);
            const Positions turned_along = other * principal_axes(other, Execution());
            // Up to where the shape was moved to.
            const Eigen::RowVector3d shift = turned_along.colwise().mean() - along.colwise().mean();
            EXPECT_LT(largest_distance(turned_along.rowwise() - shift, along), 1e-9 * mesh.diagonal());
        }
    }
}

TEST(PrincipalAxes, AreThoseOfTheCoordinatesWhereNoneAreDistinct) {
    EXPECT_EQ(principal_axes(bar(4, 20).vertices, Execution()), Matrix3::Identity());
    EXPECT_EQ(principal_axes(sphere(2).vertices, Execution()), Matrix3::Identity());
    EXPECT_EQ(principal_axes(Positions::Constant(5, 3, 1.0), Execution()), Matrix3::Identity());
}

}  // namespace
}  // namespace meanvalue::tests
