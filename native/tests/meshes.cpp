#include "tests/meshes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <tuple>
#include <utility>

namespace meanvalue::tests {
namespace {

Mesh from_lists(std::string name, const std::vector<Vector3>& vertices,
                const std::vector<Eigen::Matrix<Index, 1, 3>>& faces) {
    Mesh mesh;
    mesh.name = std::move(name);
    mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
    mesh.faces.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t k = 0; k < vertices.size(); ++k)
        mesh.vertices.row(k) = vertices[k];
    for (std::size_t k = 0; k < faces.size(); ++k)
        mesh.faces.row(k) = faces[k];
    return mesh;
}

double shortest_edge(const Mesh& mesh) {
    double shortest = mesh.diagonal();
    for (Index f = 0; f < mesh.faces.rows(); ++f) {
        for (int k = 0; k < 3; ++k) {
            const auto edge = mesh.vertices.row(mesh.faces(f, k)) - mesh.vertices.row(mesh.faces(f, (k + 1) % 3));
            shortest = std::min(shortest, edge.norm());
        }
    }
    return shortest;
}

}  // namespace

double Mesh::diagonal() const {
    return (vertices.colwise().maxCoeff() - vertices.colwise().minCoeff()).norm();
}

Mesh triangle() {
    return from_lists("triangle", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
}

Mesh strip() {
    return from_lists("strip", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.3}, {0, 1, 0.1}}, {{0, 1, 2}, {0, 2, 3}});
}

Mesh grid(Index columns, Index rows, double height) {
    std::vector<Vector3> vertices;
    std::vector<Eigen::Matrix<Index, 1, 3>> faces;
    for (Index r = 0; r < rows; ++r) {
        for (Index c = 0; c < columns; ++c)
            vertices.emplace_back(c, r, height * c * r);
    }
    for (Index r = 0; r + 1 < rows; ++r) {
        for (Index c = 0; c + 1 < columns; ++c) {
            const Index v = r * columns + c;
            faces.push_back({v, v + 1, v + columns + 1});
            faces.push_back({v, v + columns + 1, v + columns});
        }
    }
    return from_lists("grid", vertices, faces);
}

std::vector<char> inside_grid(Index columns, Index rows, Index margin) {
    std::vector<char> inside(columns * rows, 0);
    for (Index r = margin; r < rows - margin; ++r) {
        for (Index c = margin; c < columns - margin; ++c)
            inside[r * columns + c] = 1;
    }
    return inside;
}

Mesh torus(Index around, Index across) {
    std::vector<Vector3> vertices;
    std::vector<Eigen::Matrix<Index, 1, 3>> faces;
    for (Index a = 0; a < around; ++a) {
        for (Index b = 0; b < across; ++b) {
            const double u = 2 * kPi * a / around;
            const double v = 2 * kPi * b / across;
            const double radius = 3 + std::cos(v);
            vertices.emplace_back(radius * std::cos(u), radius * std::sin(u), std::sin(v));
            const Index a_next = (a + 1) % around;
            const Index b_next = (b + 1) % across;
            const Index corners[] = {a * across + b, a_next * across + b, a_next * across + b_next,
                                     a * across + b_next};
            faces.push_back({corners[0], corners[1], corners[2]});
            faces.push_back({corners[0], corners[2], corners[3]});
        }
    }
    return from_lists("torus", vertices, faces);
}

Mesh capped_tube(Index around, Index along, double length) {
    std::vector<Vector3> vertices;
    std::vector<Eigen::Matrix<Index, 1, 3>> faces;
    for (Index a = 0; a < along; ++a) {
        for (Index b = 0; b < around; ++b) {
            const double angle_rad = 2 * kPi * b / around;
            vertices.emplace_back(std::cos(angle_rad), std::sin(angle_rad), length * a / (along - 1));
            if (a + 1 == along) continue;
            const Index next = (b + 1) % around;
            faces.push_back({a * around + b, a * around + next, (a + 1) * around + next});
            faces.push_back({a * around + b, (a + 1) * around + next, (a + 1) * around + b});
        }
    }
    const Index bottom = along * around;
    vertices.emplace_back(0, 0, -0.1);
    vertices.emplace_back(0, 0, length + 0.1);
    for (Index b = 0; b < around; ++b) {
        const Index next = (b + 1) % around;
        faces.push_back({bottom, next, b});
        faces.push_back({bottom + 1, (along - 1) * around + b, (along - 1) * around + next});
    }
    return from_lists("capped tube", vertices, faces);
}

Mesh bar(Index across, Index along) {
    std::vector<Vector3> vertices;
    std::vector<Eigen::Matrix<Index, 1, 3>> faces;
    std::map<std::tuple<Index, Index, Index>, Index> numbers;
    const auto vertex = [&](Index x, Index y, Index z) {
        const auto [place, is_new] = numbers.try_emplace({z, y, x}, static_cast<Index>(vertices.size()));
        if (is_new) vertices.push_back(Vector3(x, y, z) / across);
        return place->second;
    };
    const auto add_square = [&](Index a, Index b, Index c, Index d) {
        faces.push_back({a, b, c});
        faces.push_back({a, c, d});
    };
    for (Index k = 0; k < across; ++k) {
        for (Index z = 0; z < along; ++z) {
            const Index w = across;
            add_square(vertex(k, 0, z), vertex(k + 1, 0, z), vertex(k + 1, 0, z + 1), vertex(k, 0, z + 1));
            add_square(vertex(w, k, z), vertex(w, k + 1, z), vertex(w, k + 1, z + 1), vertex(w, k, z + 1));
            add_square(vertex(k + 1, w, z), vertex(k, w, z), vertex(k, w, z + 1), vertex(k + 1, w, z + 1));
            add_square(vertex(0, k + 1, z), vertex(0, k, z), vertex(0, k, z + 1), vertex(0, k + 1, z + 1));
        }
        for (Index x = 0; x < across; ++x) {
            const Index y = k;
            add_square(vertex(x, y, 0), vertex(x, y + 1, 0), vertex(x + 1, y + 1, 0), vertex(x + 1, y, 0));
            add_square(vertex(x, y, along), vertex(x + 1, y, along), vertex(x + 1, y + 1, along),
                       vertex(x, y + 1, along));
        }
    }
    return from_lists("bar", vertices, faces);
}

Mesh sphere(int levels) {
    std::vector<Vector3> vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    std::vector<Eigen::Matrix<Index, 1, 3>> faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                     {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<Index, Index>, Index> middles;
        const auto middle = [&](Index a, Index b) {
            const auto edge = std::minmax(a, b);
            const auto [place, is_new] = middles.try_emplace({edge.first, edge.second}, 0);
            if (is_new) {
                place->second = static_cast<Index>(vertices.size());
                vertices.push_back((vertices[a] + vertices[b]).normalized());
            }
            return place->second;
        };
        std::vector<Eigen::Matrix<Index, 1, 3>> finer;
        for (const auto& face : faces) {
            const Index a = middle(face(0), face(1));
            const Index b = middle(face(1), face(2));
            const Index c = middle(face(2), face(0));
            finer.push_back({face(0), a, c});
            finer.push_back({face(1), b, a});
            finer.push_back({face(2), c, b});
            finer.push_back({a, b, c});
        }
        faces = std::move(finer);
    }
    return from_lists("sphere", vertices, faces);
}

Mesh needles() {
    Mesh mesh = with_noise(grid(12, 12, 0.02), 0.2, 3);
    mesh.vertices.col(1) *= 1e-3;
    mesh.name = "needles";
    return mesh;
}

Mesh random_fan(Index valence, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Mesh mesh{"fan", Positions(valence + 1, 3), Triangles(valence, 3)};
    mesh.vertices.row(0) << 0.1 * uniform(random), 0.1 * uniform(random), 0.5 * uniform(random);
    for (Index k = 0; k < valence; ++k) {
        const double angle_rad = 2 * kPi * (k + 0.3 * uniform(random)) / valence;
        const double radius = 1.0 + 0.3 * uniform(random);
        mesh.vertices.row(k + 1) << radius * std::cos(angle_rad), radius * std::sin(angle_rad), 0.3 * uniform(random);
        mesh.faces.row(k) << 0, k + 1, (k + 1) % valence + 1;
    }
    return mesh;
}

Mesh with_noise(Mesh mesh, double share, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> deviate(0.0, share * shortest_edge(mesh));
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        for (int k = 0; k < 3; ++k)
            mesh.vertices(v, k) += deviate(random);
    }
    mesh.name = "noisy " + mesh.name;
    return mesh;
}

Mesh joined(const Mesh& a, const Mesh& b) {
    Mesh mesh;
    mesh.name = a.name + " and " + b.name;
    mesh.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
    mesh.vertices << a.vertices, b.vertices;
    mesh.faces.resize(a.faces.rows() + b.faces.rows(), 3);
    mesh.faces << a.faces, (b.faces.array() + a.vertex_count()).matrix();
    return mesh;
}

std::vector<Mesh> all_classes() {
    Mesh flat = grid(7, 6, 0.0);
    flat.name = "flat grid";
    return {sphere(3),
            grid(9, 8, 0.05),
            flat,
            torus(24, 12),
            with_noise(sphere(3), 0.1, 1),
            with_noise(torus(24, 12), 0.3, 2),
            strip(),
            triangle(),
            needles(),
            capped_tube(160, 12, 4.0),
            joined(sphere(2), grid(5, 5, 0.1))};
}

Positions moved_by_similarity(const Positions& vertices, double scale, const Vector3& axis, double angle_rad,
                              const Vector3& translation) {
    const Matrix3 rotation = Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
    return (scale * vertices * rotation.transpose()).rowwise() + translation.transpose();
}

std::vector<Index> spread_vertices(const Mesh& mesh, Index count) {
    std::vector<Index> chosen = {0};
    Eigen::VectorXd distance = (mesh.vertices.rowwise() - mesh.vertices.row(0)).rowwise().norm();
    while (static_cast<Index>(chosen.size()) < count) {
        Eigen::Index farthest = 0;
        distance.maxCoeff(&farthest);
        chosen.push_back(static_cast<Index>(farthest));
        distance = distance.cwiseMin((mesh.vertices.rowwise() - mesh.vertices.row(farthest)).rowwise().norm());
    }
    return chosen;
}

std::vector<char> flags(Index count, const std::vector<Index>& set) {
    std::vector<char> result(count, 0);
    for (const Index v : set)
        result[v] = 1;
    return result;
}

Positions rows_of(const Positions& vertices, const std::vector<Index>& rows) {
    Positions result(static_cast<Eigen::Index>(rows.size()), 3);
    for (std::size_t k = 0; k < rows.size(); ++k)
        result.row(k) = vertices.row(rows[k]);
    return result;
}

}  // namespace meanvalue::tests
