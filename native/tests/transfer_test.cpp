// Shape keys on a mesh of other faces and proportions.
#include "meanvalue/transfer/transfer.h"

#include <cmath>
#include <limits>
#include <random>

#include "meanvalue/mesh/triangle_tree.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// Points of the unit square, which `shape` places in space.
Mesh square(Index columns, Index rows) {
    Mesh mesh = grid(columns, rows, 0.0);
    mesh.vertices.col(0) /= columns - 1;
    mesh.vertices.col(1) /= rows - 1;
    return mesh;
}

template <typename Place>
Positions placed(const Positions& square, const Place& place) {
    Positions result = square;
    for (Index v = 0; v < square.rows(); ++v)
        result.row(v) = place(square(v, 0), square(v, 1)).transpose();
    return result;
}

/// A face of sorts: a hill with a ridge.
Vector3 face(double x, double y) {
    return {x, y, 0.3 * std::sin(kPi * x) * std::sin(kPi * y) + 0.1 * std::exp(-40.0 * std::pow(x - 0.5, 2))};
}

/// A key that slides, turns and leaves a half where it is.
Vector3 smile(double x, double y) {
    const double fade = std::pow(std::max(0.0, 2.0 * x - 1.0), 2) * std::sin(kPi * y);
    return face(x, y) + fade * Vector3(0.1, 0.2 * (x - 0.5), 0.02);
}

/// A mouth: two plates, joined at their back, whose gap is `gap` times its rest at the front.
Vector3 mouth(double x, double y, double gap) {
    const double along = 4.0 * std::abs(y - 0.5), depth = 1.0 - std::min(along, 1.0);
    const double front = std::clamp((along - 1.0) / 1.0, 0.0, 1.0);
    const double opening = 0.3 * std::min(along, 1.0) * (1.0 - (1.0 - gap) * front * std::sin(kPi * x));
    return {1.0 - x, std::max(along - 1.0, 0.0) - 0.2 * depth, y < 0.5 ? -opening : opening};
}

/// Meshes over the same square: m and n are theirs.
struct Case {
    Mesh source, target;
    TransferBinding binding;

    Case(Index m, Index n, double off = 0.0) : source(square(m, m)), target(square(n, n)) {
        const std::vector<Index> part(source.vertex_count(), 0);
        const TriangleTree tree(source.vertices, source.faces, part, Execution());
        std::mt19937 random(7);
        binding.weights.resize(target.vertex_count(), 3);
        for (Index v = 0; v < target.vertex_count(); ++v) {
            Vector3 point = target.vertices.row(v);
            for (int k : {0, 1})
                point[k] += off * (static_cast<double>(random()) / static_cast<double>(random.max()) - 0.5);
            const TriangleTree::Place place = tree.nearest({point}, 1.0);
            binding.faces.push_back(place.triangle);
            binding.weights.row(v) = place.weights;
        }
    }

    /// At the vertices of the target.
    Positions there(const Positions& positions) const {
        Positions result(target.vertex_count(), 3);
        for (Index v = 0; v < result.rows(); ++v)
            result.row(v) = binding.weights.row(v) * positions(source.faces.row(binding.faces[v]), Eigen::all);
        return result;
    }

    Positions carried(const Positions& rest, const std::vector<Positions>& shapes, const Positions& onto,
                      bool closes = true, int threads = 1) {
        binding.source_rest = share(rest, "");
        binding.target_rest = share(onto, "");
        binding.source_faces = share(source.faces, "");
        binding.target_faces = share(target.faces, "");
        binding.threads = threads;
        std::vector<SharedPositions> shared;
        shared.reserve(shapes.size());
        for (const Positions& shape : shapes)
            shared.push_back(share(shape, ""));
        Execution execution;
        return transfer(binding, shared, std::vector<char>(shapes.size(), closes), execution);
    }
};

TEST(Transfer, IsTheKeyItselfOnTheSameFaceOfOtherFaces) {
    for (const Index n : {17, 52}) {  // a third and three times the vertices
        Case meshes(30, n);
        const Positions rest = placed(meshes.source.vertices, face), shape = placed(meshes.source.vertices, smile);
        EXPECT_LT(largest_distance(meshes.carried(rest, {shape}, meshes.there(rest)), meshes.there(shape)), 1e-9);
    }
}

TEST(Transfer, GoesAlongWithSimilarities) {
    Case meshes(30, 23);
    for (const auto& [open, closed] : {std::pair(1.0, 0.03), std::pair(1.0, 0.5)}) {
        const auto at = [&](double gap) {
            return placed(meshes.source.vertices, [&](double x, double y) { return mouth(x, y, gap); });
        };
        const auto moved = [&](const Positions& positions) {
            return moved_by_similarity(meshes.there(positions), 2.5, {1.0, 2.0, -1.0}, 1.9, {30.0, -7.0, 11.0});
        };
        const Positions found = meshes.carried(at(open), {at(closed)}, moved(at(open)));
        EXPECT_LT(largest_distance(found, moved(at(closed))), 1e-6);
    }
}

TEST(Transfer, StretchesWithTheFace) {
    Case meshes(40, 33);
    const Positions rest = placed(meshes.source.vertices, face), shape = placed(meshes.source.vertices, smile);
    const auto stretched = [&](const Positions& positions) {
        Positions result = meshes.there(positions);
        result.col(1) *= 1.5;
        return result;
    };
    const Positions onto = stretched(rest), wanted = stretched(shape);
    const Positions found = meshes.carried(rest, {shape}, onto);
    const Eigen::VectorXd moves = (wanted - onto).rowwise().norm(), off = (found - wanted).rowwise().norm();
    double sum = 0.0, count = 0.0;
    for (Index v = 0; v < off.size(); ++v) {
        if (moves[v] == 0.0) {
            EXPECT_EQ(found.row(v), onto.row(v)) << v;  // to the bit
        } else {
            sum += off[v];
            ++count;
        }
    }
    EXPECT_GT(count, 0.4 * off.size());
    EXPECT_LT(count, 0.6 * off.size());
    EXPECT_LT(sum / count, 0.02 * moves.maxCoeff());
}

TEST(Transfer, ClosesWhatTheSourceCloses) {
    constexpr double kGap = 0.03;
    Case meshes(60, 47);
    const auto at = [&](double gap, double height) {
        Positions result = placed(meshes.source.vertices, [&](double x, double y) { return mouth(x, y, gap); });
        result.col(2) *= height;
        return result;
    };
    const auto gap_of = [&](const Positions& positions) {  // at the front, in the middle
        const Index n = 47, middle = n / 2;
        return positions((n - 1) * n + middle, 2) - positions(middle, 2);
    };
    const Positions rest = at(1.0, 1.0), shape = at(kGap, 1.0), taller = meshes.there(at(1.0, 2.0));
    const double there = gap_of(meshes.there(shape));
    const double closed = gap_of(meshes.carried(rest, {shape}, taller));
    const double plain = gap_of(meshes.carried(rest, {shape}, taller, false));
    EXPECT_NEAR(closed, there, 0.02 * gap_of(taller));
    EXPECT_GT(std::abs(plain - there), 3.0 * std::abs(closed - there));
}

TEST(Transfer, KeepsRigidPartsRigid) {
    const Mesh eye = sphere(3);
    const auto both = [&](const Mesh& face, const Positions& ball) {
        Mesh mesh = joined(face, eye);
        mesh.vertices.bottomRows(ball.rows()) = ball;
        return mesh;
    };
    const auto turned = [](const Positions& ball, const Vector3& centre, double size) -> Positions {
        return moved_by_similarity(ball, size, {1.0, 0.2, 0.0}, 0.5, centre);
    };
    const Vector3 centre(0.5, 0.5, -1.5), other(0.7, 0.4, -1.2);
    Case meshes(20, 20);
    Mesh skin = meshes.source;
    skin.vertices = placed(skin.vertices, face);
    meshes.source = both(skin, eye.vertices.rowwise() + centre.transpose());
    const Mesh looking = both(skin, turned(eye.vertices, centre, 1.0));
    meshes.target = meshes.source;
    // Of other size, in another place, and squeezed; a few of its vertices were found on the face.
    Positions squeezed = 0.6 * eye.vertices;
    squeezed.col(0) *= 0.7;
    meshes.target.vertices.bottomRows(eye.vertex_count()) = squeezed.rowwise() + other.transpose();
    Positions weights = Positions::Zero(meshes.target.vertex_count(), 3);
    meshes.binding.faces.assign(weights.rows(), 0);
    for (Index f = 0; f < meshes.source.faces.rows(); ++f) {
        for (int k = 0; k < 3; ++k) {
            const Index v = meshes.source.faces(f, k);
            meshes.binding.faces[v] = v + 5 < weights.rows() ? f : 0;
            weights.row(v) = Vector3::Unit(v + 5 < weights.rows() ? k : 0).transpose();
        }
    }
    meshes.binding.weights = weights;
    const Positions found = meshes.carried(meshes.source.vertices, {looking.vertices}, meshes.target.vertices);
    EXPECT_EQ(found.topRows(400), meshes.target.vertices.topRows(400));
    const Positions ball = found.bottomRows(eye.vertex_count());
    for (Index v = 1; v < eye.vertex_count(); ++v)
        EXPECT_NEAR((ball.row(v) - ball.row(0)).norm(), (squeezed.row(v) - squeezed.row(0)).norm(), 1e-9);
    EXPECT_GT(largest_distance(ball, meshes.target.vertices.bottomRows(eye.vertex_count())), 0.1);
}

TEST(Transfer, TurnsNoTriangleOverWherePlacesAreOff) {
    Case meshes(40, 60, 0.004);
    const Positions rest = placed(meshes.source.vertices, face), shape = placed(meshes.source.vertices, smile);
    const Positions onto = placed(meshes.target.vertices, [](double x, double y) -> Vector3 {
        return face(x, y).cwiseProduct(Vector3(1.0, 1.4, 0.8));
    });
    const Positions found = meshes.carried(rest, {shape}, onto);
    for (Index f = 0; f < meshes.target.faces.rows(); ++f) {
        const auto normal = [&](const Positions& positions) {
            const auto corner = [&](int k) -> Vector3 { return positions.row(meshes.target.faces(f, k)); };
            return (corner(1) - corner(0)).cross(corner(2) - corner(0)).eval();
        };
        EXPECT_GT(normal(found).dot(normal(onto)), 0.0) << f;
    }
}

TEST(Transfer, GivesTheSameBitsForAnyThreadsAndRestForAKeyOfNoSize) {
    Case meshes(30, 37);
    const auto at = [&](double gap) {
        return placed(meshes.source.vertices, [&](double x, double y) { return mouth(x, y, gap); });
    };
    Positions onto = meshes.there(at(1.0));
    onto.col(2) *= 1.7;
    const std::vector<Positions> shapes = {at(0.03), at(1.0), at(0.6), at(0.01)};
    const Positions one = meshes.carried(at(1.0), shapes, onto, true, 1);
    EXPECT_EQ(one, meshes.carried(at(1.0), shapes, onto, true, 3));
    EXPECT_EQ(one.middleRows(onto.rows(), onto.rows()), onto);
    EXPECT_EQ(one.topRows(onto.rows()), meshes.carried(at(1.0), {shapes[0]}, onto));
}

TEST(Transfer, TakesMeshesAsTheyCome) {
    Case meshes(20, 20);
    Positions rest = placed(meshes.source.vertices, face), shape = placed(meshes.source.vertices, smile);
    Positions onto = meshes.there(rest);
    onto.row(210) = onto.row(211);  // faces without area
    meshes.binding.faces[150] = meshes.binding.faces[151];
    meshes.binding.weights.row(150) = meshes.binding.weights.row(151);  // and places without
    Positions loose(onto.rows() + 1, 3);                                // a vertex without a face
    loose << onto, 5.0, 5.0, 5.0;
    meshes.binding.faces.push_back(700);
    meshes.binding.weights.conservativeResize(loose.rows(), 3);
    meshes.binding.weights.bottomRows(1) << 1.0, 0.0, 0.0;
    const Positions found = meshes.carried(rest, {shape}, loose);
    EXPECT_TRUE(found.allFinite());
    EXPECT_LT(largest_distance(found, loose), 2.0 * largest_distance(shape, rest));
}

TEST(Transfer, TakesPartsWithoutArea) {
    Case meshes(20, 21);
    const Positions rest = placed(meshes.source.vertices, face), onto = meshes.there(rest);
    const auto count = static_cast<Index>(onto.rows());
    Positions more(count + 4, 3);  // a line of two faces, on its own
    more << onto, onto.row(0), onto.row(1), 0.5 * (onto.row(0) + onto.row(1)), 0.3 * onto.row(0) + 0.7 * onto.row(1);
    Triangles& faces = meshes.target.faces;
    faces.conservativeResize(faces.rows() + 2, 3);
    faces.bottomRows(2) << count, count + 1, count + 2, count + 1, count + 2, count + 3;
    meshes.binding.faces.resize(more.rows(), 0);
    meshes.binding.weights.conservativeResize(more.rows(), 3);
    meshes.binding.weights.bottomRows(4).rowwise() = meshes.binding.weights.row(0).eval();
    const auto up = [](const Positions& from) -> Positions {
        return from.rowwise() + Vector3(0, 0, 0.5).transpose();
    };
    EXPECT_LT(largest_distance(meshes.carried(rest, {up(rest)}, more), up(more)), 1e-6);
}

TEST(Transfer, CanBeCancelledEverywhere) {
    Case meshes(12, 14);
    const auto at = [&](double gap) {
        return placed(meshes.source.vertices, [&](double x, double y) { return mouth(x, y, gap); });
    };
    const Positions rest = at(1.0), onto = meshes.there(rest), once = meshes.carried(rest, {at(0.03)}, onto);
    const std::vector<SharedPositions> shapes = {share(at(0.03), "")};
    Positions found;
    EXPECT_EQ(
        cancelled_everywhere([&](Execution& execution) { found = transfer(meshes.binding, shapes, {1}, execution); }),
        (std::vector<std::string>{"", "shapes"}));
    EXPECT_EQ(found, once);
}

TEST(Transfer, NamesWhatIsWrong) {
    Case meshes(6, 5);
    const Positions rest = placed(meshes.source.vertices, face), onto = meshes.there(rest);
    const TransferBinding good = (meshes.carried(rest, {rest}, onto), meshes.binding);
    const auto told = [&](const auto& spoil, const std::vector<Positions>& shapes) {
        meshes.binding = good;
        spoil(meshes.binding);
        std::vector<SharedPositions> shared;
        shared.reserve(shapes.size());
        for (const Positions& shape : shapes)
            shared.push_back(share(shape, ""));
        Execution execution;
        return message_of<InvalidInput>(
            [&] { transfer(meshes.binding, shared, std::vector<char>(shapes.size(), 1), execution); });
    };
    const auto nothing = [](TransferBinding&) {};
    Positions broken = rest;
    broken(3, 1) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(contains(told(nothing, {rest, broken}), "source_shapes[1]"));
    EXPECT_TRUE(contains(told(nothing, {rest.topRows(4)}), "source_shapes[0] has 4 rows"));
    EXPECT_TRUE(contains(told(nothing, {}), "source_shapes is empty"));
    EXPECT_TRUE(contains(told([](auto& b) { b.faces[7] = 50; }, {rest}), "face 50 and weights"));
    EXPECT_TRUE(contains(told([](auto& b) { b.faces.pop_back(); }, {rest}), "correspondence[0] has 24 faces"));
    EXPECT_TRUE(contains(told([](auto& b) { b.weights(2, 0) += 0.5; }, {rest}), "with the sum 1"));
    EXPECT_TRUE(contains(told([](auto& b) { b.weights(2, 0) = 0.0 / 0.0; }, {rest}), "nan"));
    EXPECT_TRUE(contains(told([](auto& b) { b.target_faces = share(Triangles(0, 3), ""); }, {rest}), "target_faces"));
    EXPECT_TRUE(
        contains(told([&](auto& b) { b.target_rest = share(broken.topRows(25), ""); }, {rest}), "target_rest"));
    EXPECT_TRUE(
        contains(told([](auto& b) { b.faces.assign(25, 3), b.weights.rowwise() = b.weights.row(0).eval(); }, {rest}),
                 "leaves no area"));
}

}  // namespace
}  // namespace meanvalue::tests
