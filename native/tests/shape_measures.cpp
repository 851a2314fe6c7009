#include "tests/shape_measures.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/linalg/procrustes.h"

namespace meanvalue::tests {
namespace {

Vector3 corner(const Positions& shape, const Triangles& faces, Index face, int k) {
    return shape.row(faces(face, k % 3));
}

Vector3 normal(const Positions& shape, const Triangles& faces, Index face) {
    const Vector3 a = corner(shape, faces, face, 0);
    return (corner(shape, faces, face, 1) - a).cross(corner(shape, faces, face, 2) - a);
}

}  // namespace

double volume_of(const Positions& shape, const Triangles& faces) {
    double sum = 0.0;
    for (Index face = 0; face < faces.rows(); ++face) {
        sum += corner(shape, faces, face, 0).dot(corner(shape, faces, face, 1).cross(corner(shape, faces, face, 2)));
    }
    return sum / 6.0;
}

Index flipped_triangles(const Positions& shape, const Mesh& rest) {
    std::vector<Matrix3> moments(rest.vertex_count(), Matrix3::Zero());
    for (Index face = 0; face < rest.faces.rows(); ++face) {
        for (int k = 0; k < 3; ++k) {
            const Matrix3 product =
                (corner(shape, rest.faces, face, k + 1) - corner(shape, rest.faces, face, k)) *
                (corner(rest.vertices, rest.faces, face, k + 1) - corner(rest.vertices, rest.faces, face, k))
                    .transpose();
            moments[rest.faces(face, k)] += product;
            moments[rest.faces(face, (k + 1) % 3)] += product;
        }
    }
    Index count = 0;
    for (Index face = 0; face < rest.faces.rows(); ++face) {
        Matrix3 sum = Matrix3::Zero();
        for (int k = 0; k < 3; ++k)
            sum += fit_rotation(moments[rest.faces(face, k)]);
        const Vector3 expected = fit_rotation(sum) * normal(rest.vertices, rest.faces, face);
        if (expected.dot(normal(shape, rest.faces, face)) <= 0.0) ++count;
    }
    return count;
}

Strain strain_of(const Positions& shape, const Mesh& rest) {
    Strain strain;
    for (Index face = 0; face < rest.faces.rows(); ++face) {
        for (int k = 0; k < 3; ++k) {
            const double before =
                (corner(rest.vertices, rest.faces, face, k + 1) - corner(rest.vertices, rest.faces, face, k)).norm();
            const double after = (corner(shape, rest.faces, face, k + 1) - corner(shape, rest.faces, face, k)).norm();
            const double change = std::abs(after / before - 1.0);
            strain.largest = std::max(strain.largest, change);
            strain.mean += change / (3.0 * rest.faces.rows());
        }
    }
    return strain;
}

double turn_about_z(const Positions& shape, const Positions& rest, const std::vector<Index>& rows) {
    Positions from = rows_of(rest, rows);
    Positions to = rows_of(shape, rows);
    from.rowwise() -= from.colwise().mean().eval();
    to.rowwise() -= to.colwise().mean().eval();
    double sine = 0.0;
    double cosine = 0.0;
    for (Eigen::Index k = 0; k < from.rows(); ++k) {
        cosine += from(k, 0) * to(k, 0) + from(k, 1) * to(k, 1);
        sine += from(k, 0) * to(k, 1) - from(k, 1) * to(k, 0);
    }
    return std::atan2(sine, cosine);
}

}  // namespace meanvalue::tests
