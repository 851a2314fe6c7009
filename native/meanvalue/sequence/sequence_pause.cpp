// Standing still between two frames, and going on from there.
#include "meanvalue/common/errors.h"
#include "meanvalue/sequence/sequence_solve.h"

namespace meanvalue {
namespace {

// Of what any pass() writes: to be raised with each change of that.
constexpr double kStateFormat = 1.0;

}  // namespace

Sequence SequenceSolve::paused() {
    Archive archive;
    std::size_t expected = std::size_t{1} << 16;
    for (const Run& run : runs_) {
        const auto frames = static_cast<std::size_t>(run.end - run.begin);
        expected += frames * numbers_of_shape() * sizeof(float) + run.drag.size() +
                    static_cast<std::size_t>(run.shape.size()) * sizeof(double);
    }
    archive.expect(expected);
    pass(archive);
    result_.state = archive.finish();
    result_.vertices.reset();
    result_.solved.assign(result_.frame_count, 0);
    for (const Run& run : runs_) {
        for (Index frame = run.begin; frame < (run.is_done ? run.end : run.next()); ++frame)
            if (is_told_by(run, frame)) result_.solved[frame - plan_.begin()] = 1;
    }
    return std::move(result_);
}

/// Writes how far all runs are, or reads it back. @throws InvalidInput if it is of something else.
void SequenceSolve::pass(Archive& archive) {
    std::uint64_t of_what = identity();
    archive.pass(of_what);
    if (of_what != identity())
        throw InvalidInput("what was kept is of another clip, mesh or part; solve its frames from the beginning");
    for (Run& run : runs_)
        pass(archive, run);
    for (const auto& seam : seams_)
        seam->pass(archive, numbers_of_shape());
    archive.pass(result_.energies);
    archive.pass(result_.iterations);
    archive.pass(result_.converged);
    result_.failures.resize(archive.pass_count(result_.failures.size(), sizeof(std::uint64_t)));
    for (FrameFailure& failure : result_.failures) {
        archive.pass(failure.frame);
        archive.pass(failure.message);
    }
    std::int64_t solved = frames_solved_;
    archive.pass(solved);
    frames_solved_ = solved;
}

void SequenceSolve::pass(Archive& archive, Run& run) {
    archive.pass(run.is_done);
    archive.pass(run.is_solved);
    archive.pass(run.shape);
    archive.pass(run.drag);
    const auto gone_through = static_cast<Index>(run.is_solved.size());
    archive.require(gone_through <= run.end - run.begin &&
                    (run.shape.rows() == 0 || run.shape.rows() == result_.vertex_count));
    for (Index k = 0; k < gone_through; ++k) {
        if (archive.is_reading()) add_frame(run, is_told_by(run, run.begin + k));
        archive.pass(run.shapes[k], numbers_of_shape());
    }
    for (Index frame = run.begin; run.is_done && frame < run.end; ++frame)
        if (is_told_by(run, frame)) archive.pass(row(frame), numbers_of_shape());
}

/// Of all that the bits of the wanted frames depend on, and what is kept of them.
std::uint64_t SequenceSolve::identity() const {
    const double numbers[] = {kStateFormat,
                              static_cast<double>(plan_.begin()),
                              static_cast<double>(plan_.end()),
                              static_cast<double>(options_.chunk),
                              static_cast<double>(options_.overlap),
                              static_cast<double>(options_.max_iterations),
                              options_.tolerance.value_or(0.0)};
    std::uint64_t sum = checksum_of(numbers, sizeof numbers, deformer_.bound().identity());
    const auto add = [&](const auto& values) {
        sum = checksum_of(values.data(), static_cast<std::size_t>(values.size()) * sizeof(*values.data()), sum);
    };
    add(deformer_.report().level_sizes);
    add(trajectories_.targets);
    add(trajectories_.weights);
    return sum;
}

}  // namespace meanvalue
