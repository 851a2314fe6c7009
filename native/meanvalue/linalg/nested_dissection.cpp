#include "meanvalue/linalg/nested_dissection.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <utility>

#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/minimum_degree.h"
#include "meanvalue/linalg/separator.h"

namespace meanvalue {
namespace {

// Vertices of a part that is not taken apart further: minimum degree then finds as little fill.
constexpr Index kLeaf = 150;
// A part without a good separator is ordered by minimum degree up to so many vertices, which takes a second.
constexpr Index kLargestLeaf = 4000;

/// A connected piece of the graph, and the places in the order that it is to fill.
struct Part {
    Graph graph;
    std::vector<Index> names;  // of its vertices in the whole graph
    Index place = 0;           // the first
};

/// The parts that wait, for several threads.
class PartQueue {
  public:
    void push(Part part) {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            parts_.push_back(std::move(part));
            ++unfinished_;
        }
        changed_.notify_one();
    }
    /// @return false at the end.
    bool pop(Part& part) {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait(lock, [&] { return stopped_ || unfinished_ == 0 || !parts_.empty(); });
        if (stopped_ || unfinished_ == 0) return false;
        part = std::move(parts_.back());
        parts_.pop_back();
        return true;
    }
    void finish_one() {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            --unfinished_;
        }
        changed_.notify_all();
    }
    void stop() {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            stopped_ = true;
        }
        changed_.notify_all();
    }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<Part> parts_;
    std::size_t unfinished_ = 0;
    bool stopped_ = false;
};

/// What to dissect along.
struct Pattern {
    const DissectionTree& tree;
    const std::vector<Index>& places;  // of each vertex in the order of that
};

/// What one thread works with.
class Dissection {
  public:
    Dissection(const Graph& whole, std::vector<Index>& order, PartQueue& queue, const Pattern* along,
               const Execution& execution)
        : whole_(whole),
          order_(order),
          queue_(queue),
          along_(along),
          execution_(execution),
          local_(whole.size(), -1) {}

    const std::vector<DissectionTree::Part>& parts() const { return parts_; }

    /// Takes apart what is connected of `graph` without its separator, and fills the places of that.
    void split(const Graph& graph, const Separation& separation, const std::vector<Index>& names, Index place) {
        number_.assign(graph.size(), -1);
        for (Index v = 0; v < graph.size(); ++v) {
            execution_.check_every(v);
            if (separation.side[v] == kSeparator || number_[v] >= 0) continue;
            Part part = component_of(graph, separation, v, names);
            part.place = place;
            place += part.graph.size();
            parts_.push_back({part.place, place});
            if (part.graph.size() <= kLeaf) {
                order_leaf(part);
            } else {
                queue_.push(std::move(part));
            }
        }
        for (Index v = 0; v < graph.size(); ++v) {
            if (separation.side[v] == kSeparator) order_[place++] = names[v];
        }
    }

    void dissect(const Part& part) {
        const Separation separation = separate(part);
        if (separation.weight[kLeft] > 0 && separation.weight[kRight] > 0) {
            split(part.graph, separation, part.names, part.place);
        } else if (part.graph.size() <= kLargestLeaf) {
            order_leaf(part);
        } else {
            std::copy(part.names.begin(), part.names.end(), order_.begin() + part.place);
        }
    }

  private:
    Separation separate(const Part& part) {
        if (along_ == nullptr) return finder_.find(part.graph, execution_);
        places_.clear();
        for (const Index name : part.names)
            places_.push_back(along_->places[name]);
        return finder_.find_near(part.graph, along_->tree.separate(part.graph, places_), execution_);
    }

    /// Numbered breadth first: what is near in the graph is near in memory.
    Part component_of(const Graph& graph, const Separation& separation, Index seed, const std::vector<Index>& names) {
        WorkMeter work(execution_);
        queue_of_.assign(1, seed);
        number_[seed] = 0;
        Part part;
        for (std::size_t k = 0; k < queue_of_.size(); ++k) {
            const Index v = queue_of_[k];
            work.add(4 + graph.degree(v));
            for (const Index* u = graph.begin(v); u != graph.end(v); ++u) {
                if (separation.side[*u] == kSeparator) continue;
                if (number_[*u] < 0) {
                    number_[*u] = static_cast<Index>(queue_of_.size());
                    queue_of_.push_back(*u);
                }
                part.graph.neighbours.push_back(number_[*u]);
            }
            part.graph.offsets.push_back(static_cast<std::int64_t>(part.graph.neighbours.size()));
            part.graph.weights.push_back(graph.weights[v]);
            part.names.push_back(names[v]);
        }
        return part;
    }

    void order_leaf(const Part& part) {
        execution_.check();
        const Index inner = part.graph.size();
        around_.assign(part.names.begin(), part.names.end());
        for (Index v = 0; v < inner; ++v)
            local_[part.names[v]] = v;
        for (Index v = 0; v < inner; ++v) {
            for (const Index* u = whole_.begin(part.names[v]); u != whole_.end(part.names[v]); ++u) {
                if (local_[*u] >= 0) continue;
                local_[*u] = static_cast<Index>(around_.size());
                around_.push_back(*u);
            }
        }
        minimum_degree_.reset(inner, static_cast<Index>(around_.size()));
        for (Index v = 0; v < inner; ++v) {
            for (const Index* u = whole_.begin(part.names[v]); u != whole_.end(part.names[v]); ++u)
                minimum_degree_.connect(v, local_[*u]);
        }
        Index place = part.place;
        for (const Index v : minimum_degree_.order())
            order_[place++] = part.names[v];
        for (const Index name : around_)
            local_[name] = -1;
    }

    const Graph& whole_;
    std::vector<Index>& order_;
    PartQueue& queue_;
    const Pattern* along_;
    const Execution& execution_;
    std::vector<DissectionTree::Part> parts_;
    std::vector<Index> places_;
    SeparatorFinder finder_;
    MinimumDegree minimum_degree_;
    std::vector<Index> number_;    // of a vertex in its part
    std::vector<Index> queue_of_;  // the search
    std::vector<Index> local_;     // of a vertex of the whole graph in the leaf and what surrounds it, or -1
    std::vector<Index> around_;    // the leaf and what surrounds it
};

std::vector<Index> dissect(const Graph& graph, const Pattern* along, int threads, const Execution& execution,
                           DissectionTree* tree) {
    std::vector<Index> order(graph.size());
    std::vector<DissectionTree::Part> parts;
    std::mutex mutex;
    PartQueue queue;
    const auto collect = [&](const Dissection& dissection) {
        if (tree == nullptr) return;
        const std::lock_guard<std::mutex> lock(mutex);
        parts.insert(parts.end(), dissection.parts().begin(), dissection.parts().end());
    };
    {
        Separation nothing;
        nothing.side.assign(graph.size(), kLeft);
        std::vector<Index> names(graph.size());
        std::iota(names.begin(), names.end(), 0);
        Dissection dissection(graph, order, queue, along, execution);
        dissection.split(graph, nothing, names, 0);
        collect(dissection);
    }
    run_workers(threads, [&](int) {
        try {
            Dissection dissection(graph, order, queue, along, execution);
            Part part;
            while (queue.pop(part)) {
                execution.check();
                dissection.dissect(part);
                part = Part();
                queue.finish_one();
            }
            collect(dissection);
        } catch (...) {
            queue.stop();
            throw;
        }
    });
    if (tree != nullptr) *tree = DissectionTree(std::move(parts), graph.size());
    return order;
}

}  // namespace

std::vector<Index> nested_dissection(const Graph& graph, int threads, const Execution& execution,
                                     DissectionTree* tree) {
    return dissect(graph, nullptr, threads, execution, tree);
}

std::vector<Index> nested_dissection_along(const DissectionTree& tree, const std::vector<Index>& places,
                                           const Graph& graph, int threads, const Execution& execution) {
    const Pattern along{tree, places};
    return dissect(graph, &along, threads, execution, nullptr);
}

}  // namespace meanvalue
