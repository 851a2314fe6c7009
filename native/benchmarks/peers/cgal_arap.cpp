// SPDX-License-Identifier: MPL-2.0
// CGAL's surface mesh deformation on a job folder (job.py), and its count of self-intersections.
//
//   cgal_arap spokes_and_rims|sre FOLDER ITERATIONS FRAME_SECONDS LEAST_STEPS
//   cgal_arap intersections FOLDER      prints, for each shape of shapes.bin, the pairs of triangles that intersect
//
// Every vertex is in CGAL's region and the anchors are its control vertices. deform() goes on from the last answer
// unless the step says that it starts at rest. Tolerance 0: all iterations are done.
#include <CGAL/Eigen_solver_traits.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_deformation.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

constexpr int kRestart = 1, kKeep = 2;

using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using EigenMatrix = CGAL::Eigen_sparse_matrix<double>::EigenType;

// The linear solver that CGAL is given. Its matrix has the row of the identity for each control vertex and is not
// symmetric, so its default is SparseLU, and Eigen's SimplicialLDLT on the whole of it gives wrong answers. This one
// takes the control vertices out, whose positions are the right-hand side itself; what is left is symmetric and
// positive definite, and its LDLT is the fastest that CGAL can have.
class FreeBlockLdlt {
  public:
    using Matrix = CGAL::Eigen_sparse_matrix<double>;
    using Vector = CGAL::Eigen_vector<double>;
    using NT = double;

    bool factor(const Matrix& matrix, double& determinant) {
        determinant = 1;
        const EigenMatrix& all = matrix.eigen_object();
        const Eigen::VectorXi per_row = row_counts(all);
        place_.assign(static_cast<std::size_t>(all.rows()), -1);
        int free_count = 0;
        for (int row = 0; row < all.rows(); ++row) {
            if (per_row[row] > 1) place_[static_cast<std::size_t>(row)] = free_count++;
        }
        std::vector<Eigen::Triplet<double>> free_part, fixed_part;
        for (int column = 0; column < all.outerSize(); ++column) {
            const int to = place_[static_cast<std::size_t>(column)];
            for (EigenMatrix::InnerIterator entry(all, column); entry; ++entry) {
                const int row = place_[static_cast<std::size_t>(entry.row())];
                if (row < 0) continue;
                (to < 0 ? fixed_part : free_part).emplace_back(row, to < 0 ? column : to, entry.value());
            }
        }
        EigenMatrix free_block(free_count, free_count);
        free_block.setFromTriplets(free_part.begin(), free_part.end());
        to_fixed_.resize(free_count, all.cols());
        to_fixed_.setFromTriplets(fixed_part.begin(), fixed_part.end());
        ldlt_.compute(free_block);
        return ldlt_.info() == Eigen::Success;
    }

    bool linear_solver(const Vector& right, Vector& solution) {
        const Eigen::VectorXd& given = right.eigen_object();
        Eigen::VectorXd free_right = -(to_fixed_ * given);  // reads the rows of control vertices only
        for (std::size_t row = 0; row < place_.size(); ++row) {
            if (place_[row] >= 0) free_right[place_[row]] += given[static_cast<Eigen::Index>(row)];
        }
        const Eigen::VectorXd free_solution = ldlt_.solve(free_right);
        for (std::size_t row = 0; row < place_.size(); ++row) {
            const auto i = static_cast<Eigen::Index>(row);
            solution[i] = place_[row] >= 0 ? free_solution[place_[row]] : given[i];
        }
        return ldlt_.info() == Eigen::Success;
    }

  private:
    static Eigen::VectorXi row_counts(const EigenMatrix& matrix) {
        Eigen::VectorXi counts = Eigen::VectorXi::Zero(matrix.rows());
        for (int column = 0; column < matrix.outerSize(); ++column) {
            for (EigenMatrix::InnerIterator entry(matrix, column); entry; ++entry)
                ++counts[entry.row()];
        }
        return counts;
    }

    std::vector<int> place_;  // of each row among the free ones, -1 for a control vertex
    EigenMatrix to_fixed_;
    Eigen::SimplicialLDLT<EigenMatrix> ldlt_;
};

template <class T>
std::vector<T> read_array(const std::string& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) throw std::runtime_error("cannot read " + path);
    std::vector<T> values(static_cast<std::size_t>(file.tellg()) / sizeof(T));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
    return values;
}

template <class MeshType>
MeshType build_mesh(const double* xyz, std::size_t vertex_count, const std::vector<int>& faces) {
    using Point = typename MeshType::Point;
    MeshType mesh;
    mesh.reserve(vertex_count, faces.size() / 2, faces.size() / 3);
    for (std::size_t i = 0; i < vertex_count; ++i)
        mesh.add_vertex(Point(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]));
    for (std::size_t f = 0; f < faces.size(); f += 3) {
        using Vertex = typename MeshType::Vertex_index;
        const auto face = mesh.add_face(Vertex(faces[f]), Vertex(faces[f + 1]), Vertex(faces[f + 2]));
        if (face == MeshType::null_face()) throw std::runtime_error("CGAL refuses a face: the mesh is not manifold");
    }
    return mesh;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

long peak_bytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        if (line.rfind("VmHWM:", 0) == 0) return 1024 * std::atol(line.c_str() + 6);
    }
    return 0;
}

void write_list(std::ostream& out, const std::vector<double>& values) {
    out << "[";
    for (std::size_t k = 0; k < values.size(); ++k)
        out << (k ? ", " : "") << values[k];
    out << "]";
}

struct Limits {
    unsigned iterations;
    double frame_seconds;
    std::size_t least_steps;
};

template <CGAL::Deformation_algorithm_tag Tag>
void run_job(const std::string& folder, const Limits& limits) {
    using Deformation =
        CGAL::Surface_mesh_deformation<Mesh, CGAL::Default, CGAL::Default, Tag, CGAL::Default, FreeBlockLdlt>;
    const auto xyz = read_array<double>(folder + "/vertices.bin");
    const auto anchors = read_array<int>(folder + "/anchors.bin");
    const auto plan = read_array<int>(folder + "/plan.bin");
    Mesh mesh = build_mesh<Mesh>(xyz.data(), xyz.size() / 3, read_array<int>(folder + "/faces.bin"));

    auto start = std::chrono::steady_clock::now();
    Deformation deformation(mesh);
    deformation.insert_roi_vertices(vertices(mesh).begin(), vertices(mesh).end());
    for (const int anchor : anchors)
        deformation.insert_control_vertex(Mesh::Vertex_index(anchor));
    if (!deformation.preprocess()) throw std::runtime_error("CGAL's preprocess() failed");
    const double bind_seconds = seconds_since(start);

    std::ifstream targets(folder + "/targets.bin", std::ios::binary);
    std::ofstream shapes(folder + "/shapes.bin", std::ios::binary);
    std::vector<double> step_targets(3 * anchors.size());
    std::vector<double> seconds, cpu_seconds;
    double spent = 0;
    for (std::size_t step = 0; step < plan.size(); ++step) {
        if (spent > limits.frame_seconds && step >= limits.least_steps) break;
        targets.read(reinterpret_cast<char*>(step_targets.data()),
                     static_cast<std::streamsize>(step_targets.size() * sizeof(double)));
        start = std::chrono::steady_clock::now();
        const std::clock_t cpu_start = std::clock();
        if (plan[step] & kRestart) deformation.reset();
        for (std::size_t k = 0; k < anchors.size(); ++k) {
            const double* target = step_targets.data() + 3 * k;
            deformation.set_target_position(Mesh::Vertex_index(anchors[k]),
                                            Kernel::Point_3(target[0], target[1], target[2]));
        }
        deformation.deform(limits.iterations, 0.0);
        seconds.push_back(seconds_since(start));
        cpu_seconds.push_back(static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC);
        spent += seconds.back();
        if (!(plan[step] & kKeep)) continue;
        for (const auto vertex : vertices(mesh)) {
            const auto& point = mesh.point(vertex);
            const double values[3] = {point.x(), point.y(), point.z()};
            shapes.write(reinterpret_cast<const char*>(values), sizeof(values));
        }
    }
    std::ofstream result(folder + "/result.json");
    result.precision(9);
    result << "{\"bind_seconds\": " << bind_seconds << ", \"peak_bytes\": " << peak_bytes() << ", \"seconds\": ";
    write_list(result, seconds);
    result << ", \"cpu_seconds\": ";
    write_list(result, cpu_seconds);
    result << "}";
}

void count_intersections(const std::string& folder) {
    using ExactKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    using ExactMesh = CGAL::Surface_mesh<ExactKernel::Point_3>;
    const auto faces = read_array<int>(folder + "/faces.bin");
    const auto shapes = read_array<double>(folder + "/shapes.bin");
    const std::size_t values = read_array<double>(folder + "/vertices.bin").size();
    for (std::size_t first = 0; first + values <= shapes.size(); first += values) {
        const ExactMesh mesh = build_mesh<ExactMesh>(shapes.data() + first, values / 3, faces);
        std::vector<std::pair<ExactMesh::Face_index, ExactMesh::Face_index>> pairs;
        CGAL::Polygon_mesh_processing::self_intersections(mesh, std::back_inserter(pairs));
        std::cout << pairs.size() << "\n";
    }
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const std::string task = argc > 1 ? argv[1] : "";
        if (task == "intersections" && argc == 3) {
            count_intersections(argv[2]);
            return 0;
        }
        if (argc != 6) throw std::runtime_error("usage: see the head of cgal_arap.cpp");
        const Limits limits{static_cast<unsigned>(std::atoi(argv[3])), std::atof(argv[4]),
                            static_cast<std::size_t>(std::atoi(argv[5]))};
        if (task == "spokes_and_rims") {
            run_job<CGAL::SPOKES_AND_RIMS>(argv[2], limits);
        } else if (task == "sre") {
            run_job<CGAL::SRE_ARAP>(argv[2], limits);
        } else {
            throw std::runtime_error("unknown task " + task);
        }
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
    return 0;
}
