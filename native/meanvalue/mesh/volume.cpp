#include "meanvalue/mesh/volume.h"

#include "meanvalue/common/tolerances.h"

namespace meanvalue {

double signed_volume(const PositionsView& positions, const TrianglesView& faces) {
    if (positions.rows() == 0) return 0.0;
    const Vector3 origin = positions.row(0);
    double sum = 0.0;
    for (Index f = 0; f < faces.rows(); ++f) {
        const auto corner = [&](int c) -> Vector3 { return Vector3(positions.row(faces(f, c))) - origin; };
        sum += corner(0).dot(corner(1).cross(corner(2)));
    }
    return sum / 6.0;
}

bool is_closed(const PositionsView& positions, const TrianglesView& faces) {
    Vector3 sum = Vector3::Zero();
    double size = 0.0;
    for (Index f = 0; f < faces.rows(); ++f) {
        const Vector3 corner = positions.row(faces(f, 0));
        const Vector3 area =
            (Vector3(positions.row(faces(f, 1))) - corner).cross(Vector3(positions.row(faces(f, 2))) - corner);
        sum += area;
        size += area.norm();
    }
    return sum.norm() <= kNegligible * size;
}

}  // namespace meanvalue
